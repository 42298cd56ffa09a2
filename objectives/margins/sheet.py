"""Accumulator of margins over vehicles and cases that keeps the worst."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.block import MULTILOOP, BlockReadings
from objectives.margins.describing import Case
from objectives.margins.period import CHANNELS
from objectives.margins.quantities import LOOP_QUANTITIES, MarginQuantity
from objectives.margins.results import Margins, Worst, worst
from objectives.margins.structure import Block

Mask = NDArray[np.bool_]


class WorstCaseAccumulator:
    """Values (n, vehicles, cases, channels) by quantity; they start as those of channels without a loop.

    Args:
        n: Number of candidates.
        vehicles: Number of vehicles.
        cases: Amplitudes of the nonlinear terms.
        control_period: [s].
        requested: Fields of `Margins` that are kept; the others stay empty.
        channels: Names of the channels.
        is_located: Whether frequencies, cases, vehicles and growth are kept too; else those of the sum are 0.
    """

    def __init__(
        self,
        n: int,
        vehicles: int,
        cases: tuple[Case, ...],
        control_period: float,
        requested: frozenset[str],
        channels: tuple[str, ...] = CHANNELS,
        is_located: bool = True,
    ) -> None:
        self._is_located = is_located
        shape = (n, vehicles, len(cases), len(channels))
        self._cases, self._control_period, self._channels = cases, control_period, channels
        shapes = {entry.field: shape if entry.field in requested else (0, *shape[1:]) for entry in LOOP_QUANTITIES}
        self._has_multiloop = MULTILOOP in requested
        self._requested = [entry for entry in LOOP_QUANTITIES if entry.field in requested]
        self._value = {entry.field: np.full(shapes[entry.field], entry.open) for entry in LOOP_QUANTITIES}
        self._frequency = {entry.field: np.zeros(shapes[entry.field]) for entry in LOOP_QUANTITIES}
        self._growth, self._stable = np.full(shape, -np.inf), np.ones(shape, dtype=bool)
        self._together, self._together_at = np.full((*shape[:3], 1), np.inf), np.zeros((*shape[:3], 1))
        self._swept = np.zeros(len(channels), dtype=bool)

    def sweep(self, block: Block) -> None:
        """Mark a block's channels to report cases where it has terms.

        They report whether or not any candidate is entered.
        """
        self._swept[list(block.channels)] |= bool(block.terms)

    def update(self, vehicle: int, block: Block, rows: Mask, cases: list[int], read: BlockReadings) -> None:
        """Enter the readings of a block for some candidates: their rows are candidates, then cases, or one for all cases."""
        chosen, every = np.nonzero(rows)[0], np.array(cases)

        def by_case(values: Any) -> Any:
            return values.reshape(len(chosen), 1, len(values) // len(chosen), -1)

        spot = np.ix_(chosen, np.array([vehicle]), every, np.array(block.channels))
        for name, at in read.quantities.items():
            self._value[name][spot] = by_case(at.value)
            if self._is_located:
                self._frequency[name][spot] = by_case(at.frequency)
        self._stable[spot] = by_case(read.modes.stable)
        if self._is_located:
            self._growth[spot] = by_case(read.modes.growth / self._control_period)
        if not self._has_multiloop:
            return
        spot = np.ix_(chosen, np.array([vehicle]), every, np.array([0]))
        value, before = by_case(read.together.value), self._together[spot]
        self._together_at[spot] = np.where(value < before, by_case(read.together.frequency), self._together_at[spot])
        self._together[spot] = np.minimum(value, before)

    def destabilize(self, vehicle: int, block: Block, rows: Mask, cases: list[int], stable: Mask) -> None:
        """Remove a block's margins where its loop is not stable; rows as in `update`.

        It takes them from all channels that are part of the loop.
        """
        chosen = np.nonzero(rows)[0]
        lost = np.broadcast_to(~stable.reshape(len(chosen), -1), (len(chosen), len(cases)))
        for candidate, case in zip(*np.nonzero(lost), strict=True):
            spot = (chosen[candidate], vehicle, cases[case], list(block.channels))
            for entry in self._requested:
                self._value[entry.field][spot], self._frequency[entry.field][spot] = entry.unstable, 0.0
            self._stable[spot] = False
            self._together[spot[:3]] = 0.0

    def copy(self, vehicle: int, block: Block, rows: Mask, original: Block) -> None:
        """Enter for some candidates what another block has, channel by channel."""
        tables = [table[entry.field] for table in (self._value, self._frequency) for entry in self._requested]
        for array in (*tables, self._stable, self._growth):
            for to, of in zip(block.channels, original.channels, strict=True):
                array[rows, vehicle, :, to] = array[rows, vehicle, :, of]

    def discard(self, vehicle: int, rows: Mask) -> None:
        """Nothing is stable where no steady flight was found."""
        for entry in self._requested:
            self._value[entry.field][rows, vehicle] = entry.unstable
            self._frequency[entry.field][rows, vehicle] = 0.0
        self._stable[rows, vehicle] = False
        self._growth[rows, vehicle] = np.inf
        self._together[rows, vehicle] = 0.0

    def summed(self, skew: float) -> Margins:
        """The worst over vehicles and cases; a channel without nonlinear terms reports case -1."""
        case = np.where(self._swept[:, None], np.arange(len(self._cases)), -1)
        of_loops = {entry.field: self._worst(entry, case) for entry in LOOP_QUANTITIES}
        together = worst(self._together, self._together_at, "min", case.max(axis=0, keepdims=True))
        return Margins(
            cases=self._cases,
            control_period=self._control_period,
            skew=skew,
            channels=self._channels,
            stable=np.asarray(self._stable.all(axis=(1, 2))),
            growth=self._growth.max(axis=(1, 2)),
            multiloop=Worst(
                together.value[:, 0], together.frequency[:, 0], together.case[:, 0], together.vehicle[:, 0]
            ),
            **of_loops,
        )

    def _worst(self, entry: MarginQuantity, case: NDArray[np.intp]) -> Worst:
        """Return a quantity in the worst condition; case (channels, cases): index to report."""
        value = self._value[entry.field]
        if self._is_located and len(value):
            return worst(value, self._frequency[entry.field], entry.sense, case)
        extreme = np.min(value, axis=(1, 2)) if entry.sense == "min" else np.max(value, axis=(1, 2))
        nowhere = np.zeros(extreme.shape, dtype=np.intp)
        return Worst(extreme, np.zeros(extreme.shape), nowhere, nowhere)
