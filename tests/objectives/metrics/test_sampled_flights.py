"""Sampled flights for checks of metrics: the first one has meters in closed form, and no metric changes them for another."""

from typing import Any

import numpy as np
import pytest

from objectives.metrics.address import UNITS
from objectives.metrics.contract import LIMITS, _targets
from objectives.metrics.metric import AxisView
from objectives.metrics.sampled_flights import Plan, sampled_views
from plant.own_code import run_own_code
from plant.quadrotor.cascade import AXES
from tests.plant.own_files import SWAY

PLAN = Plan(4, 0.2, 0.004, _targets(), LIMITS)


def views() -> dict[str, Any]:
    found = list(sampled_views(run_own_code(SWAY).names["METRIC"], PLAN))
    assert all(isinstance(view, AxisView) for view in found)
    return dict(zip(AXES, found, strict=True))


def test_a_flight_from_limit_to_limit_has_its_limit_for_error_at_every_instant():
    for axis, view in views().items():
        limit = LIMITS.position_error if UNITS[axis] == "m" else LIMITS.angle
        assert view.meter.iae[0] == pytest.approx(limit * PLAN.duration, rel=1e-12)
        assert view.meter.ise[0] == pytest.approx(limit**2 * PLAN.duration, rel=1e-12)
        # The others are random, within the limits.
        assert (view.meter.peak <= limit).all() and np.ptp(view.meter.iae[1:]) > 0.0
        # It moves by twice the limit each period, from the second instant on.
        assert view.accumulated.way[0] == pytest.approx(2.0 * limit * (PLAN.duration / PLAN.period - 1.0), rel=1e-12)


def test_a_metric_that_writes_to_its_view_changes_no_other():
    before = views()["roll"].meter.iae.copy()
    views()["roll"].meter.iae[:] = 0.0
    np.testing.assert_array_equal(views()["roll"].meter.iae, before)
