"""Exact operation counts of the model: its functions rebound to numbers that count what is done to them.

Every operation is counted as the model writes it, once each: what a compiler then fuses, shares or drops (constants,
position stages that nobody reads) is its merit. Arc tangents are those of the lanes, so they count as their multiplications.
"""

from collections import Counter
from typing import Any

from benchmarks.course import LIMITS, TIMING, Course, loop
from plant.backends import vector_math
from plant.backends.rebind import Rebinder
from plant.quadrotor.closed_loop import hover_body, place
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.rigid_body import Dynamics
from plant.quadrotor.sensors import Noise
from plant.records import flatten, pack, size
from plant.references.track import Reference

ARITHMETIC = ("add", "multiply", "divide", "sqrt")
"""What counts as a floating-point operation; comparisons, choices, signs and roundings do not."""


class Counted:
    """A number that adds one to a counter for each operation on it."""

    __slots__ = ("counts", "value")

    def __init__(self, value: float, counts: Counter[str]) -> None:
        self.value, self.counts = value, counts

    def _new(self, what: str, value: float) -> "Counted":
        self.counts[what] += 1
        return Counted(value, self.counts)

    def __add__(self, other: Any) -> "Counted":
        return self._new("add", self.value + plain(other))

    def __sub__(self, other: Any) -> "Counted":
        return self._new("add", self.value - plain(other))

    def __rsub__(self, other: Any) -> "Counted":
        return self._new("add", plain(other) - self.value)

    def __mul__(self, other: Any) -> "Counted":
        return self._new("multiply", self.value * plain(other))

    def __truediv__(self, other: Any) -> "Counted":
        return self._new("divide", self.value / plain(other))

    def __rtruediv__(self, other: Any) -> "Counted":
        return self._new("divide", plain(other) / self.value)

    def __neg__(self) -> "Counted":
        return self._new("sign", -self.value)

    def __lt__(self, other: Any) -> bool:
        return self._compared(self.value < plain(other))

    def __le__(self, other: Any) -> bool:
        return self._compared(self.value <= plain(other))

    def __gt__(self, other: Any) -> bool:
        return self._compared(self.value > plain(other))

    def __ge__(self, other: Any) -> bool:
        return self._compared(self.value >= plain(other))

    def _compared(self, holds: bool) -> bool:
        self.counts["compare"] += 1
        return holds

    __radd__, __rmul__ = __add__, __mul__


def plain(value: Any) -> float:
    """Return the number behind a value."""
    return value.value if isinstance(value, Counted) else value


def names(counts: Counter[str]) -> dict[str, Any]:
    """Return what each mathematical name means to counted numbers."""
    from math import cos, exp, floor, sin, sqrt

    from plant import primitives

    def counted(what: str, function: Any) -> Any:
        def call(*arguments: Any) -> Counted:
            counts[what] += 1
            return Counted(function(*map(plain, arguments)), counts)

        return call

    def select(condition: bool, if_true: Any, if_false: Any) -> Counted:
        counts["select"] += 1
        return Counted(plain(if_true if condition else if_false), counts)

    def clip(a: Any, low: Any, high: Any) -> Counted:
        counts["minimum or maximum"] += 2
        return Counted(primitives.clip(plain(a), plain(low), plain(high)), counts)

    either = {"minimum": primitives.minimum, "maximum": primitives.maximum}
    table = {name: counted("minimum or maximum", function) for name, function in either.items()}
    table |= {
        "absolute": counted("sign", abs),
        "sign": counted("sign", primitives.sign),
        "floor": counted("round", floor),
    }
    table |= {
        "sqrt": counted("sqrt", sqrt),
        "exp": counted("exp", exp),
        "sin": counted("sin", sin),
        "cos": counted("cos", cos),
    }
    table |= {"select": select, "clip": clip, "both": primitives.both, "either": primitives.either}
    inner = Rebinder(table)
    return table | {"atan2": inner(vector_math.atan2), "asin": inner(vector_math.asin)}


def lifted(record: Any, counts: Counter[str]) -> Any:
    """Return a record with counted leaves."""
    return pack(type(record), [Counted(plain(leaf), counts) for leaf in flatten(record)])


def count(course: Course) -> dict[str, dict[str, int]]:
    """Return the operations of one "plant step" and of one "control step" with its meters, by kind."""
    counts: Counter[str] = Counter()
    model, bind, (h, plant_step) = loop(), Rebinder(names(counts)), TIMING
    nominal, targets = course.nominal_record(), course.targets_record()
    constants = lifted(model.cascade.prepare(pack(model.cascade.Gains, course.gains.tolist()), h), counts)
    frame = lifted(pack(Dynamics, course.dynamics[:, 0].tolist()), counts)
    noise = lifted(pack(Noise, course.noises[0, :, 0].tolist()), counts)
    goal = pack(Reference, course.references[-1].tolist())
    air = [*course.winds[0, :, 0].tolist(), *[0.0] * (size(Disturbance) - course.winds.shape[1])]
    body = lifted(place(hover_body(nominal), goal), counts)
    # What all lanes share is worked out once a block and period, not in the lanes: it is not counted.
    flight = bind(model.start)(body, constants, nominal, goal, noise, targets)
    counts.clear()
    flight = bind(model.decide)(lifted(flight, counts), constants, nominal, goal, noise, targets, LIMITS, 0.0, h)
    control = dict(counts)
    counts.clear()
    bind(model.advance)(body, flight.speed, lifted(pack(Disturbance, air), counts), frame, plant_step)
    return {"control step": control, "plant step": dict(counts)}


def operations(kinds: dict[str, int]) -> int:
    """Return the number of floating-point operations among counted ones."""
    return sum(kinds.get(kind, 0) for kind in ARITHMETIC)
