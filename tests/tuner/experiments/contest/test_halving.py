"""Successive halving: who goes on follows from fronts in one box, and a killed race ends in the same bits."""

import json

import numpy as np
import pytest

from tests.tuner.experiments.again.killing import TIMES, assert_covered, finish, result_of
from tests.tuner.study.loading import load_contest
from tests.tuner.study.study_text import STUDY
from tuner.experiments.contest.halving import RungRun, Standing, least_violations, shares
from tuner.experiments.contest.run import ContestRun
from tuner.experiments.contest.tuning import TuningRun
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.contest_reading import slug_of

# Two laws on two vehicles: another law would be compiled for these tests alone, for 10 s.
CHOICES = (
    STUDY.replace('"tilt.lambda" = { low = 1, high = 16 }\n"roll.k1" = 20.0', "")
    + """
[choices]
"controller.attitude" = ["hybrid", "ladrc"]
"airframe.name" = ["hummingbird", "f450"]

[halving]
factor = 4
least = 1

[mission]
off = ["rms.position"]
"""
)
GAINS = {"tilt.omega_o": {}, "tilt.lambda": {}, "tilt.omega_c": {}}
SIZES = {"confidence": 0.0, "gains": GAINS, "search.generations": 3, "search.population": 8}


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("choices") / "choices.toml"
    path.write_text(CHOICES)
    return path


def carried_out(file, folder, threads=2, **changes):
    contest = load_contest(file, {**SIZES, **{key.replace("__", "."): value for key, value in changes.items()}})
    run = ContestRun(contest, Folder.open_or_create(folder), Watcher(), threads=threads)
    return run.carry_out()


@pytest.fixture(scope="module")
def race(file, tmp_path_factory):
    folder = tmp_path_factory.mktemp("races") / "race"
    return carried_out(file, folder), folder


def standing(front, violations=((0.0,),)):
    return Standing(None, 1, np.array(front, dtype=float).reshape(-1, 2), np.array(violations, dtype=float), 8)  # type: ignore[arg-type]


def test_shares_are_of_the_box_of_all_fronts():
    """By hand: the nadir is (4, 4), the box ends at 4.4; the first front leaves a corner of 1.0 by 2.4 of it."""
    first, second, none = standing([[1.0, 4.0], [2.0, 2.0]]), standing([[4.0, 1.0]]), standing([])
    box = 4.4 * 4.4
    areas = [(4.4 - 1.0) * 0.4 + (4.4 - 2.0) * (4.0 - 2.0), 0.4 * (4.4 - 1.0), 0.0]
    assert shares([first, second, none]) == pytest.approx([area / box for area in areas])
    assert shares([none, none]) == [0.0, 0.0]


def test_violations_of_all_contenders_have_the_same_units():
    near, far = standing([], [[0.2, 0.0], [0.0, 5.0]]), standing([], [[0.4, 0.0], [0.3, 10.0]])
    # Medians 0.3 and 7.5 round down to 0.25 and 4: the least totals are 0.2/0.25 and 0.4/0.25.
    assert least_violations([near, far]) == pytest.approx([0.8, 1.6])


def test_the_better_front_goes_on_and_the_others_stop(race):
    result, folder = race
    rows = json.loads((folder / "contest.json").read_text())["rungs"]
    assert [(row["rung"], row["contender"], row["generations"]) for row in rows] == [
        (1, "hybrid / hummingbird", 1), (1, "hybrid / f450", 1), (1, "ladrc / hummingbird", 1), (1, "ladrc / f450", 1),
    ]  # fmt: skip
    best = max(rows, key=lambda row: row["share"])
    assert [row["contender"] for row in rows if row["goes_on"]] == [best["contender"]] == result.names
    stopped = [row for row in rows if not row["goes_on"]]
    searches = result.prepared[0].search_flights
    compared = result.flights - sum(row["flights"] for row in stopped) - result.prepared[0].flights
    assert compared == (1 + len(result.prepared[0].offered)) * result.contest.flights_each
    words = json.loads((folder / "contest.json").read_text())["words"]
    assert words[0].startswith(f"Rung 1, 1 generations: {best['contender']} (") and "stopped: " in words[0]
    total = searches + sum(row["flights"] for row in stopped)
    assert words[1].startswith(f"Successive halving made {total:,} search flights for 4 contenders")
    assert "Stopped searches" in (folder / "report.html").read_text()


def test_a_finalist_is_tuned_as_it_would_be_alone(race, tmp_path):
    result, folder = race
    name = result.names[0]
    study = result.contest.contenders[0].study
    outcome = TuningRun(study, Folder.create(tmp_path / "alone"), Watcher(), threads=1).carry_out()
    assert np.array_equal(
        outcome.finalists.evaluation.values[outcome.finalists.non_dominated][0], result.prepared[0].offered[0].picked
    )
    alone = (tmp_path / "alone" / "front.csv").read_bytes()
    assert (folder / "contenders" / slug_of(name) / "front.csv").read_bytes() == alone


def test_a_stopped_search_made_its_first_generations_alone(race):
    _, folder = race
    rows = json.loads((folder / "contest.json").read_text())["rungs"]
    for row in rows:
        inside = folder / "contenders" / slug_of(row["contender"])
        assert len(list((inside / "generations").iterdir())) == (3 if row["goes_on"] else 1)
        assert (inside / "summary.json").exists() is row["goes_on"]
    assert_covered(folder)


def timeless(folder):
    """Documents of a race and of its searches, without times, sessions and what is drawn."""
    documents = {}
    for name, content in result_of(folder).items():
        place = name.rpartition("/")[2]
        if place in ("contest.json", "summary.json"):
            document = json.loads(content) if isinstance(content, bytes) else content
            documents[name] = {key: value for key, value in document.items() if key not in TIMES}
        elif (
            place not in ("environment.json", "history.csv", "report.html", "manifest.json", ".lock")
            and "/figures/" not in name
        ):
            documents[name] = content
    return documents


class Stopped(Exception):
    """An end in the middle."""


@pytest.mark.slow
def test_stopped_anywhere_and_resumed_it_ends_in_the_same_bits(race, file, tmp_path, monkeypatch):
    """It stops in the second search of the rung, is gone on with on one thread and stops again before the comparison."""
    folder, begun = tmp_path / "race", []
    fly = RungRun.fly

    def stopping(run):
        begun.append(run)
        if len(begun) == 2:
            raise Stopped
        return fly(run)

    with monkeypatch.context() as patch:
        patch.setattr(RungRun, "fly", stopping)
        with pytest.raises(Stopped):
            carried_out(file, folder)
    with monkeypatch.context() as patch:
        patch.setattr("tuner.experiments.contest.run.fly_groups", lambda *_: (_ for _ in ()).throw(Stopped))
        with pytest.raises(Stopped):
            carried_out(file, folder, threads=1)
    finish("resume", folder, "--threads", 1)
    one, other = timeless(folder), timeless(race[1])
    assert sorted(one) == sorted(other) and [name for name in one if one[name] != other[name]] == []


@pytest.mark.slow
def test_more_finalists_are_compared(file, tmp_path):
    result = carried_out(file, tmp_path / "two", halving__finalists=2)
    assert len(result.names) == 2 and len(result.comparison.differences) > 0
    said, _ = finish(
        "check", file, *[part for key, value in SIZES.items() for part in ("--set", f"{key}={toml(value)}")]
    )
    words = " ".join(said.split())
    assert "Successive halving: 4 to 1 generations, 1 to 3." in words and "Not every search has starts" in words


def toml(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{key}" = {toml(entry)}' for key, entry in value.items()) + "}"
    return str(value)
