"""Failure modes of flights: utilisation of each mode, demand over capacity; 1 at failure.

The meters of a failed flight are those of the last instant before the failure. So the demand of the mode with the status of the
failure is 1, and more the earlier it failed; if several modes have that status, this is the one with the largest demand.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from math import sqrt
from typing import Any

import numpy as np

from objectives.metrics.address import MetricAddress
from plant.loop import LARGEST_STATE
from plant.status import Status

Array = np.ndarray
LARGEST = float(np.nextafter(1.0, 0.0))
"""Largest demand of a flight that is not lost."""


@dataclass(frozen=True)
class FailureMode:
    """One way to be lost.

    Attributes:
        name: Name of the quantity that exceeds its limit, such as "position".
        status: Status of flights that end this way.
        demand: Largest demand over capacity (...) of flights with the meters of a record.
        metric: Metric whose accumulator `demand` reads, None if it reads those of every flight.

    """

    name: str
    status: Status
    demand: Callable[[Any], Array]
    metric: MetricAddress | None = None


def failure_demands(modes: Sequence[FailureMode], meters: Any, status: Array, left: Array) -> Array:
    """Return demand over capacity (flights, modes); left: share of the flight's time (flights,) that was left at its end."""
    with np.errstate(all="ignore"):  # the meters of a failed flight may hold anything
        shape = np.shape(status)
        demands = np.stack([np.broadcast_to(mode.demand(meters), shape) for mode in modes], axis=-1)
    demands = np.minimum(np.nan_to_num(demands, nan=0.0), LARGEST)
    for code in np.unique(status[status != Status.COMPLETED.code]).tolist():
        places = np.flatnonzero([mode.status.code == code for mode in modes])
        flights = np.flatnonzero(status == code)
        first = places[np.argmax(demands[flights][:, places], axis=1)]
        demands[flights, first] = 1.0 + left[flights]
    return demands


def largest_error(axes: Iterable[str], limit: float, meters: Any) -> Array:
    """Return the largest error of some axes over a limit."""
    return np.max([getattr(meters, axis).peak for axis in axes], axis=0) / limit


def diverged(axes: Iterable[str]) -> FailureMode:
    """Return the mode of states that are no numbers or absurdly large.

    Errors of axes are the part of the state in the meters.
    """
    return FailureMode("diverged", Status.NON_FINITE, partial(largest_error, tuple(axes), sqrt(LARGEST_STATE)))
