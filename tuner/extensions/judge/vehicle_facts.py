"""Facts of parameter files against the airframe: contradictions, and airframes narrowed to the vehicles that have these facts.

Logarithms of an airframe's numbers are normal (`plant/quadrotor/airframes/uncertainty.py`). A fact is an observation of one
function of them with an error, so the narrowed vehicles are those of an extended Kalman update, iterated at the new middle
(B. M. Bell, F. W. Cathey, "The iterated Kalman filter update as a Gauss-Newton method", 1993).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import exp, inf, log, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.airframes import Airframe
from plant.quadrotor.airframes.schema import Sourced
from plant.quadrotor.airframes.uncertainty import POSITIVE, Uncertainty
from plant.quadrotor.vehicle import Vehicle
from tuner.analysis.airframe_text import uncertainty_from
from tuner.extensions.autopilots.vehicle_facts import Range, VehicleFact
from tuner.extensions.parts_list.estimate import QUANTILE

Array = NDArray[np.float64]
WARNING_FACTOR, REFUSAL_FACTOR = 1.25, 1.6
STEP = 1e-4
"""Step of the differences by which a fact's slopes are taken, in logarithms of numbers."""
UPDATES = 10
"""Number of Gauss-Newton steps of an update; from the third on they change a hover command by less than 0.1 %."""
LENGTHS = {"arm": ("arm", "lever_fore_aft", "lever_side")}
"""Number of an uncertainty -> the lengths of a file that it is a factor of."""


class Contradiction(NamedTuple):
    """A fact that an airframe contradicts: factor between both, and the airframe's range of the number."""

    fact: VehicleFact
    factor: float
    fitting: Range

    @property
    def refuses(self) -> bool:
        """Whether the airframe is another vehicle's, rather than a little off."""
        return self.factor > REFUSAL_FACTOR and self.fact.is_exact

    def sentence(self, subject: str) -> str:
        """Return the contradiction in words; subject: the airframe."""
        quantity = self.fact.quantity
        texts = dict.fromkeys(f"{end:.3g}" for end in self.fitting if 0.0 < end < inf)
        return (
            f"{self.fact.text} in the file, {subject} {quantity.phrase} {' to '.join(texts)}{quantity.unit}, a factor "
            f"{self.factor:.2g} away"
        )


def contradictions(facts: Sequence[VehicleFact], airframe: Airframe) -> list[Contradiction]:
    """Return the facts that an airframe contradicts, the largest factor first."""
    rows = filter(None, (_contradiction(fact, airframe) for fact in facts))
    return sorted(rows, key=lambda row: -row.factor)


def narrowed(airframe: Airframe, facts: Sequence[VehicleFact]) -> Airframe:
    """Return an airframe narrowed to vehicles that have the facts.

    One without uncertainty stays as it is.
    """
    ranges, used = airframe.uncertainty, [fact for fact in facts if _is_open(fact, airframe)]
    if ranges is None or not used:
        return airframe
    middle, covariance = np.zeros(len(ranges.names)), _covariance(ranges)
    for fact in used:
        middle, covariance = _updated(fact, airframe.vehicle, ranges, middle, covariance)
    return replace(
        airframe,
        title=f"{airframe.title}, narrowed by {' and '.join(fact.text for fact in used)}",
        vehicle=ranges.moved(airframe.vehicle, middle),
        uncertainty=uncertainty_from(ranges.names, covariance),
        sources=_moved_sources(airframe.sources, dict(zip(ranges.names, middle.tolist(), strict=True))),
    )


def spread_of(fact: VehicleFact, airframe: Airframe) -> float:
    """Return the standard deviation of a fact's logarithm among vehicles."""
    ranges = airframe.uncertainty
    if ranges is None:
        return 0.0
    slopes = _slopes(fact, airframe.vehicle, ranges, np.zeros(len(ranges.names)))
    return sqrt(float(slopes @ _covariance(ranges) @ slopes))


def _contradiction(fact: VehicleFact, airframe: Airframe) -> Contradiction | None:
    fitting = fact.fitting(airframe.vehicle)
    if fitting is None:
        return None
    factor = exp(QUANTILE * spread_of(fact, airframe))
    ends = fact.value, fitting[0] / factor, fitting[1] * factor
    value, low, high = (min(max(end, fact.bounds[0]), fact.bounds[1]) for end in ends)
    away = max(low / value, value / high)
    return Contradiction(fact, away, (low, high)) if away > WARNING_FACTOR else None


def _is_open(fact: VehicleFact, airframe: Airframe) -> bool:
    """Return True for a fact that vehicles differ in beyond its tolerance."""
    has_number = fact.is_exact and fact.fitting(airframe.vehicle) is not None
    return has_number and spread_of(fact, airframe) > fact.quantity.tolerance


def _updated(
    fact: VehicleFact, vehicle: Vehicle, ranges: Uncertainty, middle: Array, covariance: Array
) -> tuple[Array, Array]:
    """Return middle and covariance of the vehicles that have a fact too."""
    point, error = middle, fact.quantity.tolerance**2
    for _ in range(UPDATES):
        slopes = _slopes(fact, vehicle, ranges, point)
        gain = covariance @ slopes / (slopes @ covariance @ slopes + error)
        gap = _gap(fact, ranges.moved(vehicle, point))
        point = middle + gain * (gap + slopes @ (point - middle))
    slopes = _slopes(fact, vehicle, ranges, point)
    gain = covariance @ slopes / (slopes @ covariance @ slopes + error)
    return point, covariance - np.outer(gain, slopes @ covariance)


def _gap(fact: VehicleFact, vehicle: Vehicle) -> float:
    """Return the logarithm of a value over the nearest fitting one."""
    fitting = fact.fitting(vehicle)
    assert fitting is not None, "only facts whose number the airframe has narrow it"
    return log(fact.value / min(max(fact.value, fitting[0]), fitting[1]))


def _slopes(fact: VehicleFact, vehicle: Vehicle, ranges: Uncertainty, point: Array) -> Array:
    """Return the derivatives of a fact's logarithm by uncertain numbers."""
    steps = STEP * np.eye(len(point))
    ends = [[_level(fact, ranges.moved(vehicle, point + sign * step)) for sign in (1.0, -1.0)] for step in steps]
    return np.array([(high - low) / (2.0 * STEP) for high, low in ends])


def _level(fact: VehicleFact, vehicle: Vehicle) -> float:
    """Return the logarithm of the middle of a fact's fitting values; of a limit, the logarithm of its end."""
    logarithms = [log(end) for end in fact.fitting(vehicle) or () if 0.0 < end < inf]
    return sum(logarithms) / max(len(logarithms), 1)


def _covariance(ranges: Uncertainty) -> Array:
    return np.array(ranges.correlation) * np.outer(ranges.deviations, ranges.deviations)


def _moved_sources(sources: Mapping[str, Sourced], logarithms: Mapping[str, float]) -> dict[str, Sourced]:
    """Return the numbers of an airframe times their factors."""
    factors = {
        key: exp(step) for name, step in logarithms.items() if name in POSITIVE for key in LENGTHS.get(name, (name,))
    }
    return {key: entry._replace(value=entry.value * factors.get(key, 1.0)) for key, entry in sources.items()}
