"""Margins of the quadrotor that flies: its loops linearized about a trim, vehicle by vehicle, for `loop_margins` to read."""

from collections.abc import Sequence
from itertools import product
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from objectives.margins.assembly import Assembly
from objectives.margins.closing import close_terms
from objectives.margins.describing import DEFAULT_CASES, Case
from objectives.margins.frequency import POINTS
from objectives.margins.lifting import Rate, common_period, over_period
from objectives.margins.linearise import LinearLoops
from objectives.margins.loop_margins import LoopMargins, TrimmedLoops, gains_of_terms
from objectives.margins.period import CHANNELS, PeriodMap, period_map
from objectives.margins.results import Margins
from objectives.margins.slow_position import SlowPosition, slow_position
from objectives.margins.structure import Block, blocks_of, coordinates, with_images
from objectives.margins.trim import RatePhases, Trim, balanced_plant, find_trim, setting_of
from plant.errors import InputError
from plant.loop import Timing
from plant.quadrotor.cascade import POSITION_AXES, Cascade
from plant.quadrotor.features import vehicle_features
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import Nominal, vary
from plant.quadrotor.scenarios import Spread
from plant.quadrotor.vehicle import Vehicle, late_periods
from plant.seeds import generator

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Gains rows that the structure is read off from; of laws with filters, some of which a probe may leave out, there are more.
PROBES, FILTER_PROBES = 4, 16
# Frequencies [rad/s] from which on loops are drawn, and at which they are compared.
DRAWN_FROM, PROBED = 0.05, np.array([0.3, 2.0, 11.0, 60.0])
_LATEST_TERM_GAINS: WeakKeyDictionary[Any, tuple[tuple[bytes, tuple[Case, ...]], Array]] = WeakKeyDictionary()
"""The last gains of terms of each control period: gains rows and cases, and the array."""
NOT_STEADY = "no steady flight is found under any of a few gains from their search ranges"


def spread_corners(vehicle: Vehicle, spread: Spread) -> tuple[Vehicle, ...]:
    """Return the vehicles at the corners of a spread.

    Mass, inertia, thrust and lag spread; their number is 2 to the number of those that are spread.
    The center of mass stays in the middle: off it, thrust turns the body, but no loop's own margins change.
    """
    ends = [(middle - width, middle + width) if width > 0.0 else (middle,) for middle, width in spread.factors]
    return tuple(vary(vehicle, *corner) for corner in product(*ends))


class MarginModel(LoopMargins):
    """Margins of a cascade on a vehicle in a trim.

    The controller with this `nominal` and timing flies it.
    Raises InputError where there is no steady flight.

    Args:
        cascade: The cascade, with the rates that it flies at.
        nominal: The controller's knowledge of the vehicle.
        timing: Control period and plant step [s].
        vehicle: The vehicle that flies.
        trim: Steady flight; hover in still air by default.
        others: Further vehicles, such as `spread_corners`, that the worst is taken over.
        cases: Amplitudes of the nonlinear terms that it is taken over; loops without such terms ignore them.
        skew: Sigma of the disk margins.
        points: Points of the frequency grid.
        exact: Whether `limited` too reads attitude loops inside position loops that wait exactly, at 0.1 s a candidate; else
            they are read there with the position loops taken as if they stepped as often, which is off by up to 2 %.
    """

    def __init__(
        self,
        cascade: Cascade,
        nominal: Nominal,
        timing: Timing,
        vehicle: Vehicle,
        trim: Trim | None = None,
        *,
        others: Sequence[Vehicle] = (),
        cases: Sequence[Case] = DEFAULT_CASES,
        skew: float = 0.0,
        points: int = POINTS,
        exact: bool = False,
    ) -> None:
        self.trim, self.timing, self.flown, self.cascade = trim or Trim(), timing, cascade, cascade.at_one_rate
        self.vehicles = (vehicle, *others)
        fitted = vehicle_features(vehicle, timing.control_period, nominal.harmonics, nominal.vehicle)
        prompt, has_slow = period_map(self.cascade, timing, fitted), cascade.position_every > 1

        def linearized(each: Vehicle, is_slow: bool) -> TrimLinearization:
            features = fitted._replace(delay_steps=late_periods(each, timing.control_period))
            slow = slow_position(cascade, timing, features) if is_slow else None
            return TrimLinearization(period_map(self.cascade, timing, features), self.trim, nominal, each, slow)

        loops = [linearized(each, has_slow) for each in self.vehicles]
        coarse = [linearized(each, False) for each in self.vehicles if has_slow and not exact]
        super().__init__(prompt, loops, cases, skew, points, coarse)

    def _term_gains(self, gains: Array, cases: Sequence[Case]) -> Array:
        # They depend on no trim, and candidates are looked at in one trim after the other.
        key, latest = (gains.tobytes(), tuple(cases)), _LATEST_TERM_GAINS.get(self._loop)
        if latest is None or latest[0] != key:
            latest = key, gains_of_terms(self._loop, gains, cases)
            _LATEST_TERM_GAINS[self._loop] = latest
        return latest[1]

    def probe_frequencies(self) -> Array:
        """Return the frequencies [rad/s] at which loops are compared."""
        return PROBED

    def figure_frequencies(self, margins: Margins, points: int) -> Array:  # noqa: ARG002
        """Return the frequencies (points,) [rad/s] at which loops with these margins are drawn."""
        return np.geomspace(DRAWN_FROM, np.pi / self.control_period, points)


class TrimLinearization:
    """The loops of a vehicle about its trim, split into blocks; those with position loops that wait where `slow` is given.

    Args:
        period: Control period of the cascade, all loops at one rate.
        trim: Steady flight.
        nominal: The controller's knowledge of the vehicle.
        vehicle: The vehicle that flies.
        slow: Control periods of the cascade with position loops that wait.
    """

    def __init__(
        self, period: PeriodMap, trim: Trim, nominal: Nominal, vehicle: Vehicle, slow: SlowPosition | None = None
    ) -> None:
        self._period, self._slow = period, slow
        every = 1 if slow is None else slow.every
        self.rates = tuple(_rate(axis, every, nominal) for axis in CHANNELS)
        self._setting = setting_of(trim, nominal, vehicle)
        self._plant = balanced_plant(period, trim, nominal, self._setting)
        self.blocks = self._blocks(nominal)
        flown = period if slow is None else slow.flown
        self._assemblies = {
            block.channels: Assembly(block, self._plant, len(period.terms), flown.decide.where, flown.decide.shape)
            for block in self.blocks
        }

    def at(self, gains: Array) -> TrimmedLoops:
        """Linearize the loops about the trims of gains rows (n, g)."""
        flight = self._phases(gains)

        def phases(block: Block, rows: Mask) -> list[LinearLoops]:
            assembly = self._assemblies[block.channels]
            loops = {id(step): assembly(step, rows) for step in flight.steps}
            return [loops[id(step)] for step in flight.steps]

        return TrimmedLoops(flight.steady, phases)

    def _phases(self, gains: Array) -> RatePhases:
        setting, plant = self._setting, self._plant

        def secant() -> Array:
            return gains_of_terms(self._period, gains)[:, 0]

        if self._slow is not None:
            return self._slow.at(gains, setting, plant, secant)
        point = find_trim(self._period, gains, setting, plant, secant)
        return RatePhases((point.step,), point.state, point.steady)

    def _blocks(self, nominal: Nominal) -> tuple[Block, ...]:
        """Return the blocks of the loop under a few gains rows.

        Those are spread over the search ranges.
        """
        gains = probes(self._period.cascade)
        steps, state, steady = self._phases(gains)
        if not steady.any():
            raise InputError(NOT_STEADY, key="trim")
        term = gains_of_terms(self._period, gains[steady])[:, 0]
        closed = [close_terms(step.loops.of(steady), term) for step in {id(step): step for step in steps}.values()]
        flown = steps[0].period
        blocks = blocks_of(LinearLoops.stacked(closed), coordinates(flown, nominal.vehicle, state[steady][0]))
        # The same probes with the gains of x in y and of pitch in roll.
        gains = gains[steady]
        for axis, like in (("y", "x"), ("roll", "pitch")):
            gains[:, self._period.columns[axis]] = gains[:, self._period.columns[like]]

        def loops(block: Block, rows: slice) -> LinearLoops:
            return self._over_period(block, gains[rows])

        return with_images(blocks, loops)

    def _over_period(self, block: Block, gains: Array) -> LinearLoops:
        """Return a block's loops over its common period, under gains rows (n, g)."""
        steps = self._phases(gains).steps
        parts = {id(step): block.part(step.loops) for step in steps}
        phases = [parts[id(step)] for step in steps[: common_period(block.channels, self.rates)]]
        term = gains_of_terms(self._period, gains)
        return over_period(block, phases, term, block.channels, [self.rates[channel] for channel in block.channels])


def _rate(axis: str, every: int, nominal: Nominal) -> Rate:
    """Return the rate of a channel at its break point.

    The demands of x and y change as their loops step. The lift changes at the rotors, one period later under compute delay.
    """
    if axis not in POSITION_AXES:
        return Rate(1, 0, 1)
    is_late = axis == "z" and nominal.delay > 0.5
    return Rate(every, int(is_late) % every, every)


def probes(cascade: Cascade) -> Array:
    """Return gains rows spread over the search ranges."""
    addresses = gain_addresses(cascade)
    low, high = (np.array([getattr(gain.span, end) for gain in addresses]) for end in ("low", "high"))
    count = FILTER_PROBES if any(gain.info.cutoff for gain in addresses) else PROBES
    draws = [generator(0, "margins/probes", i).uniform(size=len(addresses)) for i in range(count)]
    return low + np.array(draws) * (high - low)
