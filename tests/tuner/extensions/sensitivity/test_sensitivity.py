"""`tuner sensitivity` on a small real study: the samples are real flights, the figures are consistent, errors are one line."""

import json

import numpy as np
import pandas as pd
import pytest

from tests.tuner.experiments.again.killing import assert_covered
from tests.tuner.in_process import tuner
from tests.tuner.study.study_text import STUDY, changed, with_gains, write
from tuner.experiments.tuning.problem import batches
from tuner.extensions.sensitivity.indices import RANK, VALUE
from tuner.extensions.sensitivity.run import analysis_cost, study_problem, study_sensitivity
from tuner.extensions.sensitivity.tables import sensitivity_document
from tuner.study.build import load_study

# position.zeta has a range that changes nothing.
GAINS = '"position.omega_c" = { low = 1.0, high = 2.0 }\n"position.zeta" = { low = 1.0, high = 1.0000001 }'
SAMPLES = 16


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return write(tmp_path_factory.mktemp("study"), with_gains(GAINS))


@pytest.fixture(scope="module")
def analysed(path):
    study = load_study(path)
    on_flights_done = []
    return (
        study,
        study_sensitivity(study_problem(study, 2), study, SAMPLES, on_flights_done.append),
        sum(on_flights_done),
    )


def test_the_variable_without_effect_has_none_and_the_other_all(analysed):
    _, analysis, _ = analysed
    # Two samples that are all but equal stand next to each other, and 1/64 apart in rank: 0.5 / 64^2 of a variance of 1/12.
    for scale, least in ((VALUE, 1e-9), (RANK, 6.0 / 64**2 + 1e-4)):
        total = analysis.indices[scale].total.value
        assert np.all(total[:2, 0] > 0.8)
        assert np.all(np.abs(total[:2, 1]) < least)


def test_all_samples_fly_the_search_scenarios(analysed):
    study, analysis, on_flights_done = analysed
    assert on_flights_done == 4 * SAMPLES * 4 == len(analysis.values) * 4
    again = study_problem(study, 1).evaluate(analysis.design.points[[3, 60]], batches(study, "search"), fly_all=True)
    assert np.array_equal(again.values, analysis.values[[3, 60]])
    expected = analysis_cost(study_problem(study, 2), study, SAMPLES)
    assert (expected.candidates, expected.flights) == (4 * SAMPLES, on_flights_done) and expected.seconds > 0.0


def test_gains_and_air_share_the_variance(analysed):
    study, analysis, _ = analysed
    document = sensitivity_document(study, analysis, 1.0)
    for row in document.variance:
        assert row.candidates == 2 * SAMPLES
        parts = row.components_percent
        assert parts is not None and row.sum_of_squares_percent is not None
        assert sum(vars(parts).values()) == pytest.approx(100.0)
        assert row.turbulence_percent == pytest.approx(parts.scenario + parts.interaction)
        assert sum(vars(row.sum_of_squares_percent).values()) == pytest.approx(100.0)
        assert min(vars(parts).values()) >= 0.0 and parts.scenario > 0.0
    assert "share of flights lost" in document.notes[-1]


def test_what_a_search_would_not_fly_is_flown_and_told(tmp_path, analysed):
    _, analysis, _ = analysed
    margin = '\n[[margin]]\nquantity = "phase_margin"\naxis = "roll"\nmin = 120.0\n'
    study = load_study(write(tmp_path, with_gains(GAINS) + margin))
    found = study_sensitivity(study_problem(study, 2), study, SAMPLES)
    assert found.screened_share == 1.0 and not found.passes_screening.any()
    assert np.array_equal(found.values, analysis.values)
    assert "100.0 % of the samples violate a hard requirement" in " ".join(
        sensitivity_document(study, found, 1.0).notes
    )


def test_command_writes_tables_that_agree(path, analysed, tmp_path, monkeypatch, capsys):
    _, analysis, _ = analysed
    folder = tmp_path / "out"
    arguments = ("sensitivity", path, "--samples", SAMPLES, "--threads", 1)
    code, out, err = tuner(monkeypatch, capsys, *arguments, "--json", "--out", folder)
    assert (code, err) == (0, "")
    document = json.loads(out)
    assert document == json.loads((folder / "sensitivity.json").read_text())
    assert document["candidates"] == 64 and document["flights"] == 256 and document["not_worth_flying_percent"] == 0.0
    table = pd.read_csv(folder / "indices.csv")
    assert len(table) == len(document["indices"]) == 2 * 3 * 2
    for line, row in zip(table.to_dict("records"), document["indices"], strict=True):
        assert line["total_value"] == row["total"]["value"] and line["first_low"] == row["first"]["low"]
    samples = pd.read_csv(folder / "samples.csv")
    # Another thread count, the same bits.
    assert np.array_equal(samples["objective:mean(travel)"], analysis.values[:, 1])
    assert samples.block.value_counts().to_dict() == {
        name: SAMPLES for name in ("A", "B", "AB:position.omega_c", "AB:position.zeta")
    }
    shares = pd.read_csv(folder / "variance.csv")
    assert shares["components:gains"].tolist() == [row["components_percent"]["gains"] for row in document["variance"]]
    assert (folder / "figures" / "sensitivity.png").read_bytes().startswith(b"\x89PNG")
    assert_covered(folder)
    code, _, err = tuner(monkeypatch, capsys, *arguments, "--out", folder)
    assert code == 2 and "exists already" in err


def test_command_says_the_budget_before_and_prints_tables(path, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "sensitivity", path, "--samples", 8)
    assert code == 0
    text = " ".join(out.split())
    assert text.startswith("8 base samples of 2 variables: 32 candidates, 4 search scenarios each, 128 flights, about ")
    assert "seed 1" in text and "rank of mean(travel)" in text and "128 flights in" in text


def test_a_study_whose_every_sample_loses_flights_still_answers(tmp_path, monkeypatch, capsys):
    # No gains keep a vehicle within a centimetre in gusts.
    text = changed("x = 1.0", "x = 0.001", with_gains(GAINS))
    path = write(tmp_path, f"{text}\n[limits]\nposition = 0.01\n")
    code, out, _ = tuner(monkeypatch, capsys, "sensitivity", path, "--samples", 8, "--json")
    document = json.loads(out)
    assert code == 0 and document["lost_flights_percent"] == 100.0
    assert [row["components_percent"] for row in document["variance"]] == [None, None]
    assert "Fewer than two independent samples" in " ".join(document["notes"])


@pytest.mark.parametrize(
    ("text", "arguments", "words"),
    [
        (STUDY, ("--samples", "100"), "--samples: given 100"),
        (with_gains('"roll.k1" = 20.0'), (), "gains: no gain is searched"),
        (changed("[search]", "[contender.one]\n\n[search]"), (), "contender: this is a contest"),
    ],
)
def test_what_cannot_be_analysed_is_one_line(text, arguments, words, tmp_path, monkeypatch, capsys):
    code, out, err = tuner(monkeypatch, capsys, "sensitivity", write(tmp_path, text), *arguments)
    assert code == 2 and out == ""
    assert words in err and err.count("\n") == 1
