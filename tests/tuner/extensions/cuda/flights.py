"""The flights that the tests of the cuda backend make, and how far rounding may carry them from those of another backend.

One plant step rounds each part of the state at its own size a few times, and the loop, which is stable, neither damps nor grows
that much: after n steps a random walk of 4 sqrt(n) units of rounding. Seen in the simulator: 11 of 89 units after 0.5 s, 78 of
400 after 10 s, alike in both precisions. On the card a single-precision root or quotient is off by 2 units instead of a half.
"""

import numpy as np

from tests.plant.loops import TIMING, gains, inputs

PAIRS = (("ladrc", "hybrid"), ("pid", "pid"), ("ladrc", "ladrc"))
CASES = (("float32", PAIRS[0]), *(("float64", pair) for pair in PAIRS))
SCENARIOS, SHORT, LONG = 3, 0.5, 10.0


def rows(position="ladrc", attitude="hybrid", count=2):
    """Gains of a few candidates."""
    many = np.tile(gains(position, attitude), (count, 1))
    many *= 1.0 + 0.02 * np.arange(count)[:, None]
    return many


def batch(duration=SHORT, count=SCENARIOS):
    return inputs(range(count), duration=duration)


def tolerance(precision, duration, approximate=False):
    units = (16.0 if approximate else 4.0) * np.sqrt(duration / TIMING.plant_step)
    return float(units * np.finfo(precision).eps)


def assert_alike(actual, wanted, precision, duration, approximate=False):
    limit = tolerance(precision, duration, approximate)
    np.testing.assert_allclose(actual, wanted, rtol=limit, atol=limit)
