"""Rows of the tables of gains of autopilots; gains that several rate loops have are described once."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from plant.laws.law import GainInfo, Span


def _shared(name: str, unit: str, scale: str, meaning: str, **fields: Any) -> GainInfo:
    return GainInfo(name, "", unit, Span(0.0, 0.0, 0.0), Span(0.0, 0.0, 0.0), scale, "", meaning, **fields)


# Gains in units of the output, which the gain `authority` turns into acceleration.
OF_OUTPUT = ("p", "i", "d", "ff")
AUTHORITY = "angular acceleration that a unit of normalised torque gives"
SHARED = {
    info.name: info
    for info in (
        _shared("angle_p", "s^-1", "log", "rate asked for per angle error"),
        _shared("p", "s/{y}", "log", "normalised torque per rate error"),
        _shared("i", "1/{y}", "log", "normalised torque per integrated rate error", term="integral term"),
        _shared(
            "d", "s^2/{y}", "linear", "normalised torque per measured angular acceleration", term="derivative term"
        ),
        _shared("ff", "s/{y}", "linear", "normalised torque per rate asked for", term="feed-forward"),
        _shared("i_limit", "1", "log", "limit of the integral, normalised torque"),
        _shared(
            "gyro_cutoff", "Hz", "linear", "cut-off of the second-order low-pass on the gyro, 0 for none", cutoff=True
        ),
        _shared("authority", "{y} s^-2", "log", AUTHORITY, exclusive=True, airframe=True),
    )
}


def gain_rows(source: str) -> Callable[..., GainInfo]:
    """Return the function that makes the rows of one source's table of gains.

    Its span in position loops is by default that in attitude loops, and all else as shared under its name.
    """

    def row(name: str, symbol: str, attitude: Span, position: Span | None = None, **fields: Any) -> GainInfo:
        shared = SHARED.get(name) or _shared(name, "1", "linear", "")
        return replace(shared, symbol=symbol, attitude=attitude, position=position or attitude, source=source, **fields)

    return row
