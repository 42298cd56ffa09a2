"""`tuner plan` against real runs: flights to the last one, widths, memory and disk measured, warnings."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from objectives.problem import FlightBatch
from plant.quadrotor.scenarios import HELD_OUT
from plant.seeds import generator
from tests.objectives.risk.resampling import bootstrap_interval
from tests.tuner.conftest import QUICKSTART, SMALL
from tests.tuner.in_process import tuner
from tuner.experiments.planning.cost import disk_of, memory_of, planned_tails, seconds_of
from tuner.experiments.planning.counts import flights_of
from tuner.experiments.planning.pilot import FLIGHTS, fly_pilot
from tuner.experiments.planning.plan import plan_document
from tuner.experiments.tuning.problem import problem_of
from tuner.study.build import load_study

# A race stops candidates early, so that fewer are flown than is said: here none, to count them.
EVERYTHING = {**SMALL, "search.algorithm": "nsga2", "search.racing": False}
ROOT = Path(__file__).parents[4]
RUN = """
import json, sys
from pathlib import Path
import tuner.report
from tests.tuner.conftest import NoDrawing, run_small
tuner.report.start_figures = lambda folder: NoDrawing()
outcome = run_small(Path(sys.argv[1]), threads=2, search__racing=False)
# Not ru_maxrss: that of a process begins with what its parent held.
held = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
peak = int(held.split()[1]) * 1024
print(json.dumps([outcome.generations[-1].flights, outcome.flights, len(outcome.candidates), peak]))
"""


@pytest.fixture(scope="module")
def study():
    return load_study(QUICKSTART, EVERYTHING)


@pytest.fixture(scope="module")
def pilot(study):
    return fly_pilot(problem_of(study, 2, None), study)


@pytest.fixture(scope="module")
def ran(small_run, tmp_path_factory):
    """A run in a process of its own, for its memory: flights of search and in all, finalists, peak [bytes], folder."""
    # Compilers take memory too, in the first process of a machine: that is this one, by the small run.
    folder = tmp_path_factory.mktemp("runs") / "small"
    done = subprocess.run(
        [sys.executable, "-c", RUN, str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    return (*json.loads(done.stdout.splitlines()[-1]), folder)


def test_flights_are_those_of_the_run(study, ran):
    search, total, finalists, _, _ = ran
    expected = flights_of(study)
    assert search == expected.search_at_most == 8 * 3 * 4
    # The finalists and the default, then the default and the recommended point once more.
    assert total == search + (finalists + 3) * expected.held_out_each
    assert total <= expected.total_at_most and finalists <= expected.finalists_at_most == 24


def test_memory_and_disk_are_near_what_the_run_took(study, pilot, ran):
    *_, peak, folder = ran
    assert 0.85 < memory_of(study, pilot) / peak < 1.3
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    assert 0.85 < disk_of(study, pilot) / size < 1.3


def test_counts_drive_the_costs(study, pilot):
    def costs(**changes):
        asked = load_study(QUICKSTART, EVERYTHING | {key.replace("__", "."): value for key, value in changes.items()})
        return flights_of(asked).total_at_most, seconds_of(asked, pilot), memory_of(asked, pilot), disk_of(asked, pilot)

    plain = costs()
    # 4 flights fill a block of lanes as 16 do.
    same = costs(scenario__0__search=16)[1]
    drawn = 12 * pilot.scenarios[0].draw_seconds
    assert same.search - plain[1].search == pytest.approx(drawn, rel=1e-9)
    assert plain[0] == 96 + (24 + 3) * 32
    longer = costs(search__generations=30)
    assert longer[0] == 960 + (48 + 3) * 32
    assert longer[1].search > 8.0 * (plain[1].search - drawn) and longer[3] > plain[3]
    many = costs(scenario__0__held_out=1024)
    assert many[2] > plain[2] and many[1].held_out_at_most == pytest.approx(32 * plain[1].held_out_at_most, rel=1e-9)


def test_few_flights_first_cost_less(study, pilot):
    all_of_them, first = ({"scenario.0.search": 32, "search.first": n} for n in (32, 4))
    one, other = (load_study(QUICKSTART, {**EVERYTHING, **changes}) for changes in (all_of_them, first))
    assert flights_of(other).search_at_most == 24 * 4 + 24 * 28 == flights_of(one).search_at_most
    many = [
        load_study(QUICKSTART, {**EVERYTHING, **changes, "search.generations": 50}) for changes in (all_of_them, first)
    ]
    # 400 candidates, of which 65 make all flights: the first, 48 of the front and 16 around limits that bind.
    assert [flights_of(entry).search_at_most for entry in many] == [400 * 32, 400 * 4 + 65 * 28]
    # Times by hand, for what a pilot measures beside other processes moves by a third: flights alone take time.
    scenario = replace(pilot.scenarios[0], block_seconds=1.0, draw_seconds=0.0)
    timed = replace(pilot, scenarios=(scenario,), worthy_share=1.0, screen_seconds=0.0)
    # Two threads, 16 lanes: 50 generations of 4 candidates in 2 blocks; or in 1 block, then 33 times 2 blocks.
    assert [seconds_of(entry, timed).search for entry in many] == [400.0, 266.0]
    assert disk_of(many[1], pilot) < disk_of(many[0], pilot)


def test_the_pilot_starts_from_the_default_and_is_drawn_alike_for_any_thread_count(study, pilot):
    assert np.array_equal(pilot.points[0], study.space.point(study.default_row))
    assert pilot.flights == 8 * FLIGHTS and pilot.worthy_share == 1.0
    again = fly_pilot(problem_of(study, 1, None), study)
    assert np.array_equal(again.scenarios[0].scores, pilot.scenarios[0].scores)


@pytest.mark.slow
def test_widths_are_near_those_of_real_flights(study, pilot):
    study = load_study(QUICKSTART, EVERYTHING | {"scenario.0.held_out": 64})
    document = plan_document(study, pilot, None, 0.05)
    problem = problem_of(study, 2, None)
    batch = FlightBatch(study.scenarios[0].spec, HELD_OUT, 512)
    evaluation = problem.evaluate_gains(study.default_row[None], (batch,))
    for i, row in enumerate(document.objectives):
        risk = study.objectives[i].risk
        samples, random = evaluation.samples(i, None)[0], generator(1, "test/width", i)
        # What 64 of the real flights would tell, 99 times; the tail of the error is heavy, and no formula holds for its spread.
        told = [
            float(np.diff(bootstrap_interval(samples[random.permutation(len(samples))[:FLIGHTS]], risk, random))[0])
            for _ in range(99)
        ]
        share = (FLIGHTS / row.flights.held_out) ** 0.5
        assert share * min(told) < row.width.held_out < share * max(told)
        assert (row.flights.search, row.flights.held_out) == (4, 64) and row.width.search is None
        near = abs(row.default / float(evaluation.values[0, i]) - 1.0)
        assert near < 1.5 * (row.width_percent.held_out or 0.0) / 100.0


def test_thin_tails_and_lost_flights_are_warned_of(study, pilot):
    warnings = plan_document(study, pilot, None, 0.05).warnings
    assert any("cvar80(itae.position) rests on 4 search scenarios" in text for text in warnings)
    fine = plan_document(study, pilot, None, 0.00001)
    assert any("do not surely tell a difference of 0.001 %" in text for text in fine.warnings)
    small = {f"scenario.0.reference.{axis}": 0.001 for axis in "xyz"}
    lost = load_study(QUICKSTART, EVERYTHING | small | {"limits.position": 0.01})
    flown = fly_pilot(problem_of(lost, 2, None), lost)
    assert not flown.complete.any()
    document = plan_document(lost, flown, None, 0.05)
    assert any("The default lost 64 of 64 pilot flights" in text for text in document.warnings)
    assert [row.scenarios_needed for row in document.objectives] == [None, None]
    assert document.parse(document.text()) == document


def test_bounds_of_quantiles_and_estimates_of_rare_losses_are_planned(pilot):
    limits = [
        {"metric": "peak.position", "risk": "quantile", "level": 0.9, "max": 5.0},
        {"metric": "rms.position", "risk": "quantile", "level": 0.99, "max": 5.0},
        {"metric": "failure", "risk": "probability", "max": 1e-4},
        {"metric": "peak.roll", "risk": "mean", "max": 5.0},
    ]
    with_limits = load_study(QUICKSTART, EVERYTHING | {"constraint": limits})
    document = plan_document(with_limits, pilot, None, 0.05)
    first, second = document.bounds
    assert (first.flights, first.flights_needed, first.rank) == (32, 29, 1)
    assert "95 % sure that 90 % of flights stay below: 29 flights needed" in first.words
    assert first.words.endswith("the study has 32 held out, whose largest value is the bound.")
    assert (second.flights_needed, second.rank) == (299, None) and "too few" in second.words
    [tail] = document.tails
    assert (tail.method, tail.points_at_most) == ("splitting", 5) and 10_000 < tail.flights < 40_000
    # 16 flights a block, on two threads.
    timed = replace(pilot, scenarios=(replace(pilot.scenarios[0], block_seconds=16.0, draw_seconds=1.0),))
    [by_hand] = planned_tails(with_limits, timed)
    assert by_hand.seconds == pytest.approx(tail.flights)
    assert document.seconds.tails_at_most == pytest.approx(5 * tail.seconds)
    assert f"splitting, about {tail.flights:,} flights in" in tail.words
    plain = seconds_of(load_study(QUICKSTART, EVERYTHING | {"constraint": limits[:2]}), pilot)
    assert plain.tails_at_most == 0.0


def test_command_prints_json_and_a_table(tmp_path, monkeypatch, capsys):
    path = tmp_path / "asked.toml"
    path.write_text(QUICKSTART.read_text().replace("duration = 8.0", "duration = 2.0"))
    code, out, err = tuner(monkeypatch, capsys, "plan", path, "--threads", 2, "--difference", 2, "--json")
    assert (code, err) == (0, "")
    document = json.loads(out)
    assert document["flights"]["search_at_most"] == 144 * 8 and document["difference_percent"] == 2.0
    # Margins leave a few per cent of the ranges.
    assert document["pilot"]["worth_flying_percent"] < 30.0
    easy = tmp_path / "easy.toml"
    easy.write_text(path.read_text().split("# Stability margins")[0])
    code, out, _ = tuner(monkeypatch, capsys, "plan", easy, "--threads", 2)
    assert code == 0 and "Pilot: 8 candidates" in out and "100 % of the ranges" in out
    code, out, err = tuner(monkeypatch, capsys, "plan", tmp_path / "nowhere.toml")
    assert (code, out) == (2, "") and "there is no such file" in err
