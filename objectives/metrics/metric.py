"""The type of a metric: a number per flight, in a known unit, that is better when smaller."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.meters import AxisMeter, Meters
from objectives.metrics.context import FlightContext
from plant.origin import Origin
from plant.sample import Target

Scope = Literal["axis", "flight"]
Combine = Literal["sum", "max", "rss"]
Window = Literal["time", "recovery_from", "steady_from"]

COMBINE: Mapping[str, Callable[[NDArray[Any]], NDArray[Any]]] = {
    "sum": lambda values: np.sum(values, axis=0),
    "max": lambda values: np.max(values, axis=0),
    "rss": lambda values: np.sqrt(np.sum(np.square(values), axis=0)),
}
"""Rules by which the values (axes, ...) of a group of axes with one unit become one value (...). Each rule is increasing in each
axis and scales with its argument, so the combined bounds bound the combined values."""


class Accumulator(NamedTuple):
    """A metric's sum over a flight that no accumulator of `objectives.meters` holds.

    Record: NamedTuple of numbers. start and update are model functions: of a metric of an axis start(sample, target) -> Record
    and update(kept, sample, target, t, h) -> Record, with the `AxisSample` and the `Target` of that axis, the time t and the
    control period h [s]; of a metric of the whole flight start(sample, targets) and update(kept, sample, targets, h).
    each_input: a metric of the whole flight has one record for every input of the loop, and start(command) and
    update(kept, command, h) see its command, of a rotor in hover thrusts, of another input in its scale.
    counts_above: frequency [Hz] of the slowest that it counts, 0 for all.
    """

    Record: Any
    start: Callable[..., Any]
    update: Callable[..., Any]
    each_input: bool = False
    counts_above: float = 0.0


class AxisView(NamedTuple):
    """Input of a metric of one axis: arrays (...) in meter, levels in target, limit of |e| in the axis's unit.

    kept: arrays (...) in the metric's own accumulator, None where it has none.
    """

    meter: AxisMeter
    target: Target
    limit: float
    context: FlightContext
    accumulated: Any = None


class FlightView(NamedTuple):
    """Input of a metric of the whole flight; kept as in `AxisView`, a tuple of them where there is one for each input."""

    meters: Meters
    context: FlightContext
    accumulated: Any = None


@dataclass(frozen=True)
class Metric:
    """One way to judge a flight. Smaller is better, for every metric.

    Attributes:
        name, symbol: texts in addresses and in reports.
        title: plain words for tables and charts, those of an axis behind its name, "position error (ITAE)"; "" for the name.
        unit: SI, "{}" meaning the unit of the axis, "1" for none.
        scope: "axis" metrics are addressed per axis or group, "flight" metrics are not.
        definition: one sentence for reports.
        value(view): the metric of a completed flight, from an `AxisView` or a `FlightView` according to scope.
        bound(view): what no completed flight exceeds, above 0.
        combine: rule for groups of axes (see `COMBINE`).
        window: the field of the target from which on the metric looks at the flight, if not from its start.
        needs_step: meaningless on an axis that makes no step.
        censored(view): where the flight ended before the awaited event, for metrics that are times.
        graded: a failed flight costs the more, the earlier it failed; otherwise it costs the bound.
        highest: the largest value that there is, 1 for a share.
        reaches_zero: whether a flight can have 0; the others come near it at best.
        is_binary: every flight has 0 or 1, lost ones included, so risks are functions of a share and get exact
            intervals.
        accumulator: what it adds up itself.
        origin: the file or package that it comes from, None where it is bundled.
    """

    name: str
    symbol: str
    unit: str
    scope: Scope
    definition: str
    value: Callable[[Any], Any]
    bound: Callable[[Any], Any]
    combine: Combine = "sum"
    window: Window | None = None
    needs_step: bool = False
    censored: Callable[[Any], Any] | None = None
    graded: bool = True
    highest: float = inf
    reaches_zero: bool = False
    is_binary: bool = False
    accumulator: Accumulator | None = None
    title: str = ""
    origin: Origin | None = field(default=None, compare=False)

    def meter_name(self, axis: str = "") -> str:
        """Return its accumulator's name in the meters, for an axis or flight."""
        return f"own_{self.name}_{axis}" if axis else f"own_{self.name}"
