"""Plans that tell nothing: refused where a number was named or none is told, said with the widths where some are."""

from typing import Any

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from tuner.analysis.flight_plan.choosing import AccuracyTarget
from tuner.analysis.flight_plan.document import verdict
from tuner.analysis.flight_plan.planning import ExperimentSpec, check_is_informative
from tuner.analysis.identification.parameters import space_of
from tuner.documents.flight_plan import PlannedNumber

SPACE = space_of(load("racer5").vehicle, ["1"])
PLACES = np.array([SPACE.names.index(name) for name in ("inertia.x", "lag_up", "torque_ratio")])
WISH = AccuracyTarget(PLACES, np.full(3, 0.07))


def request(*numbers: str) -> ExperimentSpec:
    return ExperimentSpec(numbers, 0.15, 0.35, 3.5, 0.02, 0.02)


class Foreseen:
    """Accuracy that a flight is to give: standard deviations over those before it."""

    def __init__(self, *shares: float) -> None:
        self.deviations = SPACE.prior_std.copy()
        self.deviations[PLACES] *= shares


def check(asked: ExperimentSpec, *shares: float) -> None:
    expected_fit: Any = Foreseen(*shares)
    check_is_informative(asked, SPACE, WISH, expected_fit)


def row(name: str, expected_fit: float, *, before: float, asked: float | None = 0.15) -> PlannedNumber:
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
        reason="",
    )


def test_a_plan_that_tells_of_nothing_is_refused_with_the_names() -> None:
    with pytest.raises(InputError, match=r"--within: no flight .* tells of inertia.x, lag_up, torque_ratio"):
        check(request(), 1.4, 0.97, 2.0)
    check(request(), 1.4, 0.5, 2.0)


def test_a_number_that_is_named_and_not_told_is_refused() -> None:
    with pytest.raises(InputError, match="--numbers: no flight within these limits tells of lag_up: "):
        check(request("lag_up", "inertia.x"), 0.3, 1.2, 0.5)
    check(request("lag_up", "inertia.x"), 0.3, 0.5, 0.5)


def test_widths_are_said_by_how_far_they_miss() -> None:
    """The widths of a racer at 15 %: 91 % of a lag and 290 % of an inertia were called a little wider than asked."""
    words = verdict(
        [
            row("inertia.y", 0.14, before=0.8),
            row("thrust.65", 0.17, before=0.4),
            row("lag_up", 0.91, before=1.8),
            row("inertia.x", 2.9, before=0.8),
        ]
    )
    assert "tell one number as narrowly as asked" in words
    assert "A little wider than asked: thrust.65." in words
    assert "Wider than asked: lag_up (91 % foreseen, 15 % asked)." in words
    assert "tells nothing of inertia.x" in words and "as wide as before" in words
