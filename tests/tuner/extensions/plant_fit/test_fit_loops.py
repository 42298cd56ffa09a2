"""The judge of `benchmarks.fit_loops` against closed forms and SciPy."""

import numpy as np
import pytest

from benchmarks.fit_loops import N_STEPS, TruePlant, margins_of
from benchmarks.plant_fit import CASES
from tests.tuner.extensions.plant_fit.test_plant_fit import sampled


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.parametrize("period", [0.5, 1.25])
def test_a_true_plant_is_that_of_scipy(case, period):
    plant = TruePlant(case, period)
    outputs = []
    for _ in range(30):
        outputs.append(plant.output)
        plant.move(1.0)
    # Twenty-five parts of a period, so that the dead times of all cases but one are whole; that one is 3.35 s.
    expected = sampled((list(case.numerator), list(case.denominator)), np.ones(30), period, case.dead_time)
    assert outputs == pytest.approx(expected, abs=2e-2 * np.abs(expected).max())


@pytest.mark.parametrize("gain", [0.3, 1.2])
def test_margins_of_an_integrator_in_a_loop_are_closed_forms(gain):
    """L = k / (z - 1): S = (z - 1) / (z - 1 + k), largest at z = -1; |L| = 1 at 2 sin(w / 2) = k, phase -pi/2 - w/2."""
    response = np.zeros(N_STEPS)
    response[1] = 1.0
    response[2:] = -gain * (1.0 - gain) ** np.arange(N_STEPS - 2)
    frequency = 2.0 * np.arcsin(0.5 * gain)
    ms, delay = margins_of(response)
    assert ms == pytest.approx(2.0 / (2.0 - gain), rel=1e-6)
    assert delay == pytest.approx((0.5 * np.pi - 0.5 * frequency) / frequency, rel=2e-3)
    assert margins_of(np.full(N_STEPS, np.inf)) == (np.inf, 0.0)
