"""Inferences of synthetic papers, whose open values are known because they were flown here, by the plain way of a study."""

import json
import tomllib
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
import pytest

from plant.quadrotor.scenarios import HELD_OUT, SEARCH
from tests.tables import read_frame
from tests.tuner.experiments.again.killing import assert_covered
from tests.tuner.experiments.inference.asked import (
    CONTENDERS,
    METRICS,
    PUBLISHED_FLIGHTS,
    STUDY,
    TRUTH,
    flown_plainly,
    plain_table,
    published_medians,
    write,
)
from tests.tuner.experiments.inference.conftest import run
from tests.tuner.study.loading import load_contest, load_inference
from tuner.experiments.inference.findings import select_subset
from tuner.experiments.inference.flying import CHUNK, SettingFlyer
from tuner.experiments.inference.misfit import log_ratio, ratio_scores
from tuner.experiments.inference.run import SWEEP
from tuner.study.kinds import kind_of_layers
from tuner.study.layers import read_layers

VALUES = np.array(list(TRUTH.values()))
FILES = (
    "study.toml",
    "environment.json",
    "history.csv",
    "candidates.npz",
    "inference.json",
    "inferred.toml",
    "figures/inference.png",
    "figures/inference.pdf",
    "generations/0000.npz",
)


@pytest.fixture(scope="session")
def answered(tmp_path_factory, paper):
    findings, folder = run(tmp_path_factory.mktemp("runs") / "paper", STUDY + published_medians(paper), figures=True)
    return findings, folder, json.loads((folder / "inference.json").read_text())


def test_an_experiment_is_flown_as_studies_are(tmp_path):
    """Across chunks, for both streams, at a setting that is not the default: the bits of a plain study with the values in it."""
    experiment = SettingFlyer(load_inference(write(tmp_path)), 2)
    other = np.array([0.4, 12.0])
    for stream, count in ((SEARCH, 20), (HELD_OUT, CHUNK + 8)):
        scores, failed = experiment.fly(np.stack([VALUES, other]), stream, count)
        assert not failed.any()
        for row, values in zip(scores, (VALUES, other), strict=True):
            plain = [flown_plainly(plain_table(name, *values), stream, count) for name in CONTENDERS]
            expected = [plain[k][METRICS.index(metric)] for metric in METRICS for k in range(2)]
            assert np.array_equal(row, expected)
    assert experiment.flights_of(20) == 40


def median_covariance(scores, flights):
    """Covariance (cells, cells) of the logarithms of medians of so many flights, by the bootstrap of scores (cells, flights)."""
    draw = np.random.default_rng(3)
    picked = draw.integers(scores.shape[1], size=(2000, flights))
    return np.cov(np.log(np.median(scores[:, picked], axis=-1)))


def seed_noise(answered, paper):
    """Largest error (unknowns,) [ln] that the seeds explain: four standard deviations of the least-squares answer.

    Its cells err by what the medians of the search's flights do, and by what the published medians of 256 others do.
    """
    inference = answered[0].inference
    step = 0.05
    rows = VALUES * np.exp(step * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]]))
    scores, _ = SettingFlyer(inference, 2).fly(rows, HELD_OUT, PUBLISHED_FLIGHTS)
    logs = np.log(np.median(scores, axis=-1))
    jacobian = np.stack([logs[0] - logs[1], logs[2] - logs[3]], axis=1) / (2.0 * step)
    flown = np.stack(list(paper.values()))
    cells = median_covariance(flown, inference.flights) + median_covariance(flown, PUBLISHED_FLIGHTS)
    answer = np.linalg.pinv(jacobian)
    return 4.0 * np.sqrt(np.diag(answer @ cells @ answer.T))


def test_the_values_of_a_synthetic_paper_are_found_again(answered, paper):
    findings, _, document = answered
    settings = np.array([row["inferred"] for row in document["unknowns"]])
    default = np.array([row["default"] for row in document["unknowns"]])
    allowed = seed_noise(answered, paper)
    assert np.all(np.abs(np.log(settings / VALUES)) < allowed)
    assert np.all(np.abs(np.log(default / VALUES)) > allowed), "the study must not start at the answer"
    assert np.all(allowed < 0.8)
    misfit = document["misfit"]
    for kind in ("peak", "settling"):
        assert 3.0 * misfit["inferred"]["held_out"][kind] < misfit["default"]["held_out"][kind]
    for row, truth in zip(document["unknowns"], VALUES, strict=True):
        assert row["low"] <= row["low68"] <= row["inferred"] <= row["high68"] <= row["high"]
        assert row["near_low"] <= row["inferred"] <= row["near_high"]
        centre, deviation = np.log(row["inferred"]), 0.5 * np.log(row["high68"] / row["low68"])
        assert abs(centre - np.log(truth)) < 3.0 * deviation


def test_all_cells_and_ratios_of_a_synthetic_paper_are_reproduced(answered):
    _, _, document = answered
    assert all(row["inside"] and row["reproducible"] for row in document["cells"] + document["ratios"])
    together = document["together"]
    assert together["search"] == together["held_out"] == together["of"] == 4
    assert together["missed"] == []
    assert any("reproduced by at least one" in text for text in document["words"])
    assert any(
        "at once are 4 of 4" in text and text.endswith("held out it reproduces 4.") for text in document["words"]
    )


def test_cells_are_told_from_the_held_out_flights(answered):
    findings, _, document = answered
    inference = findings.inference
    rows = np.stack(
        [[row["inferred"] for row in document["unknowns"]], [row["default"] for row in document["unknowns"]]]
    )
    scores, _ = SettingFlyer(inference, 1).fly(rows, HELD_OUT, inference.held_out)
    for i, row in enumerate(document["cells"]):
        for key, flown in (("ours", scores[0, i]), ("default", scores[1, i])):
            ours = row[key]
            assert ours["median"] == pytest.approx(np.median(flown))
            assert ours["mean"] == pytest.approx(np.mean(flown))
            assert [ours["low95"], ours["high95"]] == pytest.approx(np.quantile(flown, [0.025, 0.975]))
            below = 100.0 * (np.sum(flown < row["published"]) + 0.5 * np.sum(flown == row["published"])) / len(flown)
            assert ours["percentile"] == pytest.approx(below)
            assert ours["inside"] == (2.5 <= below <= 97.5)
        assert row["ratio"] == pytest.approx(row["ours"]["median"] / row["published"])
    for i, row in enumerate(document["ratios"]):
        assert (row["first"], row["second"]) == CONTENDERS
        first, second = scores[0, 2 * i], scores[0, 2 * i + 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            flown = np.where((first == 0.0) & (second == 0.0), 1.0, second / first)
        assert row["ours"]["median"] == pytest.approx(np.median(flown), rel=1e-6)
        assert row["published"] == pytest.approx(
            document["cells"][2 * i + 1]["published"] / document["cells"][2 * i]["published"]
        )


def test_settings_are_told_from_the_flights_of_the_search(answered):
    findings, _, _ = answered
    inference, settings = findings.inference, findings.settings
    rows = [0, 5, findings.chosen]
    scores, _ = SettingFlyer(inference, 1).fly(settings.values[rows], SEARCH, inference.flights)
    assert np.array_equal(settings.median[rows], np.median(scores, axis=-1))
    assert np.array_equal(settings.percentile[rows], 100.0 * np.mean(scores < inference.published[:, None], axis=-1))


def test_tables_agree_with_the_document(answered):
    findings, folder, document = answered
    assert [name for name in FILES if not (folder / name).stat().st_size] == []
    assert_covered(folder)
    table: Any = read_frame(folder / "candidates.npz")
    assert len(table) == document["settings"]["tried"]
    default, inferred = table.iloc[0], table[table.role == "inferred"].iloc[0]
    assert default.role == "default"
    assert document["inferred"] == f"p{inferred.candidate:04d}"
    assert inferred.misfit == table.misfit.min()
    for row in document["unknowns"]:
        assert inferred[f"unknown:{row['name']}"] == row["inferred"]
        assert default[f"unknown:{row['name']}"] == pytest.approx(row["default"], rel=1e-12)
        near = table[table.misfit <= 1.1 * table.misfit.min()][f"unknown:{row['name']}"]
        assert (near.min(), near.max()) == (row["near_low"], row["near_high"])
    inside = [
        table[f"percentile:{row['metric']} {row['contender']}@level"].between(2.5, 97.5) for row in document["cells"]
    ]
    assert np.array_equal(np.sum(inside, axis=0), table.inside)
    assert table.inside.max() == document["together"]["search"]
    assert table.inside[int(document["together"]["candidate"][1:])] == table.inside.max()
    logs = np.stack(
        [log_ratio(table[f"median:{r['metric']} {r['contender']}@level"], r["published"]) for r in document["cells"]]
    )
    assert np.sqrt(np.square(logs[:2]).mean(axis=0)) == pytest.approx(table["misfit:peak"])
    assert np.sqrt(np.square(logs[2:]).mean(axis=0)) == pytest.approx(table["misfit:settling"])
    for row, cells in zip(document["cells"], logs, strict=True):
        assert abs(np.log(row["best_ratio"])) == pytest.approx(np.abs(cells).min())
    searched = pd.concat(
        [read_frame(file) for file in sorted((folder / "generations").glob("*.npz"))], ignore_index=True
    )
    assert searched.equals(table[table.origin >= 0].drop(columns=["role", "front"]))
    assert (table.origin >= 0).sum() == 12 * 6
    assert (table.origin < 0).sum() >= 2 * SWEEP


def test_the_front_is_non_dominated_and_holds_the_inferred(answered):
    findings, folder, document = answered
    table: Any = read_frame(folder / "candidates.npz")
    shown = table[table.front].sort_values("misfit:peak")
    assert document["inferred"] in [row["candidate"] for row in document["front"]] or len(document["front"]) == 12
    for one, other in pairwise(shown.to_dict("records")):
        assert one["misfit:peak"] < other["misfit:peak"]
        assert one["misfit:settling"] > other["misfit:settling"]
    for row in document["front"]:
        settings = table[table.candidate == int(row["candidate"][1:])].iloc[0]
        assert row["search"]["peak"] == settings["misfit:peak"]


def test_a_long_front_is_thinned_from_end_to_end():
    values = np.stack([np.arange(100.0), 100.0 - np.arange(100.0)], axis=1)[np.random.default_rng(1).permutation(100)]
    rows = select_subset(values, np.arange(100))
    assert len(rows) == 12
    assert values[rows, 0].tolist() == sorted(values[rows, 0])
    assert (values[rows[0], 0], values[rows[-1], 0]) == (0.0, 99.0)


def test_the_inferred_study_is_a_contest_that_flies_the_inferred_values(answered):
    findings, folder, _ = answered
    path = folder / "inferred.toml"
    assert kind_of_layers(read_layers(path)).name == "contest"
    table = tomllib.loads(path.read_text())
    assert not {"unknown", "inference", "base"} & set(table)
    expected = findings.inference.studies(findings.settings.values[findings.chosen])
    contest = load_contest(path)
    assert {c.name: c.study.digest() for c in contest.contenders} == {n: s.digest() for n, s in expected.items()}
    assert [(cell.contenders, cell.value) for cell in contest.published] == [
        ((cell.contender,), cell.value) for cell in findings.inference.cells
    ]


def test_ratios_are_taken_flight_by_flight(tmp_path):
    asked = load_inference(write(tmp_path))
    scores = np.array([[[1.0, 2.0, 4.0], [3.0, 1.0, 8.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]])
    ratios = ratio_scores(asked, scores)
    assert ratios[0, 0].tolist() == [3.0, 0.5, 2.0]
    assert ratios[0, 1, 1] == 1.0
    assert ratios[0, 1, 0] > 1e5
    assert 0.0 < ratios[0, 1, 2] < 1e-5
