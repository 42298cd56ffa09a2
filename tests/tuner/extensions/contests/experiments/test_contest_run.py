"""What a contest leaves behind: the same air for all, complete and consistent files, the same bits for any thread count."""

import json
import shutil

import numpy as np
import pandas as pd
import pytest

from objectives.problem import FlightBatch, Problem
from objectives.risk import Risk
from plant.backends.lane_layout import LANES
from plant.errors import StoreError
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.scenarios import CONFIRMATION, HELD_OUT, for_vehicle, sample_scenarios
from tests.tables import read_frame
from tests.tuner.experiments.again.killing import assert_covered
from tests.tuner.extensions.contests.experiments.conftest import run_small
from tests.tuner.extensions.contests.experiments.contest_text import CONTEST, NAMES, changed, write
from tests.tuner.in_process import tuner as command
from tests.tuner.study.loading import load_contest
from tuner.analysis.responses import responses_of
from tuner.experiments.again.resume import reopen
from tuner.experiments.compare.fronts import volume
from tuner.experiments.tuning.bounds import on_bounds
from tuner.extensions.contests.run import ContestRun
from tuner.search.watcher import Watcher
from tuner.study.build import load_study

FILES = (
    "study.toml",
    "resolved.json",
    "environment.json",
    "contest.json",
    "scores.npz",
    "differences.csv",
    "published.csv",
    "fronts.csv",
    "responses.npz",
    "traces.npz",
    "wind.npz",
    "report.html",
    "contenders/pid.toml",
    "contenders/pid/front.csv",
    "contenders/pid/report.html",
)
GIVEN_ONLY = changed("{ low = 20.0, high = 200.0 }", "60.0")
# Nothing of the clock, the machine or the path.
TIMES = {"wall_seconds"}


def document(folder):
    return json.loads((folder / "contest.json").read_text())


def timeless(folder):
    return {key: value for key, value in document(folder).items() if key not in TIMES}


@pytest.fixture
def without_report(monkeypatch):
    monkeypatch.setattr(ContestRun, "draw", staticmethod(lambda path, watcher: None))


def test_every_file_is_there_and_no_half_file(small_contest):
    _, folder = small_contest
    assert [name for name in FILES if not (folder / name).stat().st_size] == []
    assert {path.name for path in folder.rglob(".*")} == {".lock"}
    assert (folder / "study.toml").read_text() == CONTEST
    assert_covered(folder)
    assert sorted(path.name for path in (folder / "contenders").iterdir()) == ["pid", "pid.toml"]


def test_damage_in_the_run_of_a_contender_is_told_of_the_contest(small_contest, tmp_path, monkeypatch, capsys):
    folder = shutil.copytree(small_contest[1], tmp_path / "copy")
    (folder / "contenders" / "pid" / "front.csv").write_text("point\n")
    code, _, err = command(monkeypatch, capsys, "show", folder)
    assert code == 2 and f"contenders/pid/front.csv is not what was written; `tuner resume {folder}`" in err
    code, out, _ = command(monkeypatch, capsys, "verify", folder)
    assert code == 1 and out.startswith("Different: ") and "front.csv" in out
    code, out, _ = command(monkeypatch, capsys, "verify", small_contest[1])
    assert code == 0 and out.startswith("Intact: all") and "contenders/" in out


def test_every_contender_scores_as_if_it_flew_alone(small_contest):
    """Same bits as the contender's own problem on its own confirmation batches: nobody's air depends on who else is there."""
    result, _ = small_contest
    contest = result.study
    for k, entry in enumerate(result.entries):
        study = entry.contender.study
        objectives = tuple(quantity.objective for quantity in contest.quantities)
        problem = Problem(study.system, study.space, objectives, (), contest.seed, 1)
        batches = tuple(FlightBatch(scenario.spec, CONFIRMATION, scenario.held_out) for scenario in study.scenarios)
        alone = problem.evaluate_gains(entry.row[None], batches)
        assert np.array_equal(alone.scores[0], result.flown.scores[k])
        assert np.array_equal(alone.origin, result.flown.origin)


def test_another_vehicle_meets_the_same_air_noise_and_relative_spread():
    contest_spec = load_contest_spec()
    timing, indices = Timing(0.004, 0.001), range(5, 12)
    one, other = load("hummingbird").vehicle, load("f450").vehicle
    drawn = sample_scenarios(contest_spec, one, timing, 3, HELD_OUT, indices)
    moved = for_vehicle(drawn, contest_spec, other, 3, HELD_OUT, indices)
    own = sample_scenarios(contest_spec, other, timing, 3, HELD_OUT, indices)
    assert drawn.disturbances.shape[-1] == LANES
    for name in ("dynamics", "disturbances", "noises", "references"):
        assert np.array_equal(getattr(moved, name), getattr(own, name)), name
    assert moved.disturbances is drawn.disturbances
    assert not np.array_equal(moved.dynamics, drawn.dynamics)


def load_contest_spec():
    """The first scenario of the small contest: turbulence, noise and a spread of mass."""
    from pathlib import Path
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as folder:
        return load_contest(write(Path(folder))).scenarios[0].spec


def test_contenders_with_the_same_controller_fly_alike(tmp_path, without_report):
    twin = changed('name = "The hybrid, v1.0"', 'name = "The hybrid, v1.0"\n\n[[contender]]\nname = "Twin"', GIVEN_ONLY)
    result = run_small(write(tmp_path, twin), tmp_path / "out")
    assert np.array_equal(result.flown.scores[1], result.flown.scores[2])
    assert not np.array_equal(result.flown.scores[1], result.flown.scores[3])
    found = [d for d in document(tmp_path / "out")["differences"] if (d["first"], d["second"]) == (NAMES[1], "Twin")]
    assert len(found) == 6
    assert {(d["difference"], d["low"], d["high"], d["verdict"]) for d in found} == {
        (0.0, 0.0, 0.0, "no practical difference")
    }


def test_same_bits_for_any_thread_count_and_others_for_another_seed(tmp_path, without_report):
    path = write(tmp_path, GIVEN_ONLY)
    for name, threads, changes in (("one", 1, {}), ("three", 3, {}), ("seed", 1, {"seed": 4})):
        run_small(path, tmp_path / name, threads, **changes)
    first = timeless(tmp_path / "one")
    assert timeless(tmp_path / "three") == first
    for table in ("scores", "responses", "traces", "wind"):
        one, other = (read_frame(tmp_path / folder / f"{table}.npz") for folder in ("one", "three"))
        pd.testing.assert_frame_equal(one, other, check_exact=True)
    assert timeless(tmp_path / "seed")["estimates"] != first["estimates"]
    assert first["fronts"] is None
    assert first["best_under"] == []
    assert not (tmp_path / "one" / "fronts.csv").exists()
    assert list((tmp_path / "one" / "contenders").iterdir()) == []


def test_estimates_and_cells_follow_from_the_scores(small_contest):
    result, folder = small_contest
    found, scores = document(folder), read_frame(folder / "scores.npz")
    assert found["flights"] == result.flights
    for scenario, count in (("gusts", 8), ("calm", 6)):
        for _, group in scores[scores.scenario == scenario].groupby(["contender", "quantity"]):
            assert group.flight.tolist() == list(range(count))
    values = {key: group.value.to_numpy() for key, group in scores.groupby(["contender", "quantity"])}
    by_label = {quantity["label"]: quantity for quantity in found["quantities"]}
    assert len(found["estimates"]) == len(NAMES) * len(by_label)
    for entry in found["estimates"]:
        asked = by_label[entry["quantity"]]
        risk = Risk(asked["risk"], asked["level"])
        assert entry["value"] == pytest.approx(
            float(risk.apply(values[entry["contender"], entry["quantity"]])), rel=1e-12
        )
        assert entry["low"] <= entry["value"] <= entry["high"]
    for entry in found["contenders"]:
        assert entry["failures"] == pytest.approx(values[entry["name"], "mean(failure)"].mean(), rel=1e-12)
    assert found["contenders"][2]["failures"] > 0.0
    assert [(cell["contender"], cell["value"], cell["fitted"]) for cell in found["published"]] == [
        ("PID", 0.2, False),
        ("LADRC", 0.2, False),
        ("PID", 0.1, True),
    ]
    for cell in found["published"]:
        mine = values[cell["contender"], "mean(peak.roll)@gusts"]
        assert len(mine) == 8
        assert cell["mean"] == pytest.approx(mine.mean(), rel=1e-12)
        assert cell["percentile"] == pytest.approx(100.0 * np.mean(mine < cell["value"]), abs=1e-9)
        assert cell["inside"] == (2.5 <= cell["percentile"] <= 97.5)


def test_differences_and_claims_agree_with_each_other(small_contest):
    _, folder = small_contest
    found = document(folder)
    values = {(entry["contender"], entry["quantity"]): entry["value"] for entry in found["estimates"]}
    assert len(found["differences"]) == 3 * len(found["quantities"])
    for row in found["differences"]:
        expected = values[row["second"], row["quantity"]] - values[row["first"], row["quantity"]]
        assert row["difference"] == pytest.approx(expected, rel=1e-9, abs=1e-15)
        lower = row["second"] if row["high"] < 0.0 else row["first"] if row["low"] > 0.0 else None
        assert row["lower"] == lower
    (claim,) = found["claims"]
    pairs = {(row["first"], row["second"], row["quantity"]): row for row in found["differences"]}
    for row in claim["rows"]:
        same = pairs["PID", "LADRC", row["quantity"]]
        assert (row["difference"], row["low"], row["high"]) == (same["difference"], same["low"], same["high"])
    assert len(pd.read_csv(folder / "differences.csv")) == len(found["differences"])


def test_words_call_only_that_better_which_the_rule_calls_so(small_contest):
    _, folder = small_contest
    found = document(folder)
    for quantity in found["quantities"][:2]:
        (sentence,) = [text for text in found["words"] if text.startswith(f"{quantity['label']} at")]
        values = {e["contender"]: e["value"] for e in found["estimates"] if e["quantity"] == quantity["label"]}
        best = min(values, key=lambda name: values[name])
        rows = [
            row
            for row in found["differences"]
            if row["quantity"] == quantity["label"] and best in (row["first"], row["second"])
        ]
        beaten = {row["first"] if row["second"] == best else row["second"] for row in rows if row["lower"] == best}
        assert f"{best} has the lowest value" in sentence
        clauses = sentence.split("; ")
        below = next((clause for clause in clauses if clause.startswith("better than")), "")
        assert {name for name in NAMES if name in below} == beaten
        for row in rows:
            other = row["first"] if row["second"] == best else row["second"]
            assert other in beaten or any(other in each for each in clauses if each.startswith(row["verdict"]))
    assert any("1 of 1" in text or "0 of 1" in text for text in found["words"] if "set to meet" in text)


def test_a_tuned_contender_is_compared_at_a_point_of_its_front(small_contest):
    result, folder = small_contest
    found, fronts = document(folder), pd.read_csv(folder / "fronts.csv")
    first = found["contenders"][0]
    assert (first["tuned"], first["folder"]) == (True, "contenders/pid")
    own = pd.read_csv(folder / "contenders" / "pid" / "front.csv")
    stays = own[own.non_dominated]
    assert set(fronts[fronts.contender == "PID"].point) <= set(stays.point)
    assert found["stream"] == CONFIRMATION
    row = fronts[fronts.recommended & (fronts.contender == "PID")].iloc[0]
    assert fronts.recommended.sum() == 2
    assert row["point"] == first["point"]
    assert row["gain:roll.kp"] == first["gains"]["roll.kp"]["value"]
    values = {entry["quantity"]: entry for entry in found["estimates"] if entry["contender"] == "PID"}
    before = own[own.point == first["point"]].iloc[0]
    for label in ("cvar50(itae.position)", "mean(travel)"):
        assert values[label]["value"] == row[f"value:{label}"]
        # What it was picked by, and what it is compared on: flights of two streams.
        assert row[f"picked_on:{label}"] == before[f"held_out:{label}"]
        assert values[label]["value"] != before[f"held_out:{label}"]
    scaled = np.array([stays["held_out:cvar50(itae.position)"], stays["held_out:mean(travel)"]]).T
    scaled = (scaled - scaled.min(axis=0)) / np.where(np.ptp(scaled, axis=0) > 0.0, np.ptp(scaled, axis=0), 1.0)
    assert stays.point.iloc[int(scaled.sum(axis=1).argmin())] == first["point"]
    assert [entry["point"] for entry in found["contenders"][1:]] == ["given", "given"]
    assert [text for text in found["warnings"] if text.startswith("Flown as given")] != []


def test_a_front_is_flown_again_on_flights_that_picked_nothing(small_contest):
    """Every point of the front by the contender's own problem on its own confirmation batches, bit for bit."""
    result, _ = small_contest
    study, front = result.entries[0].contender.study, result.fronts[0]
    problem = Problem(study.system, study.space, study.objectives, study.constraints, study.seed, 2)
    batches = tuple(FlightBatch(scenario.spec, CONFIRMATION, scenario.held_out) for scenario in study.scenarios)
    alone = problem.evaluate_gains(front.gains, batches)
    assert len(front.points) > 1
    assert np.array_equal(alone.values, front.values)
    assert np.all(alone.violations <= 0.0)


def test_fronts_and_best_values_follow_from_the_points(small_contest):
    _, folder = small_contest
    found, table = document(folder), pd.read_csv(folder / "fronts.csv")
    labels = found["fronts"]["objectives"]
    points, picked = (
        {name: group[[f"{kind}:{label}" for label in labels]].to_numpy() for name, group in table.groupby("contender")}
        for kind in ("value", "picked_on")
    )
    # On the f450 the default gains lose flights, so LADRC keeps no constraint.
    assert set(points) == {"PID", "The hybrid, v1.0"}
    points["LADRC"] = picked["LADRC"] = np.empty((0, 2))
    union = np.concatenate(list(points.values()))
    ideal, reference = union.min(axis=0), 1.1 * union.max(axis=0)
    np.testing.assert_allclose(list(found["fronts"]["ideal"].values()), ideal, rtol=1e-12)
    np.testing.assert_allclose(list(found["fronts"]["reference"].values()), reference, rtol=1e-12)
    for entry in found["fronts"]["hypervolume"]:
        assert entry["value"] == pytest.approx(volume(points[entry["contender"]], ideal, reference), rel=1e-9)
        assert entry["low"] <= entry["value"] <= entry["high"]
    assert len(found["best_under"]) == 6
    for best in found["best_under"]:
        i, j = labels.index(best["objective"]), labels.index(best["subject_to"])
        for row in best["rows"]:
            by, compared = picked[row["contender"]], points[row["contender"]]
            kept = np.flatnonzero(by[:, j] <= best["limit"])
            chosen = kept[np.argmin(by[kept, i])] if len(kept) else None
            assert row["value"] == (None if chosen is None else pytest.approx(compared[chosen, i], rel=1e-12))
            assert (row["point"] is None) == (len(kept) == 0)


def test_the_study_of_a_contender_can_be_run_alone(small_contest):
    result, folder = small_contest
    alone = load_study(folder / "contenders" / "pid.toml")
    assert alone.digest() == result.study.contenders[0].study.digest()
    assert (folder / "contenders" / "pid" / "study.toml").read_text() == (
        folder / "contenders" / "pid.toml"
    ).read_text()


def test_traces_and_air_are_those_of_flight_0(small_contest):
    result, folder = small_contest
    traces, air = read_frame(folder / "traces.npz"), read_frame(folder / "wind.npz")
    fans = read_frame(folder / "responses.npz")
    assert set(traces.contender) == set(fans.point) == set(NAMES)
    x = traces[(traces.contender == "LADRC") & (traces.scenario == "gusts") & (traces.signal == "x")]
    assert x.reference.tolist()[-1] == 1.0
    entry = result.entries[2]
    system = entry.problem.system
    first = sample_scenarios(result.study.scenarios[0].spec, system.vehicle, system.timing, 3, CONFIRMATION, range(1))
    again = responses_of(system, entry.problem.flyer, entry.row, first)
    assert x.value.tolist() == again.actual[0, :, 0].tolist()
    spec = result.study.scenarios[0].spec
    drawn = sample_scenarios(spec, load("hummingbird").vehicle, Timing(0.004, 0.001), 3, CONFIRMATION, range(1))
    gusts = air[(air.scenario == "gusts") & (air.signal == "wind_y")]
    assert gusts.value.tolist() == drawn.disturbances[0, :, 1, 0].tolist()
    np.testing.assert_allclose(gusts.time, 0.004 * np.arange(250), atol=1e-12)
    assert set(air.unit) == {"m/s"}


def test_a_resumed_contest_ends_in_the_same_bits(small_contest, tmp_path, without_report):
    """As if it had been killed after the search of its contender, before anything was judged."""
    _, folder = small_contest
    copy = shutil.copytree(folder, tmp_path / "copy")
    tables = ("fronts.csv", "differences.csv", "contenders/pid/front.csv", "contenders/pid/summary.json")
    for name in ("contest.json", "scores.npz", *tables):
        (copy / name).unlink()
    ContestRun(*reopen(copy, None), Watcher(), threads=1).carry_out()
    assert timeless(copy) == timeless(folder)
    for name in tables[:3]:
        assert (copy / name).read_bytes() == (folder / name).read_bytes()


def test_an_existing_folder_is_not_touched(small_contest, tmp_path):
    _, folder = small_contest
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    with pytest.raises(StoreError, match="--out"):
        run_small(write(tmp_path), folder)
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before


def test_gains_at_the_ends_of_their_ranges_are_found(tmp_path):
    gains = """
"attitude.omega_c" = { low = 1.0, high = 100.0 }
"attitude.omega_o" = { low = 2.0, high = 75.0 }
"attitude.zeta" = { low = 0.0, high = 2.0 }
"""
    text = changed('"attitude.omega_c" = 0.3\n', gains)
    study = load_contest(write(tmp_path, text)).contenders[2].study
    columns = [columns[0] for columns in study.space.columns]

    def row(omega_c, omega_o, zeta):
        gains = study.default_row
        gains[columns] = omega_c, omega_o, zeta
        return gains

    # 1 % of two decades is a factor of 1.047.
    inside, near = row(1.06, 70.0, 0.03), row(1.04, 75.0, 0.01)
    assert on_bounds(study, inside, np.array([inside])) == []
    found = {
        (entry.variable, entry.end): entry
        for entry in on_bounds(study, near, np.array([near, inside, inside, row(97.0, 10.0, 1.0)]))
    }
    assert {key: (e.recommended, e.share, e.natural) for key, e in found.items()} == {
        ("attitude.omega_c", "low"): (True, 0.25, False),
        ("attitude.omega_c", "high"): (False, 0.25, False),
        ("attitude.omega_o", "high"): (True, 0.25, True),
        ("attitude.zeta", "low"): (True, 0.25, True),
    }
    assert found["attitude.omega_c", "low"].bound == 1.0
    assert found["attitude.omega_c", "low"].value == 1.04


def test_a_front_that_keeps_no_constraint_is_empty(tmp_path, without_report):
    text = changed('metric = "failure"\nmax = 0.0', 'metric = "itae.position"\nmax = 1e-9')
    run_small(write(tmp_path, text), tmp_path / "none")
    found = document(tmp_path / "none")
    assert found["fronts"] is None
    assert found["best_under"] == []
    assert "Nothing feasible for PID" in found["ending"][0]
    assert len(found["estimates"]) == 3 * len(found["quantities"])
