"""Bounds of the integral of an autopilot's rate loop: a limit, and the stop where the mixer saturates."""

from typing import Any

from plant.primitives import both, clip, maximum, minimum, select

# Accelerations that limits take away count from this share of what a unit of output gives: below it they are rounding.
MIN_LOSS = 1e-6


def bounded(integral: float, limit: float) -> float:
    """An integral within +-limit; at rest it is the integral itself."""
    return clip(integral, -limit, limit)


def limited(integral: float, constants: Any) -> float:
    """The integral of a loop within the limit of its constants, i_limit."""
    return bounded(integral, constants.i_limit)


def outward_stopped(error: float, lost: float, authority: float) -> float:
    """The error without what would drive a saturated output further; lost: acceleration after limits minus the one asked for."""
    least = MIN_LOSS * authority
    return select(lost < -least, minimum(error, 0.0), select(lost > least, maximum(error, 0.0), error))


def shrinking_only(error: float, integral: float, lost: float, authority: float) -> float:
    """The error where nothing is lost or where it brings the integral towards 0, else 0."""
    least = MIN_LOSS * authority
    free = both(lost > -least, lost < least)
    return select(free, error, select(error * integral < 0.0, error, 0.0))
