"""Successive halving: who goes on follows from fronts in one box, and a killed race ends in the same bits."""

import json
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.tuner.experiments.again.killing import TIMES, assert_covered, finish, result_of
from tests.tuner.study.loading import load_contest
from tests.tuner.study.study_text import STUDY
from tuner.extensions.contests.race import (
    RungRun,
    Standing,
    contested,
    is_far_ahead,
    keep_feasible,
    least_violations,
    shares,
)
from tuner.extensions.contests.reading import slug_of
from tuner.extensions.contests.run import ContestRun
from tuner.extensions.contests.tuning import TuningRun
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder

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
    assert compared == (1 + len(result.prepared[0].offered)) * result.study.flights_each
    words = json.loads((folder / "contest.json").read_text())["words"]
    assert words[0].startswith(f"Rung 1, 1 generations: {best['contender']} (") and "stopped: " in words[0]
    total = searches + sum(row["flights"] for row in stopped)
    assert words[1].startswith(f"Successive halving made {total:,} search flights for 4 contenders")
    assert "Stopped searches" in (folder / "report.html").read_text()


def test_a_finalist_is_tuned_as_it_would_be_alone(race, tmp_path):
    result, folder = race
    name = result.names[0]
    study = result.study.contenders[0].study
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
        patch.setattr("tuner.experiments.compare.run.fly_groups", lambda *_: (_ for _ in ()).throw(Stopped))
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


TRAVEL = [{"metric": "failure", "max": 0.0}, {"metric": "travel", "max": 20.0}]
"""Limits that only the light vehicle keeps: the heavy rotors of the other one travel 72 1/s."""


@pytest.mark.slow
def test_a_finalist_with_nothing_within_the_limits_is_not_carried_on(file, tmp_path):
    result = carried_out(file, tmp_path / "three", halving__finalists=3, constraint=TRAVEL)
    assert result.names == ["hybrid / hummingbird", "ladrc / hummingbird"]
    words = json.loads((tmp_path / "three" / "contest.json").read_text())["words"]
    (said,) = [text for text in words if "would decide nothing" in text]
    assert said.startswith("Of 3 finalists 2 finalists are compared: the others have nothing within the limits")


@pytest.mark.slow
def test_a_finalist_that_ends_with_nothing_feasible_is_no_opponent(file, tmp_path, monkeypatch):
    """As where a search loses its feasible candidates on held-out flights: the race itself keeps all here."""
    monkeypatch.setattr("tuner.extensions.contests.race.contested", lambda _, rows: list(rows))
    folder = tmp_path / "three"
    result = carried_out(file, folder, halving__finalists=3, constraint=TRAVEL)
    assert result.names == ["hybrid / hummingbird", "ladrc / hummingbird"] and ContestRun.is_feasible(result)
    document = json.loads((folder / "contest.json").read_text())
    last = [row for row in document["rungs"] if row["rung"] == 2]
    assert [(row["goes_on"], row["feasible"]) for row in last].count((False, False)) == 1 and len(last) == 3
    assert any(text.startswith("Of 3 finalists 2 finalists are compared") for text in document["words"])
    runs = [json.loads(path.read_text())["flights"] for path in sorted(folder.glob("contenders/*/summary.json"))]
    stopped = sum(row["flights"] for row in document["rungs"] if row["rung"] == 1 and not row["goes_on"])
    points = sum(len(each.offered or []) for each in result.prepared) + len(result.prepared)
    assert len(runs) == 3 and result.flights == sum(runs) + stopped + points * result.study.flights_each


def entrant(name, front, feasible=True, flights=10) -> Any:
    study = SimpleNamespace(search=SimpleNamespace(generations=5))
    points = [SimpleNamespace(picked=np.array(values)) for values in front]
    return SimpleNamespace(
        contender=SimpleNamespace(name=name, study=study), feasible=feasible, offered=points, search_flights=flights
    )


def a_contest(halving=True, claims=(), published=()) -> Any:
    return SimpleNamespace(halving=object() if halving else None, claims=claims, published=published)


def test_whole_searches_without_a_feasible_point_are_one_rung_more():
    entrants: list[Any] = [entrant("a", [[1.0, 2.0]]), entrant("b", [[9.0, 9.0]], False), entrant("c", [[2.0, 1.0]])]
    contest: Any = a_contest()
    kept, rows = keep_feasible(contest, entrants, 3)
    assert kept == [entrants[0], entrants[2]]
    # The box of a and c ends at 2.2: a holds (2.2 - 1)(2.2 - 2) of it.
    share = 1.2 * 0.2 / 2.2**2
    assert [(row.rung, row.contender, row.goes_on) for row in rows] == [(3, "a", True), (3, "b", False), (3, "c", True)]
    assert [row.share for row in rows] == pytest.approx([share, 0.0, share])
    # All are compared where all or none are feasible, where the study names its contenders, and without a race.
    for others, given in (
        (entrants[::2], contest),
        ([entrants[1]], contest),
        (entrants, a_contest(halving=False)),
        (entrants, a_contest(claims=("a",))),
        (entrants, a_contest(published=("a",))),
    ):
        assert keep_feasible(given, others, 1) == (others, [])


@pytest.mark.parametrize(
    ("other", "ahead"),
    [
        ([[1.2, 2.3], [2.3, 1.2]], True),
        # One point is within a tenth of the front's.
        ([[1.2, 2.3], [2.3, 1.1]], False),
        # Worse than either point in one objective alone.
        ([[1.5, 1.5]], False),
        ([], True),
    ],
)
def test_a_front_is_far_ahead_where_each_point_is_a_tenth_worse_in_everything(other, ahead):
    front = np.array([[1.0, 2.0], [2.0, 1.0]])
    given = np.array(other, dtype=float).reshape(-1, 2)
    assert is_far_ahead(front, given) is ahead
    assert contested([front, given], [4, 1]) == ([4] if ahead else [4, 1])


def test_where_nothing_is_feasible_every_finalist_goes_on():
    nothing = np.empty((0, 2))
    assert contested([nothing, nothing], [2, 0]) == [2, 0]


def toml(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{key}" = {toml(entry)}' for key, entry in value.items()) + "}"
    return str(value)
