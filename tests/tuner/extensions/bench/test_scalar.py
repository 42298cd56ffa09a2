"""The yardstick of `tuner bench`, whose kernel nothing else compiles."""

import numpy as np
import pytest

from tests.plant.loops import LIMITS, NOMINAL, TIMING, flyer, gains, inputs, loop
from tuner.extensions.bench.scalar import scalar_kernel


@pytest.mark.slow
def test_scalar_kernel_flies_the_same_flights():
    batch = inputs(range(3))
    one_by_one = scalar_kernel(loop()).fly(gains()[None], NOMINAL, batch, LIMITS, TIMING, 2)
    np.testing.assert_allclose(one_by_one, flyer().fly(gains()[None], NOMINAL, batch), rtol=1e-9, atol=1e-9)
