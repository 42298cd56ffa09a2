"""Dead time of hundreds of control periods: flown as the answer without it, later, and judged by the closed form of its margins."""

import numpy as np
import pytest

from objectives.margins.plant_margins import PlantMargins
from plant.model.plan import Actuator
from tests.tuner.extensions.textbook_laws.loops import answer, loop_of, row_of, with_actuator

H, PERIODS = 0.01, 300
LOOP = loop_of([1.0], [1.0, 0.0], "pid_parallel", H)
LATE = with_actuator(LOOP, Actuator("u", delay=PERIODS * H))
GAINS = {"kp": 0.1, "ki": 0.0, "kd": 0.0, "t_f": 0.0}


def test_a_flight_answers_the_dead_time_later():
    """Until the answer itself comes back the command is constant, so the output is a ramp from the dead time on."""
    late = answer(LATE, 2.0 * PERIODS * H, **GAINS)
    moved = np.maximum(late.t - PERIODS * H, 0.0) * 0.1
    # An input's delay counts from the sample; the command itself goes out one period later at most.
    assert np.max(np.abs(late.y - moved)) <= 0.1 * H + 1e-12
    assert late.y[PERIODS] == 0.0 and late.y[-1] > 0.28


def test_margins_are_those_of_an_integrator_with_dead_time():
    """K/s with dead time L: gain margin pi/(2 K L), phase margin 90 deg - K L; half a period of hold belongs to L."""
    row = row_of(LATE, **GAINS)
    found = PlantMargins(LATE, 0.99 * row, 1.01 * row).evaluate(row[None])
    late = (PERIODS + 0.5) * H
    assert found.gain_up.value[0, 0] == pytest.approx(np.pi / (2.0 * 0.1 * late), rel=1e-4)
    assert found.phase.value[0, 0] == pytest.approx(np.pi / 2.0 - 0.1 * late, rel=1e-4)
