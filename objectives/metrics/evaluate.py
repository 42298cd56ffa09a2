"""From the final meters of flights to the values of metrics.

A completed flight has the metric's value. A failed flight has a cost instead: with B the bound that no completed
flight exceeds and t_f the time it failed, B (2 - t_f/(T + h)). It is finite, above B for every t_f in [0, T] (that is
what the h is for), at most 2 B, and smaller the longer the flight lasted. So a search is led from early failures to
later ones to completed flights, by every metric alike. A metric that is not graded (failure) costs B.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.meters import Meters
from objectives.metrics.address import MetricAddress
from objectives.metrics.columns import unpack
from objectives.metrics.context import COMPLETED, FlightContext
from objectives.metrics.metric import COMBINE, AxisView, FlightView


class Scores(NamedTuple):
    """Values of metrics, and True where the flight's end censored a time.

    values (metrics, ...): never NaN or infinite. censored (metrics, ...): true where the awaited event (rise,
    settling, recovery) did not happen in the flight, failed flights included; false for metrics that are no times.
    """

    values: NDArray[np.float64]
    censored: NDArray[np.bool_]


def evaluate(
    addresses: Sequence[MetricAddress], meters: NDArray[np.float64], context: FlightContext, kind: Any = Meters
) -> Scores:
    """Return the scores (metrics, ...) of flights with final meters (..., n).

    The meters are rows of a record.
    The meters of failed flights are not looked at, they may hold anything.
    """
    shape = meters.shape[:-1]
    values = np.empty((len(addresses), *shape))
    censored = np.zeros((len(addresses), *shape), dtype=bool)
    rows = unpack(kind, meters)
    completed = np.broadcast_to(context.status == COMPLETED, shape)
    with np.errstate(all="ignore"):  # the meters of a failed flight may hold anything
        for index, address in enumerate(addresses):
            views = _views(address, rows, context)
            values[index] = _values(address, views, completed, context)
            if address.metric.censored is not None:
                cut = [address.metric.censored(view) for view in views]
                censored[index] = ~completed | np.any(np.broadcast_arrays(*cut), axis=0)
    return Scores(values, censored)


def _views(address: MetricAddress, rows: Any, context: FlightContext) -> list[AxisView] | list[FlightView]:
    if not address.axes:
        return [FlightView(rows, context, _accumulated(address, rows))]
    return [
        AxisView(
            getattr(rows, axis),
            getattr(context.targets, axis),
            context.limits.error(axis),
            context,
            _accumulated(address, rows, axis),
        )
        for axis in address.axes
    ]


def _accumulated(address: MetricAddress, rows: Any, axis: str = "") -> Any:
    return None if address.metric.accumulator is None else getattr(rows, address.metric.meter_name(axis))


def _values(
    address: MetricAddress,
    views: list[AxisView] | list[FlightView],
    completed: NDArray[np.bool_],
    context: FlightContext,
) -> NDArray[np.float64]:
    """Return value or cost (...).

    A value is held to its bound: not even rounding may put it above a cost. A value that is not finite has no place in
    a completed flight; it costs what a failure at that moment costs, so that no NaN reaches a search.
    """
    value = _combined(address, address.metric.value, views)
    bound = _combined(address, address.metric.bound, views)
    cost = bound * _grade(context) if address.metric.graded else bound
    return np.where(completed & np.isfinite(value), np.minimum(value, bound), cost)


def _combined(address: MetricAddress, formula: Callable[[Any], Any], views: Sequence[Any]) -> NDArray[np.float64]:
    return COMBINE[address.metric.combine](np.stack(np.broadcast_arrays(*(formula(view) for view in views)), axis=0))


def _grade(context: FlightContext) -> NDArray[np.float64]:
    lasted = np.clip(context.end_time, 0.0, context.duration)
    return 2.0 - lasted / (context.duration + context.h)
