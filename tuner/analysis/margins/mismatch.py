"""Errors about the vehicle that a controller bears: mass, inertia, thrust and rotor lag, until a margin or stability is lost.

The controller's nominal stays, the vehicle that flies has factors of the nominal numbers. Mass and thrust are what b0 of the
position loops is made of, inertia and thrust that of the attitude loops.
"""

from dataclasses import dataclass

import numpy as np

from objectives.margins.quantities import QUANTITIES
from objectives.margins.results import Margins
from plant.quadrotor.nominal import vary
from plant.quadrotor.vehicle import Vehicle
from tuner.analysis.margins.limits import LIMITS, LoopLimit
from tuner.analysis.margins.linear import Linear
from tuner.documents.margins import MismatchRow

Array = np.ndarray

FACTORS = ("mass", "inertia", "thrust", "lag")
CRITERIA = ("stability", "limits")
# Factors from 1/REACH to REACH are tried, at so many points for each side of 1, and an end is halved so many times.
REACH, STEPS, HALVINGS = 4.0, 12, 10
# Points along each axis of a map, besides the ends of its factors.
POINTS = 15
# Slack of a vehicle of which no steady flight is found.
NOWHERE = np.nan


@dataclass(frozen=True)
class RobustnessMap:
    """A grid of vehicles: two factors with their values (a,) and (b,), and for each vehicle (b, a) the slack of stability and of
    the limits, above 0 where kept; NaN where no steady flight is found.
    """

    across: str
    up: str
    x: Array
    y: Array
    stability: Array
    limits: Array


@dataclass(frozen=True)
class ToleranceRange:
    """Range of one factor around 1 in which a criterion is satisfied.

    In it the vehicle can fly.

    Attributes:
        factor: Name of the factor.
        criterion: "stability" or "limits".
        low, high: Last factors that satisfy it, None where all that were tried do, both 1 where the nominal vehicle breaks it.
    """

    factor: str
    criterion: str
    low: float | None
    high: float | None

    def row(self) -> MismatchRow:
        """Return it as a row of margins.json."""
        note = None if None not in (self.low, self.high) else f"null: kept as far as was tried, a factor of {REACH:g}"
        return MismatchRow(**vars(self), note=note)


def with_factors(vehicle: Vehicle, **factors: float) -> Vehicle:
    """Return the vehicle with some of its numbers multiplied."""
    return vary(vehicle, *[factors.get(name, 1.0) for name in FACTORS])


def margin_surplus(
    margins: Margins | None, criterion: str, control_period: float, limits: tuple[LoopLimit, ...] = LIMITS
) -> float:
    """Return the surplus of a criterion in the worst loop.

    Above 0 where it is satisfied. "limits": as a share of the limit; "stability": a measure of the decay rate.
    control_period [s].
    """
    if margins is None:
        return NOWHERE
    if criterion == "stability":
        # Growth ranges over decades on either side of 0, and contours are interpolated.
        return float(-np.arcsinh(margins.growth.max() * 2.0))
    return min(_surplus(margins, limit, control_period) for limit in limits)


def _surplus(margins: Margins, limit: LoopLimit, control_period: float) -> float:
    quantity = QUANTITIES[limit.quantity]
    values = getattr(margins, quantity.field).value
    worst = np.max(values) if limit.sense == "max" else np.min(values)
    # Of the quantities that are limited here one alone counts in control periods.
    reached = float(worst / control_period if quantity.name == "delay_periods" else quantity.to_limit(worst))
    return limit.limit / reached - 1.0 if limit.sense == "max" else min(reached / limit.limit - 1.0, 1.0)


def mismatch_map(
    linear: Linear, across: str, up: str, ends: list[ToleranceRange], points: int | None = None
) -> RobustnessMap:
    """Return the map over two factors; their own ends are points of the grid too, so that its borders start from there."""
    x, y = (_axis(factor, ends, points or POINTS) for factor in (across, up))
    base = linear.nominal.vehicle
    judged = linear.judge([with_factors(base, **{across: a, up: b}) for b in y for a in x])
    grids = [
        np.array([margin_surplus(j, name, linear.control_period) for j in judged]).reshape(len(y), len(x))
        for name in CRITERIA
    ]
    return RobustnessMap(across, up, x, y, *grids)


def _axis(factor: str, ends: list[ToleranceRange], points: int) -> Array:
    limits = [end for each in ends if each.factor == factor for end in (each.low, each.high) if end is not None]
    return np.unique(np.concatenate([np.geomspace(1.0 / REACH, REACH, points), limits]))


def tolerance_ranges(linear: Linear) -> list[ToleranceRange]:
    """Return the tolerance range of each factor by itself, for each criterion."""
    ranges = []
    for factor in FACTORS:
        ends = [_ends(linear, factor, way) for way in (-1.0, 1.0)]
        ranges += [ToleranceRange(factor, name, *[end[name] for end in ends]) for name in CRITERIA]
    return ranges


def _ends(linear: Linear, factor: str, way: float) -> dict[str, float | None]:
    """Return by criterion the last factor in one direction that satisfies it.

    It steps outwards from 1 until the criterion is lost, then halves the last step, in the logarithm of the factor.
    """
    exponents = way * np.log(REACH) * np.arange(STEPS + 1) / STEPS
    is_inside = _satisfied_limits(linear, factor, np.exp(exponents))
    last: dict[str, float | None] = {}
    for name in CRITERIA:
        lost = next((i for i, good in enumerate(is_inside[name]) if not good), None)
        if lost is None or lost == 0:
            last[name] = None if lost is None else 1.0
            continue
        inside, outside = exponents[lost - 1], exponents[lost]
        for _ in range(HALVINGS):
            middle = 0.5 * (inside + outside)
            good = _satisfied_limits(linear, factor, np.exp([middle]))[name][0]
            inside, outside = (middle, outside) if good else (inside, middle)
        last[name] = float(np.exp(inside))
    return last


def _satisfied_limits(linear: Linear, factor: str, values: Array) -> dict[str, list[bool]]:
    base = linear.nominal.vehicle
    judged = linear.judge([with_factors(base, **{factor: float(value)}) for value in values])
    return {name: [margin_surplus(each, name, linear.control_period) >= 0.0 for each in judged] for name in CRITERIA}
