"""Plans that tell nothing: refused where a number was named or none is told, said with the widths where some are."""

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from tuner.extensions.flight_plans.building import verdict
from tuner.extensions.flight_plans.choosing import AccuracyTarget
from tuner.extensions.flight_plans.document import PlannedNumber
from tuner.extensions.flight_plans.informativeness import check_is_informative
from tuner.extensions.vehicle_fit.parameters import space_of

SPACE = space_of(load("racer5").vehicle, ["1"])
PLACES = np.array([SPACE.names.index(name) for name in ("inertia.x", "lag_up", "torque_ratio")])
WISH = AccuracyTarget(PLACES, np.full(3, 0.07))


def check(*shares: float, is_named: bool = False) -> None:
    """Check a flight after which standard deviations are these shares of those before it."""
    deviations = SPACE.prior_std.copy()
    deviations[PLACES] *= shares
    check_is_informative(is_named, SPACE, WISH, deviations)


def row(
    name: str, expected_fit: float, *, before: float, asked: float | None = 0.15, reason: str = ""
) -> PlannedNumber:
    return PlannedNumber(
        name=name,
        meaning="",
        unit="1",
        value=1.0,
        relative=True,
        asked=asked,
        before=before,
        foreseen=expected_fit,
        obtained=expected_fit,
        error=0.0,
        reason=reason,
    )


def test_a_plan_that_tells_of_nothing_is_refused_with_names_and_widths() -> None:
    """An interval that shrinks to 60 % of its prior's stays at its prior when the vehicle is identified."""
    with pytest.raises(
        InputError, match=r"--within: no flight .* identifies inertia.x \(290 % after it, 166 % before\), lag_up .*half"
    ):
        check(1.39, 0.97, 0.6)
    check(1.4, 0.5, 2.0)


def test_a_number_that_is_named_and_not_told_is_refused() -> None:
    with pytest.raises(
        InputError, match="--numbers: no flight within these limits identifies lag_up .*or ask for others"
    ):
        check(0.3, 0.6, 0.5, is_named=True)
    check(0.3, 0.5, 0.5, is_named=True)


def test_widths_are_said_by_how_far_they_miss() -> None:
    """The widths of a racer at 15 %: 91 % of a lag and 290 % of an inertia were called a little wider than asked."""
    words = verdict(
        [
            row("inertia.y", 0.14, before=0.8),
            row("thrust.65", 0.17, before=0.4),
            row("lag_up", 0.91, before=1.8),
            row("inertia.x", 2.9, before=0.8, reason="its interval is 230 % of the prior's"),
        ]
    )
    assert "tell one number as narrowly as asked" in words
    assert "A little wider than asked: thrust.65." in words
    assert "Wider than asked: lag_up (91 % foreseen, 15 % asked)." in words
    assert "does not tell inertia.x: its interval would not shrink to half" in words
