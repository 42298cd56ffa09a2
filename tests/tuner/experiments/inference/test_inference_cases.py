"""Inferences of other papers: absurd, untold, small; from the command line; with more threads."""

import json
from pathlib import Path

import numpy as np
import pytest

import plant.quadrotor.airframes
from plant.quadrotor.scenarios import SEARCH
from tests.tables import read_frame
from tests.tuner.experiments.inference.asked import CELLS, STUDY, cell, published_medians, write
from tests.tuner.experiments.inference.conftest import SMALL, run
from tests.tuner.study.loading import load_contest, load_inference
from tuner.documents.inference_document import InferenceDocument
from tuner.experiments.inference.flying import SettingFlyer
from tuner.experiments.inference.tables import with_values
from tuner.experiments.inference.words import unknown_words
from tuner.store.folder import Folder
from tuner.study.study import Study
from tuner.text.toml_text import toml_text

ROOT = Path(__file__).parents[4]


def test_failed_flights_are_counted(tmp_path):
    asked = load_inference(write(tmp_path), {"limits.tilt_deg": 10.0, "unknown.0.high": 500.0})
    _, failed = SettingFlyer(asked, 1).fly(np.array([[0.2, 1.5], [500.0, 1.5]]), SEARCH, 16)
    assert failed.mean(axis=(1, 2)).tolist() == [0.0, 1.0]


@pytest.mark.slow
def test_an_absurd_cell_is_not_reproducible_and_the_others_stay(tmp_path, paper):
    text = STUDY + published_medians(paper, **{"stiff v1.0 peak.roll": 60.0})
    _, folder = run(tmp_path / "absurd", text)
    document = json.loads((folder / "inference.json").read_text())
    verdicts = {(row["contender"], row["metric"]): row["reproducible"] for row in document["cells"]}
    assert [cell for cell, good in verdicts.items() if not good] == [("stiff v1.0", "peak.roll")]
    assert [row["reproducible"] for row in document["ratios"]] == [False, True]
    assert any("Reproduced by none" in text and "peak.roll of stiff v1.0" in text for text in document["words"])
    assert document["together"]["missed"] == [{"contender": "stiff v1.0", "metric": "peak.roll", "scenario": "level"}]


@pytest.mark.slow
def test_an_unknown_that_no_cell_tells_is_called_so(tmp_path, paper):
    """k1 is 0 in both contenders, so delta, the width of its saturation, moves next to nothing once k1 is tiny."""
    text = STUDY.replace('"attitude.k1" = 0.0', '"attitude.k1" = 1e-4').replace(
        "[search]",
        (
            '[[unknown]]\nname = "delta"\nunit = "rad/s"\nlow = 0.05\nhigh = 1.0\nscale = "log"\n'
            'set = ["contender.soft.gains.attitude.delta", "contender.stiff v1.0.gains.attitude.delta"]\n\n[search]'
        ),
    )
    findings, folder = run(
        tmp_path / "untold", text + published_medians(paper), changes={"search.generations": 3, "inference.flights": 16}
    )
    document = json.loads((folder / "inference.json").read_text())
    delta = document["unknowns"][2]
    assert (delta["verdict"], delta["at_end"]) == ("not", True)
    assert (delta["near_low"], delta["near_high"]) == pytest.approx((0.05, 1.0))
    assert delta["name"] == "delta"
    assert any("delta is not told by the cells" in text for text in document["words"])
    read = InferenceDocument.read(folder / "inference.json")
    row = read.unknowns[2].model_copy(update={"inferred": delta["high"], "verdict": "told"})
    assert "delta stands at an end of the range searched, 1 rad/s" in next(
        iter(unknown_words(read.model_copy(update={"unknowns": [row]})))
    )


def test_an_inferred_study_still_finds_its_files(tmp_path, paper):
    (tmp_path / "own").mkdir()
    bundled = Path(str(plant.quadrotor.airframes.__file__)).with_name("hummingbird.toml")
    (tmp_path / "own" / "mine.toml").write_text(bundled.read_text(encoding="utf-8"), encoding="utf-8")
    text = STUDY.replace('name = "hummingbird"', 'file = "own/mine.toml"') + CELLS
    asked = load_inference(write(tmp_path, text))

    folder = Folder.create(tmp_path / "deep" / "out")
    folder.write_text("inferred.toml", toml_text(with_values(asked, np.array([1.0, 2.0]), folder)))
    found, given = load_contest(folder.path / "inferred.toml").base, asked.contest.base
    assert isinstance(found, Study) and isinstance(given, Study) and found.system.vehicle == given.system.vehicle


@pytest.mark.slow
def test_same_bits_for_another_thread_count_and_others_for_another_seed(tmp_path, paper):
    text = STUDY + published_medians(paper)
    results = {}
    for name, threads, seed in (("one", 1, 7), ("two", 2, 7), ("seed", 2, 8)):
        _, folder = run(tmp_path / name, text, threads, {**SMALL, "seed": seed})
        results[name] = (
            read_frame(folder / "candidates.npz"),
            json.loads((folder / "inference.json").read_text()),
        )
    assert results["one"][0].equals(results["two"][0])
    assert not results["one"][0].equals(results["seed"][0])
    one, two = (
        {key: value for key, value in results[name][1].items() if key != "wall_seconds"} for name in ("one", "two")
    )
    assert one == two


@pytest.mark.slow
def test_one_kind_of_cell_and_no_pair_is_enough(tmp_path):
    text = STUDY + cell("soft", "peak.roll", 0.05)
    findings, folder = run(tmp_path / "one", text, changes=SMALL)
    document = json.loads((folder / "inference.json").read_text())
    assert document["ratios"] == []
    assert [kind["metric"] for kind in document["kinds"]] == ["peak"]
    assert document["cells"][0]["reproducible"]
    assert len(findings.shown) == 1


def test_the_command_line_runs_checks_and_draws_an_inference(tmp_path, tuner):
    path = write(tmp_path)
    figures = json.loads(tuner("check", path, "--json").stdout)
    assert figures["unknowns"] == ["intensity", "k2 of soft"]
    assert figures["search_flights"] == 12 * 6 * 2 * 32
    changes = [part for key, value in SMALL.items() for part in ("--set", f"{key}={value}")]
    out = tmp_path / "out"
    done = tuner("run", path, "--out", out, "--threads", 2, *changes)
    assert done.returncode == 0, done.stderr
    shown = done.stdout
    for text in (
        "Unknowns",
        "k2 of soft 1/s",
        "published cells lie in the central 95 %",
        "inferred.toml",
        "generation 2/2",
    ):
        assert text in " ".join(shown.split()), text
    picture = out / "figures" / "inference.png"
    before = picture.read_bytes()
    picture.unlink()
    assert tuner("report", out).returncode == 0
    assert picture.read_bytes() == before
