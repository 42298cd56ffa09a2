"""Parameters that a flight identifies: those whose interval shrinks to half of their prior's, as identification counts them."""

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError
from tuner.extensions.flight_plans.choosing import AccuracyTarget
from tuner.extensions.vehicle_fit.identifiability import NARROWED
from tuner.extensions.vehicle_fit.parameters import Parameter, ParameterSpace
from tuner.text.numbers import per_cent, significant
from tuner.text.sentences import listing

Array = NDArray[np.float64]

QUANTILE = 1.96
"""Quantile of a 95 % interval, in standard deviations."""


def is_identified(space: ParameterSpace, deviations: Array) -> NDArray[np.bool_]:
    """Return a mask (n,) of the coordinates that a flight identifies.

    deviations (n,): standard deviations after the flight.
    """
    return deviations <= NARROWED * space.initial_std


def check_is_informative(is_named: bool, space: ParameterSpace, accuracy: AccuracyTarget, deviations: Array) -> None:
    """Raise InputError for a flight uninformative of a named number, or all.

    Args:
        is_named: True where the numbers are named.
        space: Coordinates with their prior.
        accuracy: Numbers that are to be identified.
        deviations: Standard deviations (n,) after the flight.
    """
    identified = is_identified(space, deviations)
    untold = [int(k) for k in accuracy.places if not identified[k]]
    if not untold or (len(untold) < len(accuracy.places) and not is_named):
        return
    after, before = (half_widths(space, entry) for entry in (deviations, space.prior_std))
    widths = [f"{space.names[k]} ({width_text(space.parameters[k], after[k], before[k])})" for k in untold]
    raise InputError(
        f"no flight within these limits identifies {listing(widths)}: an identified number has an interval of half its prior's; "
        "allow more (--tilt, --rate), give gains that follow faster (--gains), measure them on a test stand"
        f"{', or ask for others' if is_named else ''}",
        key="--numbers" if is_named else "--within",
    )


def width_text(parameter: Parameter, after: float, before: float) -> str:
    """Return the half-widths of an interval after and before a flight."""
    if parameter.positive:
        return f"{per_cent(after)} after it, {per_cent(before)} before"
    return f"{significant(after, 2)} {parameter.unit} after it, {significant(before, 2)} before"


def half_widths(space: ParameterSpace, deviations: Array) -> Array:
    """Return the half-widths of 95 % intervals (n,): relative for positive parameters, else in their units."""
    positive = np.array([entry.positive for entry in space.parameters])
    return np.where(positive, np.expm1(QUANTILE * deviations), QUANTILE * deviations)
