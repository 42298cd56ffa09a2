"""`python -m benchmarks.search`: its budgets, peers in processes of their own, shares of the best known, and what a rerun races."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import benchmarks.search.__main__ as command
from benchmarks.peers import environments
from benchmarks.search import choices, transfer
from benchmarks.search.contestants import AUTO, BEFORE, CONTESTANTS, Contestant
from benchmarks.search.peer import PEERS, Peer, Start
from benchmarks.search.problems import RACED, VALIDATION
from benchmarks.search.process import PeerFailed, PeerProcess
from benchmarks.search.race import GOALS, Run, Step, judged
from benchmarks.search.table import best_known, curves, markdown
from tuner.study.kinds import load_gains_study

NOWHERE = Path("never used: the toy needs no environment of its own")


class Sum:
    """The least sum of coordinates, one objective."""

    def front(self, points):
        return points.sum(axis=1, keepdims=True)[:1]

    def worth(self, front):
        return float(front.min())


def steps(batch: int, count: int, seconds: float = 0.0):
    draw, flights = np.random.default_rng(0), 0
    for number in range(count):
        points = draw.uniform(size=(batch, 2))
        flights += batch
        yield Step(points, points.sum(axis=1, keepdims=True), np.zeros((batch, 1)), flights, seconds * number)


def contestant(**more):
    return Contestant("nothing", "tool", **more)


def test_a_front_is_judged_once_for_each_goal_that_was_passed():
    run = judged(steps(150, 100), Sum(), contestant(most_flights=1000))
    assert run.stopped == ""
    # 150 flights at a time pass 200 and so on; a batch that passes two goals is judged once.
    assert [entry.flights for entry in run.entries] == [300, 450, 600, 750, 1050]
    assert [entry.candidates for entry in run.entries] == [entry.flights for entry in run.entries]


def test_what_is_judged_is_the_best_so_far():
    run = judged(steps(50, 100), Sum(), contestant(most_flights=GOALS[2]))
    told = np.concatenate([step.values for step in steps(50, 100)])
    assert [entry.worth for entry in run.entries] == [told[: entry.flights].min() for entry in run.entries]
    assert run.front == [[told[: run.entries[-1].flights].min()]]


def test_the_processor_budget_counts_the_time_of_a_peer_and_judges_what_was_reached():
    run = judged(steps(50, 100, seconds=10.0), Sum(), contestant(most_seconds=25.0))
    assert run.stopped == "after 25 s of a processor"
    assert run.entries[-1].flights == 200 and run.entries[-1].seconds >= 30.0


def test_a_search_that_has_nothing_left_to_ask_keeps_what_it_found():
    run = judged(steps(50, 5), Sum(), contestant())
    assert run.stopped == "it asks no more" and run.entries[-1].flights == 250


def test_what_survives_a_search_is_all_that_is_judged_at_its_end():
    def with_survivors():
        yield from steps(50, 5)
        yield Step(np.full((2, 2), 0.75), np.full((2, 1), 1.5), np.zeros((2, 1)), 270, survivors=True)

    run = judged(with_survivors(), Sum(), contestant())
    assert run.stopped == "" and [entry.flights for entry in run.entries] == [200, 270]
    assert run.entries[-1].worth == 1.5 and run.entries[-1].candidates == 250
    # What was seen on the way stays part of the best known.
    assert run.front == [[run.entries[0].worth]]


def excess(points):
    return points[:, :1] - 0.5


START = Start(np.array([[0.5, 0.25], [1.0 / 3.0, 0.1]]), 3, 1, 2, 7, excess)
TOY = Peer("tests.search_peer")


def test_a_peer_in_a_process_of_its_own_asks_the_same_to_the_last_bit_and_says_why_it_ends():
    here = TOY.begun(START)
    with PeerProcess(TOY, START, NOWHERE) as there:
        for _ in range(3):
            points = here.ask()
            assert np.array_equal(there.ask(), points)
            for search in (here, there):
                search.tell(points.sum(axis=1, keepdims=True), np.zeros((len(points), 2)))
        assert 0.0 < there.seconds < 5.0
        with pytest.raises(PeerFailed, match="ValueError: values are above 0"):
            there.tell(-np.ones((3, 1)), np.zeros((3, 2)))


def test_every_peer_is_a_contestant_that_flies_four_times_a_candidate():
    entered = [entry for entry in CONTESTANTS.values() if entry.peer is not None]
    assert sorted(map(id, PEERS.values())) == sorted(id(entry.peer) for entry in entered)
    assert {entry.overrides["scenario.0.search"] for entry in entered} == {4}


def run_of(name: str, seed: int, front, worths, problem="quickstart", default=(1.0, 1.0)):
    entries = [
        {"flights": flights, "candidates": flights // 4, "seconds": flights / 100.0, "worth": worth}
        for flights, worth in worths.items()
    ]
    return {
        "problem": problem,
        "contestant": name,
        "seed": seed,
        "revision": "abc",
        "processor": "one",
        "default": list(default),
        "entries": entries,
        "front": front,
        "stopped": "",
    }


def test_the_best_known_is_the_front_of_everyone_together():
    runs = [
        run_of("nsga2", 1, [[0.2, 0.6]], {500: 0.2}),
        run_of("random", 1, [[0.6, 0.2], [0.7, 0.7]], {500: 0.1}),
        run_of("random", 2, [[1.0, 0.5]], {500: 0.1}),
    ]
    # Of a box of 1.1 by 1.1: two rectangles of 0.9 x 0.5 that share 0.5 x 0.5.
    both = (2 * 0.9 * 0.5 - 0.5 * 0.5) / 1.1**2
    assert best_known(runs, "quickstart") == pytest.approx({1: both, 2: 0.1 * 0.6 / 1.1**2})
    assert curves(runs, "quickstart")["nsga2"][0].shares == pytest.approx([0.2 / both])


def test_the_best_known_is_one_of_all_seeds_where_all_are_judged_on_the_same_flights():
    runs = [run_of(AUTO, 1, [[0.2, 0.6]], {500: 0.2}, "pid12"), run_of(AUTO, 2, [[0.6, 0.2]], {500: 0.1}, "pid12")]
    both = (2 * 0.9 * 0.5 - 0.5 * 0.5) / 1.1**2
    assert best_known(runs, "pid12") == pytest.approx({1: both, 2: both})
    assert [curve.shares for curve in curves(runs, "pid12")[AUTO]] == [
        pytest.approx([0.2 / both]),
        pytest.approx([0.1 / both]),
    ]


def test_runs_of_an_earlier_revision_replace_those_before_under_its_name():
    here = [run_of(AUTO, 1, [], {500: 0.9}), run_of(f"{AUTO} at abc", 3, [], {500: 0.1})]
    there = [run_of(AUTO, 3, [], {500: 0.8}), run_of("nsga2", 3, [], {500: 0.7})]
    merged = command.with_before(here, there)
    assert [(run["contestant"], run["seed"]) for run in merged] == [(AUTO, 1), (f"{AUTO} at abc", 3)]
    assert merged[1]["entries"][0]["worth"] == 0.8


def test_validation_problems_pose_loops_of_their_kind_and_judge_all_seeds_alike():
    assert {entry.judge_seed for entry in RACED.values()} == {None}
    for entry in VALIDATION.values():
        study = load_gains_study(entry.study, "tests", entry.overrides)
        assert study.search.candidates >= 136 and entry.judge_seed is not None


def test_with_one_objective_a_share_is_the_best_value_over_the_value():
    runs = [
        run_of("cmaes", 1, [[0.4]], {500: None, 1000: 0.4}, "axes", (1.0,)),
        run_of("random", 1, [[0.2]], {500: 0.2}, "axes", (1.0,)),
    ]
    assert curves(runs, "axes")["cmaes"][0].shares == [0.0, 0.5]


def test_the_share_at_a_mark_is_the_last_one_judged_by_then():
    runs = [run_of("nsga2", 1, [[0.0, 0.0]], {208: 0.25, 520: 0.5, 900: 0.75})]
    [curve] = curves(runs, "quickstart")["nsga2"]
    # Flights up to a twentieth beyond a mark count there.
    assert [curve.after(flights) for flights in (100, 200, 500, 700, 1000)] == [None, 0.25, 0.5, 0.5, 0.75]
    assert [curve.ended(flights) for flights in (200, 900, 1000)] == [False, False, True]
    assert [curve.within(seconds) for seconds in (1.0, 5.2, 100.0)] == [None, 0.5, 0.75]
    assert curve.enough() is None


def test_the_verdict_names_peers_that_are_ahead_of_the_default():
    fast = {500: 0.9, 1000: 0.97, 3000: 0.98}
    runs = [
        run_of(AUTO, 1, [[0.0, 0.0]], fast),
        # Seeds that a peer was not raced on have no say where it is compared.
        *(run_of(AUTO, seed, [[0.0, 0.0]], {500: 0.2, 1000: 0.97, 3000: 0.98}) for seed in (2, 3)),
        run_of("pymoo AGE-MOEA2", 1, [], {500: 0.85, 1000: 0.85, 3000: 0.85}),
        run_of(BEFORE, 1, [], {11_000: 0.8}),
        run_of("Optuna TPE", 1, [], {500: 0.95, 1000: 0.96}),
        run_of("pymoo NSGA-II", 1, [], {500: 0.3, 1000: 0.4, 3000: 0.5}),
    ]
    text = markdown(runs)
    assert "quickstart: ends at 0.98 [0.98, 0.98] after 3,000 flights, 95% of the best known after 1,000." in text
    assert f"`{BEFORE}`: ends at 0.80 after 11,000 flights, 95% of the best known after 0 of 1 seeds." in text
    assert "Ahead of it: Optuna TPE at 500 flights (1 seeds)" in text and "pymoo NSGA-II at" not in text
    assert "Ended: Optuna TPE before 3,000 flights." in text
    assert "| Optuna TPE | 1 | - | 0.95 | 0.96 | (0.96) |" in text


class Course:
    objectives, default = 2, np.array([1.0, 1.0])

    def __init__(self, problem, seed):
        self.problem, self.seed = problem, seed


def test_a_rerun_races_only_what_the_document_lacks(tmp_path, monkeypatch, capsys):
    raced = []

    def race(contestant, course, envs):
        name = next(name for name, entry in CONTESTANTS.items() if entry is contestant)
        raced.append((course.problem, name, course.seed))
        return Run([], [], "left out") if name == AUTO else judged(steps(100, 20), Sum(), contestant)

    monkeypatch.setattr(command, "Course", Course)
    monkeypatch.setattr(command, "raced", race)
    monkeypatch.setattr(command, "draw_figure", lambda runs, file: None)
    monkeypatch.setattr(command, "markdown", lambda runs: "a table")

    def asked(*arguments):
        raced.clear()
        out = tmp_path / "search.json"
        monkeypatch.setattr(sys, "argv", ["search", "--out", str(out), "--problem", "quickstart", *arguments])
        command.main()
        return list(raced), json.loads(out.read_text())["runs"]

    # A name is one contestant's alone, and the beginning of names is everyone's who has it; another revision's race elsewhere.
    first, _ = asked("--contestant", "nsga2", "--contestant", "au", "--seed", "1")
    assert [name for _, name, _ in first] == [AUTO, "nsga2"]
    then, runs = asked("--contestant", "au", "--seed", "1", "--seed", "2")
    # What was left out is tried again.
    assert [(name, seed) for _, name, seed in then] == [(AUTO, 1), (AUTO, 2)]
    assert len(runs) == 3
    again, runs = asked("--contestant", "nsga2", "--seed", "1", "--again")
    assert len(again) == 1 and len(runs) == 3
    assert capsys.readouterr().out.endswith("a table\n")


def test_a_median_says_how_many_seeds_got_there():
    far, near = {500: 0.5, 1000: 0.96}, {500: 0.5, 1000: 0.6}
    for values, told in (((far, far, near), "1,000 (2 of 3 seeds)"), ((far, near, near), "1 of 3 seeds")):
        runs = [run_of(AUTO, seed, [[0.0, 0.0]], entries) for seed, entries in enumerate(values)]
        runs += [run_of(BEFORE, seed, [], {11_000: 1.0}) for seed in range(3)]
        assert f"of the best known after {told}." in markdown(runs)


def test_an_installation_that_takes_too_long_is_told(tmp_path, monkeypatch):
    def run(command, **_):
        raise subprocess.TimeoutExpired(command, 1200, stderr=b"WARNING: slow\nlooking at many versions")

    monkeypatch.setattr(environments.subprocess, "run", run)
    with pytest.raises(environments.NotInstalled, match="looking at many versions"):
        environments.python_of("slow", ("package",), tmp_path)


def test_flights_to_a_share_of_the_best_known_of_all_fronts():
    """By hand: the box ends at 1.1; together both fronts leave out the corner below (0.2, 0.6) and (0.6, 0.2)."""
    curves = [[(96, np.array([[0.2, 0.6]]))], [(96, np.empty((0, 2))), (192, np.array([[0.6, 0.2]]))]]
    best = transfer.best_known(curves, np.array([1.0, 1.0]))
    assert best == pytest.approx((0.9 * 0.5 + 0.5 * 0.4) / 1.21)
    run = {"flights": [96, 192, 288], "shares": [0.2, 0.96, 0.94]}
    assert transfer.flights_to(run, 0.95) == 192 and transfer.flights_to(run, 0.97) == np.inf


def test_tables_of_starts_and_choices_name_every_run():
    runs = [
        {"target": "wind", "start": "usual", "seed": seed, "flights": [96, 192], "shares": [0.1, last]}
        for seed, last in ((1, 0.96), (2, 0.5), (3, 0.99))
    ]
    assert (
        transfer.table(runs).splitlines()[2] == "| wind | usual | 192 (192, never, 192) | 0.960 (0.960, 0.500, 0.990) |"
    )
    race = {"winner": "a", "finalist": "b", "shares": {"a": 0.5, "b": 0.25}, "race_flights": 300, "flights": 1200}
    text = choices.table([{"study": "motor", "starts": False, "seed": 1, **race}])
    assert text.splitlines()[2] == "| motor | False | 1 | a (0.500) | b (0.250) | 300 of 1,200 (25%) |"
