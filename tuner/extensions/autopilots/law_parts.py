"""Parts of the autopilots' laws: rows of their tables of gains, and bounds of the integrals of their rate loops."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from plant.laws.law import GainInfo, Span
from plant.primitives import both, clip, maximum, minimum, select


def _shared(name: str, unit: str, scale: str, meaning: str, **fields: Any) -> GainInfo:
    return GainInfo(name, "", unit, Span(0.0, 0.0, 0.0), Span(0.0, 0.0, 0.0), scale, "", meaning, **fields)


# Accelerations that limits take away count from this share of what a unit of output gives: below it they are rounding.
MIN_LOSS = 1e-6
AUTHORITY = "angular acceleration that a unit of normalised torque gives"
SHARED = {
    info.name: info
    for info in (
        _shared("angle_p", "s^-1", "log", "rate asked for per angle error"),
        _shared("p", "s/{y}", "log", "normalised torque per rate error", of_output=True),
        _shared(
            "i", "1/{y}", "log", "normalised torque per integrated rate error", term="integral term", of_output=True
        ),
        _shared(
            "d",
            "s^2/{y}",
            "linear",
            "normalised torque per measured angular acceleration",
            term="derivative term",
            of_output=True,
        ),
        _shared("ff", "s/{y}", "linear", "normalised torque per rate asked for", term="feed-forward", of_output=True),
        _shared("i_limit", "1", "log", "limit of the integral, normalised torque"),
        _shared(
            "gyro_cutoff", "Hz", "linear", "cut-off of the second-order low-pass on the gyro, 0 for none", cutoff=True
        ),
        _shared("authority", "{y} s^-2", "log", AUTHORITY, exclusive=True, airframe=True),
    )
}


def gain_rows(source: str) -> Callable[..., GainInfo]:
    """Return the function that makes rows of a table of gains.

    Its span in position loops is by default that in attitude loops, and all else as shared under its name.
    """

    def row(name: str, symbol: str, attitude: Span, position: Span | None = None, **fields: Any) -> GainInfo:
        shared = SHARED.get(name) or _shared(name, "1", "linear", "")
        return replace(shared, symbol=symbol, attitude=attitude, position=position or attitude, source=source, **fields)

    return row


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
    """Return the error unless the integral would grow at a limit."""
    least = MIN_LOSS * authority
    free = both(lost > -least, lost < least)
    return select(free, error, select(error * integral < 0.0, error, 0.0))
