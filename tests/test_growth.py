"""What a flight costs does not grow with the number of flights, of scenarios or with the length of a flight: by memory, not by clock."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from objectives.decisions import DecisionSpace
from objectives.flown_system import FlightBatch
from objectives.metrics import parse
from objectives.problem import Objective, Problem
from objectives.risk import Risk
from objectives.system import System
from plant.air.air import AirSpec
from plant.law_registry import law
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.scenarios import SEARCH, ScenarioSpec
from plant.references.steps import Steps

ROOT = Path(__file__).parents[1]
TIMING = Timing(0.004, 0.001)
# Up to 24 rows of wind and noise, 8 bytes each, drawn, stacked and laid out in lanes: 600 bytes were seen.
PERIOD_BYTES = 24 * 8 * 4


def problem_and_row():
    vehicle, cascade = load("hummingbird").vehicle, close_cascade(law("ladrc"), law("hybrid"))
    system = System(
        vehicle, cascade, nominal(vehicle, ControlOptions(), TIMING.control_period), Limits(5.0, 0.17), TIMING
    )
    row = np.array(default_row(cascade))
    objectives = (Objective(parse("itae.position"), Risk("mean")),)
    return Problem(system, DecisionSpace((), (), tuple(row)), objectives, (), 1, threads=1), row


def spec(seconds: float) -> ScenarioSpec:
    return ScenarioSpec("growth", seconds, Steps(x=1.0, time=0.02), AirSpec(intensity="moderate", mean_wind=False))


def traced_peak(monkeypatch, candidates: int, scenarios: int, seconds: float) -> int:
    """Largest memory that an evaluation held at once [B]; NumPy tells tracemalloc of its arrays. Flights are those of a stand-in."""
    import tracemalloc

    problem, row = problem_and_row()

    def stand_in(gains, nominal, inputs, on_flights_done=None):
        return np.zeros((len(gains), inputs.count, problem.flyer.rows))

    monkeypatch.setattr(problem.flyer, "fly", stand_in)
    gains, batch = np.tile(row, (candidates, 1)), FlightBatch(spec(seconds), SEARCH, scenarios)
    tracemalloc.start()
    try:
        problem.evaluate_gains(gains, (batch,))
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_ten_times_the_candidates_hold_ten_times_the_results_and_nothing_more(monkeypatch):
    """Beyond wind and noise, which all share: results, meters and scores of a flight, 1.2 kB; 4 kB leaves room."""
    few, many = (traced_peak(monkeypatch, n, 16, 0.1) for n in (20, 200))
    assert many - few < 180 * 16 * 4096


def test_wind_and_noise_of_flown_chunks_are_let_go(monkeypatch):
    """Beyond what is kept between generations, 8 chunks hold no more than 3; their scores and results do."""
    monkeypatch.setattr("objectives.problem.CHUNK", 32)
    monkeypatch.setattr("objectives.engine.MAX_CACHED", 64)
    periods, more = 250, (8 - 3) * 32
    few, many = (traced_peak(monkeypatch, 1, chunks * 32, periods * TIMING.control_period) for chunks in (3, 8))
    # Held, they would be 15 rows of 8 bytes a period; a flight's results and scores are 1.2 kB.
    assert many - few < more * (0.25 * periods * 15 * 8 + 2048)


def test_memory_grows_with_the_length_of_a_flight_by_wind_and_noise_alone(monkeypatch):
    short, long = (traced_peak(monkeypatch, 1, 16, seconds) for seconds in (0.4, 4.0))
    assert long - short < 1.25 * 16 * 900 * PERIOD_BYTES


@pytest.mark.slow
@pytest.mark.parametrize("point", ["1000,16,1.0", "1,65536,0.2"], ids=["16 000 flights", "65 536 scenarios"])
def test_many_flights_take_a_process_little_more_memory_than_its_first_ones(point):
    """Of 165 MB after the first 16 flights they made 186 and 172 MB; 65 536 flights of 0.2 s are 0.4 GB of wind and noise."""
    import json

    command = [sys.executable, "-m", "benchmarks.growth", "--point", point]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    measured = json.loads(done.stdout.splitlines()[-1])
    assert measured["flights"] >= 16_000
    assert measured["peak_mb"] - measured["base_mb"] < 60.0
