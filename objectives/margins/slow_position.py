"""Control periods of a cascade whose position loops step every few: the one in which they do, and those in which they wait."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from objectives.margins.linearise import OperatingPoint, Plant, one_period
from objectives.margins.period import PeriodMap
from objectives.margins.trim import RatePhases, find_trim
from plant.laws.slower import always_due
from plant.loop import Timing
from plant.quadrotor.cascade import POSITION_AXES, Cascade, close_cascade
from plant.quadrotor.features import VehicleFeatures
from plant.records import paths

Array = NDArray[np.float64]


class SlowPosition:
    """Steady flight of a cascade with slow position loops.

    They step every `every` control periods; the vehicle is fitted so.
    """

    def __init__(self, cascade: Cascade, timing: Timing, fitted: VehicleFeatures) -> None:
        plain = cascade.position.plain
        assert plain is not None
        self.every = cascade.position_every
        self.flown = PeriodMap(cascade, timing, fitted)
        self._resting = PeriodMap(close_cascade(always_due(plain, self.every), cascade.attitude), timing, fitted)
        self._from_rest = _places(self._resting, self.flown)
        names = paths(self.flown.state)
        self._index = {
            part: [names.index(f"control.{axis}.{part}") for axis in POSITION_AXES]
            for part in ("turn", "count", "effect", "command")
        }
        self._demand = [names.index(f"control.acceleration.{axis}") for axis in POSITION_AXES]

    def at(self, gains: Array, setting: OperatingPoint, plant: Plant, secant: Callable[[], Array]) -> RatePhases:
        """Return all control periods of a common one in steady flight.

        gains: gains rows (n, g). See `find_trim`.
        """
        point = find_trim(self._resting, gains, setting, plant, secant)
        state = np.zeros((len(gains), len(self._from_rest)))
        shared = self._from_rest >= 0
        state[:, shared] = point.state[:, self._from_rest[shared]]
        state[:, self._index["command"]] = state[:, self._demand]
        first = one_period(self.flown, state, point.w, gains, setting, plant)
        waiting = one_period(self.flown, first.state, point.w, gains, setting, plant)
        state[:, self._index["count"]] = self.every - 1.0
        state[:, self._index["effect"]] = (self.every - 1.0) * waiting.state[:, self._index["effect"]]
        due = one_period(self.flown, state, point.w, gains, setting, plant)
        return RatePhases((due, *[waiting] * (self.every - 1)), state, point.steady)


@lru_cache(maxsize=32)
def slow_position(cascade: Cascade, timing: Timing, fitted: VehicleFeatures) -> SlowPosition:
    """Return the control periods of a cascade with slow position loops; vehicles of one dead time share them."""
    return SlowPosition(cascade, timing, fitted)


def _places(resting: PeriodMap, flown: PeriodMap) -> NDArray[np.intp]:
    """Return each flown state's index in the loop at rest, or -1."""
    places = {name: place for place, name in enumerate(paths(resting.state))}
    return np.array([places.get(_resting_name(name), -1) for name in paths(flown.state)])


def _resting_name(name: str) -> str:
    """Return the name at rest of a state; that of a slower law holds the law's own and what the waiting takes."""
    room, part, *rest = name.split(".")
    if room != "control" or part not in POSITION_AXES:
        return name
    return ".".join([room, part, *rest[1:]]) if rest[0] == "law" else ""
