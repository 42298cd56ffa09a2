"""Going on with a run, judging it again and proving it: the same bits, no flight twice, damage named and mended."""

import json
import shutil

import numpy as np
import pandas as pd
import pytest

from objectives import memory
from plant.errors import InputError, StoreError
from plant.quadrotor.scenarios import SEARCH
from tests.tables import read_frame, write_frame
from tests.tuner.conftest import NoDrawing, run_small
from tests.tuner.experiments.again.killing import compare, result_of, unsealed
from tuner import report
from tuner.analysis import finals
from tuner.experiments.again.rejudge import judgement, judging_study
from tuner.experiments.again.resume import reopen
from tuner.experiments.again.verify import verify
from tuner.experiments.tuning.problem import batches, problem_of
from tuner.experiments.tuning.run import TuningRun
from tuner.search import convergence
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.store.inputs import read_record
from tuner.study.build import load_study

pytestmark = pytest.mark.usefixtures("no_pictures")


class Heard(Watcher):
    def __init__(self):
        self.messages = []

    def on_message(self, text):
        self.messages.append(text)


class Listener(Watcher):
    def __init__(self):
        self.told = []

    def on_warning(self, text):
        self.told.append(text)


@pytest.fixture
def copy(small_run, tmp_path):
    """A copy of the small run's folder, to be spoilt."""
    shutil.copytree(small_run[1], tmp_path / "copy")
    return tmp_path / "copy"


def resumed(path, budget=None, threads=2):
    study, folder = reopen(path, budget)
    listener = Listener()
    return TuningRun(study, folder, listener, threads=threads).carry_out(), listener.told


def flights_file(path, name):
    return next((path / "flights").glob(f"{name}-*.npz"))


@pytest.fixture(scope="module")
def replayed(small_run, tmp_path_factory):
    """A finished run that was resumed twice: outcome and words of the first time, and its folder."""
    path = tmp_path_factory.mktemp("runs") / "replayed"
    shutil.copytree(small_run[1], path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, "start_figures", lambda _: NoDrawing())
        patch.setattr(report, "write_report", lambda *_: None)
        outcome, told = resumed(path)
        resumed(path)
        return outcome, told, path


def test_a_finished_run_is_replayed_without_a_flight(small_run, replayed):
    outcome, told, path = replayed
    assert outcome.problem.flights_made == 0 and told == []
    compare(result_of(path), result_of(small_run[1]))


@pytest.mark.parametrize("threads", [pytest.param(1, marks=pytest.mark.slow), 3])
def test_the_number_of_threads_changes_no_bit(small_run, tmp_path, threads):
    run_small(tmp_path / "r", threads)
    compare(result_of(tmp_path / "r"), result_of(small_run[1]))


@pytest.mark.slow
def test_a_search_by_a_model_goes_on_with_the_same_bits(tmp_path):
    # It asks for margins between flights, so its points follow from more than what was flown.
    changes = {
        "search__algorithm": "gaussian_process",
        "search__generations": 3,
        "scenario__0__duration": 1.0,
        "scenario__0__reference__time": 0.1,
        "margin": [{"quantity": "phase_margin", "min": 35}, {"quantity": "ms", "max": 2}],
    }
    run_small(tmp_path / "run", 2, **changes)
    whole = result_of(tmp_path / "run")
    flights_file(tmp_path / "run", "search-0001").unlink()
    flights_file(tmp_path / "run", "search-0002").unlink()
    outcome, _ = resumed(tmp_path / "run", threads=1)
    assert outcome.problem.flights_made == 2 * 8 * 4
    compare(result_of(tmp_path / "run"), whole)


@pytest.mark.slow
def test_a_search_that_converged_and_finalists_that_stopped_keep_their_bits(tmp_path, monkeypatch):
    # Two generations are enough here, and of the finalists only the recommended goes on.
    monkeypatch.setattr(convergence.StoppingRule, "is_met", lambda rule, volumes: len(volumes) == 2)
    monkeypatch.setattr(finals, "decided", lambda found, choose: np.arange(len(found.complete)) > 0)
    monkeypatch.setattr(finals, "decisive", lambda found, choose: np.empty(0, dtype=int))
    path, heard = tmp_path / "run", Heard()
    # Limits go by their values: what lacks confidence alone would make all flights.
    changes = {"search__stop": "converged", "search__population": 16, "scenario__0__held_out": 128, "confidence": 0.0}
    outcome = run_small(path, **changes)
    made = outcome.finalists.evaluation.flights_each
    assert len(outcome.generations) == 2 and len(made) > 2
    assert (made == np.where(np.isin(np.arange(len(made)), [0, outcome.tuned]), 128, 32)).all()
    whole = result_of(path)
    assert verify(path, 3, 2, Watcher()).identical
    for name in ("search-0001", "held-out"):
        flights_file(path, name).unlink()
    resumed(path, threads=1)
    compare(result_of(path), whole)
    # A longer budget does not wake it.
    study, folder = reopen(path, 6)
    assert len(TuningRun(study, folder, heard, threads=2).carry_out().generations) == 2
    assert heard.messages == ["The search has converged after 2 of at most 6 generations."]
    (path / "generations" / "0001.npz").unlink()
    assert verify(path, 1, 2, Watcher()).difference == "1 generations are recorded, the search has more"


@pytest.mark.parametrize(
    ("name", "damage"),
    [
        ("search-0001", "cut"),
        ("held-out", "flip"),
        ("search-0001", "gone"),
        pytest.param("held-out", "gone", marks=pytest.mark.slow),
    ],
)
def test_a_damaged_file_of_flights_is_named_set_aside_and_flown_again(small_run, copy, name, damage):
    file = flights_file(copy, name)
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    if damage == "gone":
        file.unlink()
    else:
        file.write_bytes(content[:50] if damage == "cut" else content)
    outcome, told = resumed(copy)
    assert outcome.problem.flights_made > 0
    if damage != "gone":
        assert len(told) == 1 and file.name in told[0] and "flown again" in told[0]
        file.with_suffix(".damaged").unlink()
    compare(result_of(copy), result_of(small_run[1]))


@pytest.mark.parametrize(
    "names",
    [
        ("generations/0001.npz",),
        ("start.json",),
        (
            "front.csv",
            "summary.json",
            "gains.json",
            "resolved.json",
            "history.csv",
            "environment.json",
            "responses.npz",
        ),
    ],
    ids=" ".join,
)
def test_any_other_file_that_is_spoilt_is_written_again(small_run, copy, names):
    for name in names:
        (copy / name).write_bytes(b"\x00spoilt")
    outcome, _ = resumed(copy)
    assert outcome.problem.flights_made == 0
    compare(result_of(copy), result_of(small_run[1]))


def test_a_lost_record_is_told_with_what_to_do(small_run, copy, tmp_path):
    (copy / "run.json").write_text("{")
    with pytest.raises(StoreError, match=r"run\.json is damaged.*--reuse"):
        reopen(copy, None)
    (copy / "run.json").unlink()
    with pytest.raises(StoreError, match=r"holds no run\.json.*--reuse"):
        reopen(copy, None)
    outcome = run_small(tmp_path / "again", reuse=(copy,))
    assert outcome.problem.flights_made == 0
    compare(result_of(tmp_path / "again"), result_of(small_run[1]))


def test_an_edited_input_is_refused(copy):
    inputs = copy / read_record(copy).study
    inputs.write_text(inputs.read_text().replace("seed = 2025", "seed = 2026"))
    with pytest.raises(StoreError, match="is not what the run began with"):
        reopen(copy, None)


def test_another_model_is_refused(copy, monkeypatch):
    monkeypatch.setattr("tuner.store.inputs.model_key", lambda: "other")
    with pytest.raises(StoreError, match="another version of the model"):
        reopen(copy, None)


def test_a_run_of_other_sources_is_flown_again_and_compared(copy, monkeypatch):
    monkeypatch.setattr("tuner.experiments.again.verify.model_key", lambda: "other")
    monkeypatch.setattr("objectives.memory.model_key", lambda: "other")
    same = verify(copy, 2, None, Watcher())
    assert same.identical and same.sources_changed and same.flown == 2, same.words
    assert "The sources of the model are not those of the run" in same.words


def test_the_model_key_hangs_on_every_source_of_the_plant(tmp_path, monkeypatch):
    plant = tmp_path / "plant"
    shutil.copytree(next(iter(memory.plant.__path__)), plant)
    monkeypatch.setattr(memory.plant, "__path__", [str(plant)])
    known = memory.model_key.__wrapped__()
    file = plant / "air" / "dryden.py"
    assert file.exists()
    file.write_text(file.read_text() + "\n")
    assert memory.model_key.__wrapped__() != known


def test_the_model_key_hangs_on_what_extensions_of_this_distribution_fly_with(tmp_path, monkeypatch):
    for name in ("gainproof", "stranger"):
        metadata = tmp_path / f"{name}-9.dist-info"
        metadata.mkdir()
        (metadata / "entry_points.txt").write_text(f"[{memory.FLIGHT_CODE}]\n{name} = flies_{name}\n")
        (tmp_path / f"flies_{name}.py").write_text("speed = 1.0\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    known = memory.model_key.__wrapped__()
    (tmp_path / "flies_stranger.py").write_text("speed = 2.0\n")
    assert memory.model_key.__wrapped__() == known
    (tmp_path / "flies_gainproof.py").write_text("speed = 2.0\n")
    assert memory.model_key.__wrapped__() != known


@pytest.mark.slow
def test_a_longer_budget_gives_what_the_longer_run_gives(small_run, copy, tmp_path):
    outcome, _ = resumed(copy, budget=5)
    whole = run_small(tmp_path / "whole", search__generations=5)
    new = whole.flights - small_run[0].flights
    assert 0 < outcome.problem.flights_made <= new + len(whole.candidates) * 64
    one, other = result_of(copy), result_of(tmp_path / "whole")
    # The shorter run's own finalists stay recorded, and its study said three generations.
    extra = [name for name in one if name not in other]
    assert all(name.startswith("flights/held-out") for name in extra)
    skip = {"run.json", "study.toml", *extra, *[name for name in one if name.startswith("inputs/")]}
    skip |= {name for name in other if name.startswith("flights/held-out")}
    compare({k: v for k, v in one.items() if k not in skip}, {k: v for k, v in other.items() if k not in skip})
    # A further resume keeps to the longer budget.
    assert len(resumed(copy)[0].generations) == 5


def test_a_search_is_never_shortened(copy):
    with pytest.raises(InputError, match="can only be extended"):
        reopen(copy, 2)


def test_the_inputs_run_alone_to_the_same_result(small_run, copy, tmp_path):
    study = load_study(copy / read_record(copy).study)
    TuningRun(study, Folder.create(tmp_path / "alone"), Watcher(), threads=2).carry_out()
    one, other = result_of(tmp_path / "alone"), result_of(small_run[1])
    different = [name for name in one if one[name] != other[name]]
    assert different == ["study.toml"]


def test_an_airframe_file_is_carried_along(tmp_path):
    source = tmp_path / "study"
    (source / "frames").mkdir(parents=True)
    import plant.quadrotor.airframes

    bundled = next(iter(plant.quadrotor.airframes.__path__))
    shutil.copy(f"{bundled}/hummingbird.toml", source / "frames" / "mine.toml")
    from tests.tuner.conftest import QUICKSTART, SMALL

    # The study's own name in another folder: both lie in inputs/ in the end.
    text = QUICKSTART.read_text().replace('name = "hummingbird"', 'file = "frames/mine.toml"', 1)
    (source / "mine.toml").write_text(text)
    first = TuningRun(
        load_study(source / "mine.toml", SMALL), Folder.create(tmp_path / "r"), Watcher(), threads=2
    ).carry_out()
    shutil.rmtree(source)
    shutil.move(tmp_path / "r", tmp_path / "moved")
    outcome, _ = resumed(tmp_path / "moved")
    assert outcome.problem.flights_made == 0
    np.testing.assert_array_equal(outcome.finalist_rows, first.finalist_rows)


def test_sessions_are_told(replayed):
    told = json.loads((replayed[2] / "environment.json").read_text())
    assert len(told["resumed"]) == 2 and all("started" in entry and "command" in entry for entry in told["resumed"])


def test_a_replayed_run_has_taken_at_least_the_time_it_took(small_run, replayed):
    then, now = (pd.read_csv(path / "history.csv") for path in (small_run[1], replayed[2]))
    assert (now.seconds.to_numpy() >= then.seconds.to_numpy()).all()
    np.testing.assert_allclose(now.flight_seconds, then.flight_seconds, rtol=1e-12)


# Verification


def test_a_run_is_verified(small_run):
    found = verify(small_run[1], None, 2, Watcher())
    assert found.identical and found.candidates == 24 and found.flown == 24
    assert found.flights >= 24 * 4 and "every bit is the same" in found.words
    few = verify(small_run[1], 5, 1, Watcher())
    assert few.identical and few.flown == 5 and few.flights == 20


def spoil_table(file, column, change):
    table = read_frame(file) if file.suffix == ".npz" else pd.read_csv(file)
    table.loc[2, column] = change(table.loc[2, column])
    if file.suffix == ".npz":
        write_frame(file, table)
    else:
        table.to_csv(file, index=False, float_format="%.17g")


def up(value):
    return float(np.nextafter(value, np.inf))


def test_one_bit_of_a_recorded_candidate_is_found(copy):
    file = copy / "generations" / "0001.npz"
    column = next(name for name in read_frame(file).columns if name.startswith("objective:"))
    spoil_table(file, column, up)
    found = verify(copy, 3, 2, Watcher())
    assert not found.identical
    assert f"generations/0001.npz, row 2, {column}: recorded" in found.words


def test_one_bit_of_the_front_is_found(copy):
    column = next(name for name in pd.read_csv(copy / "front.csv").columns if name.startswith("held_out:"))
    spoil_table(copy / "front.csv", column, up)
    found = verify(copy, 3, 2, Watcher())
    assert f"front.csv, row 2, {column}: recorded" in found.words


def test_other_gains_are_found(copy):
    document = json.loads((copy / "gains.json").read_text())
    entry = document["gains"]["roll.k1"]
    entry["value"] = up(entry["value"])
    (copy / "gains.json").write_text(json.dumps(document))
    assert verify(copy, 3, 2, Watcher()).difference == "gains.json holds other values"


def test_forged_flights_are_found_where_they_are_flown_again(copy):
    """A file whose name fits its forged bytes passes for undamaged: only flying again tells."""
    from tuner.store.flights import BLOCKS, digest_of
    from tuner.store.npz import npz_bytes
    from tuner.store.tables import TableFile

    file = flights_file(copy, "search-0002")
    table = TableFile(file)
    # Meters that no quantity of the study reads: the replay cannot tell.
    name = "z.peak" if "z.peak" in table.names else table.names[-6]
    columns = {column: table.column(column) for column in table.names}
    forged = table.numbers(name).copy()
    forged[5] = up(forged[5])
    columns[name] = forged
    file.write_bytes(npz_bytes(columns, **{BLOCKS: table.note(BLOCKS)}))
    file.rename(file.with_name(f"search-0002-{digest_of(file.read_bytes())}.npz"))
    found = verify(copy, None, 2, Watcher())
    assert not found.identical and f"{name}: recorded" in found.words


@pytest.mark.parametrize("name", ["flights/search-0000-*.npz", "start.json", "generations/0002.npz"])
def test_what_is_missing_or_damaged_is_a_difference(copy, name):
    next(copy.glob(name)).write_bytes(b"no")
    found = verify(copy, 2, 2, Watcher())
    assert not found.identical
    assert any(word in found.words for word in ("damaged", "cannot be read", "recorded"))


def test_a_run_that_is_not_finished_is_verified_as_far_as_it_went(copy):
    for name in ("front.csv", "summary.json", "gains.json", "generations/0002.npz"):
        (copy / name).unlink()
    unsealed(copy)
    found = verify(copy, None, 2, Watcher())
    assert found.identical and not found.finished and found.candidates == 16


def test_verification_writes_nothing(copy):
    before = {file: file.stat().st_mtime_ns for file in copy.rglob("*")}
    verify(copy, 2, 2, Watcher())
    assert {file: file.stat().st_mtime_ns for file in copy.rglob("*")} == before


# Judging again


def judged(path, out, **changes):
    first, asked = judging_study(path, None, {key.replace("__", "."): value for key, value in changes.items()})
    folder = Folder.create(out)
    return judgement(path, first, asked, folder, Watcher(), 2).carry_out()


def test_the_same_judgement_gives_the_same_result_without_a_flight(small_run, tmp_path):
    outcome = judged(small_run[1], tmp_path / "again")
    assert outcome.problem.flights_made == 0
    one, other = result_of(tmp_path / "again"), result_of(small_run[1])
    assert [name for name in other if one.get(name) != other[name]] == ["run.json", "start.json", "study.toml"]
    # Its folder is that of a judgement, which no run goes on with.
    with pytest.raises(StoreError, match="folder of a judgement"):
        reopen(tmp_path / "again", None)


@pytest.fixture(scope="module")
def unraced(small_run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "unraced"
    return run_small(folder, search__racing=False), folder


def test_another_risk_and_another_metric_need_no_flight_of_the_candidates(unraced, tmp_path):
    first, folder = unraced
    outcome = judged(folder, tmp_path / "r", objective__0__level=0.5, objective__1__metric="itae.yaw")
    assert outcome.study.objectives[0].label.startswith("cvar50")
    np.testing.assert_array_equal(outcome.archive.points, first.archive.points)
    # Only finalists that had not been chosen before fly, on held-out scenarios, and the new choice to be confirmed.
    checked = {row.tobytes() for row in first.finalist_rows}
    fresh = sum(row.tobytes() not in checked for row in outcome.finalist_rows)
    same = outcome.gains(outcome.tuned).tobytes() == first.gains(first.tuned).tobytes()
    assert outcome.problem.flights_made == 32 * (fresh + (not same))
    # What a problem without a memory finds for the same points is the same.
    alone = problem_of(outcome.study, 2, None)
    found = alone.evaluate(outcome.archive.points[:6], batches(outcome.study, SEARCH), fly_all=True)
    np.testing.assert_array_equal(found.values, outcome.archive.values[:6])


def test_another_limit_and_another_pick_need_no_flight_at_all(unraced, tmp_path):
    outcome = judged(unraced[1], tmp_path / "r", constraint__1__max=0.03, pick__rule="closest")
    assert outcome.problem.flights_made in (0, 32)  # 32 where the pick is another one, which is then confirmed


def test_only_the_judgement_may_differ(small_run):
    with pytest.raises(InputError, match="scenario.*only these may: objective"):
        judging_study(small_run[1], None, {"scenario.0.air.altitude": 20.0})


# Races


@pytest.fixture(scope="module")
def raced(small_run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "raced"
    changes = {
        "search__algorithm": "nsga2",
        "search__racing": True,
        "search__generations": 6,
        "scenario__0__search": 16,
    }
    return run_small(folder, **changes), folder


def test_a_race_spares_flights_and_counts_the_others(raced):
    outcome, folder = raced
    last = outcome.generations[-1]
    assert last.raced > 0 and last.flights_raced > 0
    assert last.flights + last.flights_raced + last.flights_saved == 6 * 8 * 16
    table = pd.concat([read_frame(file) for file in sorted((folder / "flights").glob("search-*"))])
    assert len(table) == last.flights
    # Whoever is on the front, and the default, flew everything.
    complete = np.concatenate([entry.evaluation.complete for entry in outcome.generations])
    assert complete[outcome.archive.front()].all() and complete[0]


def test_a_raced_run_is_resumed_and_verified(raced, tmp_path):
    shutil.copytree(raced[1], tmp_path / "copy")
    flights_file(tmp_path / "copy", "search-0004").unlink()
    outcome, _ = resumed(tmp_path / "copy")
    assert outcome.problem.flights_made > 0
    compare(result_of(tmp_path / "copy"), result_of(raced[1]))
    found = verify(tmp_path / "copy", None, 2, Watcher())
    assert found.identical and found.flown == int(outcome.archive.flown.sum())


def test_the_same_judgement_of_a_raced_run_needs_no_flight(raced, tmp_path):
    outcome = judged(raced[1], tmp_path / "r")
    assert outcome.problem.flights_made == 0
    np.testing.assert_array_equal(outcome.archive.values, raced[0].archive.values)
