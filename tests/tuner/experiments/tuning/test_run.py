"""What a run leaves behind: complete, consistent, the same bits for any thread count, and never over something else."""

import json

import numpy as np
import pandas as pd
import pytest

from plant.errors import StoreError
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT, SEARCH
from tests.tables import read_frame
from tests.tuner.conftest import QUICKSTART, run_small
from tuner.experiments.tuning.problem import batches
from tuner.gains import read_gains
from tuner.store.folder import Folder

FILES = (
    "study.toml",
    "resolved.json",
    "environment.json",
    "history.csv",
    "front.csv",
    "summary.json",
    "gains.json",
    "responses.npz",
    "report.html",
    "figures/front.png",
    "figures/front.pdf",
    "figures/responses.png",
)


def generations(folder):
    return pd.concat([read_frame(file) for file in sorted((folder / "generations").glob("*.npz"))])


def test_every_file_is_there_and_no_half_file(small_run):
    _, folder = small_run
    assert [name for name in FILES if not (folder / name).stat().st_size] == []
    assert [path.name for path in folder.rglob(".*")] == [".lock"]
    assert (folder / "study.toml").read_text() == QUICKSTART.read_text()


def test_the_first_candidate_is_the_default(small_run):
    outcome, folder = small_run
    first = generations(folder).iloc[0]
    for variable, columns in zip(outcome.study.space.variables, outcome.study.space.columns, strict=True):
        assert first[f"gain:{variable.name}"] == pytest.approx(outcome.study.default_row[columns[0]], rel=1e-12)


def test_tables_agree_with_each_other(small_run):
    outcome, folder = small_run
    front, tried = pd.read_csv(folder / "front.csv"), generations(folder).set_index("candidate")
    summary = json.loads((folder / "summary.json").read_text())
    tuned = front[front.role == "tuned"].iloc[0]
    assert tuned.point == summary["tuned"]
    for objective in outcome.study.objectives:
        label = objective.label
        for row in front.to_dict("records"):
            assert row[f"search:{label}"] == tried.loc[row["candidate"], f"objective:{label}"]
            low, middle, high = (float(row[f"{kind}:{label}"]) for kind in ("low", "held_out", "high"))
            assert low <= middle <= high
            assert row[f"gap:{label}"] == row[f"held_out:{label}"] - row[f"search:{label}"]
            assert row[f"gap_low:{label}"] <= row[f"gap:{label}"] <= row[f"gap_high:{label}"]
            default = front[f"held_out:{label}"].tolist()[0]
            assert row[f"difference:{label}"] == pytest.approx(row[f"held_out:{label}"] - default, abs=1e-12)
            assert row[f"difference_low:{label}"] <= row[f"difference:{label}"] <= row[f"difference_high:{label}"]
        line = next(entry for entry in summary["table"] if entry["label"] == label)
        picked = next(entry for entry in summary["picked_on"]["objectives"] if entry["label"] == label)
        assert picked["held_out"]["value"] == pytest.approx(tuned[f"held_out:{label}"], rel=1e-12)
        difference = line["tuned"]["value"] - line["default"]["value"]
        assert line["difference"]["value"] == pytest.approx(difference, rel=1e-9, abs=1e-12)
    assert summary["picked_on"]["lost_in_search"] == tried.loc[tuned.candidate, "failures"]
    # A sliding gain below 0 means nothing, a bandwidth below 1 rad/s is merely low.
    ends = {row["name"]: row["natural_ends"] for row in summary["variables"]}
    assert {name: "low" in found for name, found in ends.items()} == {
        row["name"]: row["low"] <= 0.0 for row in summary["variables"]
    }
    history = pd.read_csv(folder / "history.csv")
    assert (history.flights + history.flights_raced).tolist() == [32 * (k + 1) for k in range(3)]
    assert history.hypervolume.is_monotonic_increasing


def test_gains_file_holds_the_tuned_gains_to_the_last_bit(small_run):
    outcome, folder = small_run
    controller = read_gains(folder / "gains.json")
    assert np.array_equal(np.array(controller.gains), outcome.gains(outcome.tuned))
    assert controller.cascade.attitude.name == "hybrid"
    assert controller.options == outcome.study.options


def test_flying_the_tuned_gains_again_gives_the_reported_values(small_run):
    outcome, folder = small_run
    gains = np.array(read_gains(folder / "gains.json").gains)
    again = outcome.problem.evaluate_gains(gains[None], batches(outcome.study, HELD_OUT))
    assert np.array_equal(again.values[0], outcome.finalists.evaluation.values[outcome.tuned])


def test_the_table_rests_on_flights_that_had_no_part_in_the_choice(small_run):
    outcome, folder = small_run
    gains = np.stack([outcome.gains(0), np.array(read_gains(folder / "gains.json").gains)])
    again = outcome.problem.evaluate_gains(gains, batches(outcome.study, CONFIRMATION), fly_all=True)
    table = json.loads((folder / "summary.json").read_text())["table"]
    for i, row in enumerate(table[: len(outcome.study.objectives)]):
        assert [row["default"]["value"], row["tuned"]["value"]] == pytest.approx(again.values[:, i].tolist(), rel=1e-12)
    assert [batch.count for batch in batches(outcome.study, CONFIRMATION)] == [32]


def test_search_held_out_and_confirmation_scenarios_share_nothing(small_run):
    outcome, _ = small_run
    streams = [
        outcome.problem.evaluate_gains(outcome.study.default_row[None], batches(outcome.study, stream)).scores[0, 0]
        for stream in (SEARCH, HELD_OUT, CONFIRMATION)
    ]
    assert len(np.unique(np.concatenate(streams))) == 4 + 32 + 32


def test_probabilities_belong_to_the_front(small_run):
    _, folder = small_run
    front = pd.read_csv(folder / "front.csv")
    assert front.probability[0] == 0.0 and front.probability.between(0.0, 1.0).all()
    # On every resample somebody is non-dominated.
    assert front.probability.sum() >= 1.0
    assert front.probability[~front.feasible].sum() == 0.0


def test_same_bits_for_another_thread_count_and_others_for_another_seed(small_run, tmp_path):
    _, folder = small_run
    run_small(tmp_path / "threads", threads=1)
    run_small(tmp_path / "seed", seed=2026)
    assert generations(tmp_path / "threads").equals(generations(folder))
    assert (tmp_path / "threads" / "front.csv").read_bytes() == (folder / "front.csv").read_bytes()
    assert not generations(tmp_path / "seed").equals(generations(folder))


def test_nothing_feasible_is_said_and_the_least_broken_point_shown(tmp_path):
    outcome = run_small(tmp_path / "none", constraint=[{"metric": "itae.position", "max": 1e-9}])
    assert outcome.tuned == 1
    broken = [row for row in outcome.table if row.limit == 1e-9]
    assert [row.verdict for row in broken] == ["broken"]
    conflict = json.loads((tmp_path / "none" / "summary.json").read_text())["conflict"]
    label = broken[0].label
    assert [label] in conflict["sets"] and conflict["common"]["limits"][0]["relaxed"] > 1e-9
    # What the headline and its reasons say is not said again as a warning, and nobody flies these gains.
    ending = json.loads((tmp_path / "none" / "summary.json").read_text())["ending"]
    assert "none of 24 candidates satisfies every limit" in ending[0] and ending[1].startswith(label)
    words = ("No candidate", "Kept by none", "shown beside the default", "end of its range")
    assert not [text for text in outcome.warnings if any(word in text for word in words)]


def test_an_existing_folder_is_not_touched(small_run):
    _, folder = small_run
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    with pytest.raises(StoreError, match="--out"):
        Folder.create(folder)
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before


def test_a_failed_write_leaves_no_half_file(tmp_path):
    folder = Folder.create(tmp_path / "new")
    with pytest.raises(TypeError):
        folder.write_json("summary.json", {"number": object()})
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == [".lock", "generations"]
