"""Memory does not grow with the number of flights: 100 000 of 10 s stay under 2 GiB, however they are shared out."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

BATCH = """
import resource, sys
import numpy as np
from objectives.decisions import DecisionSpace
from objectives.metrics import parse
from objectives.system import System
from objectives.problem import FlightBatch, Objective, Problem
from objectives.risk import Risk
from plant.quadrotor.nominal import ControlOptions, nominal
from tests.plant.loops import LIMITS, NOMINAL, TIMING, VEHICLE, gains, loop, spec
candidates, scenarios = map(int, sys.argv[1:])
system = System(VEHICLE, loop().cascade, NOMINAL, LIMITS, TIMING)
wanted = (Objective(parse("itae.position"), Risk("mean")),)
problem = Problem(system, DecisionSpace((), (), tuple(gains().tolist())), wanted, (), 1)
result = problem.evaluate_gains(np.tile(gains(), (candidates, 1)), (FlightBatch(spec(10.0), "search", scenarios),))
assert result.scores.shape == (candidates, 1, scenarios)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""


@pytest.mark.slow
@pytest.mark.parametrize(("candidates", "scenarios"), [(1000, 100), (10, 10_000)])
def test_a_hundred_thousand_flights_stay_under_two_gibibytes(candidates, scenarios):
    done = subprocess.run(
        [sys.executable, "-c", BATCH, str(candidates), str(scenarios)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
        timeout=1200,
    )
    assert float(done.stdout) < 2048.0
