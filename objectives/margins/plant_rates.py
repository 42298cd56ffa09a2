"""Blocks of a plant's loops and how their margins are read: of channels that step together, and of channels of several rates."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.margins.block import BlockReadings, read_block
from objectives.margins.closing import close_terms
from objectives.margins.describing import Case, term_gains_of
from objectives.margins.frequency import frequency_grid, moved, without_idle
from objectives.margins.lifting import instants_of, lifted, rates_of
from objectives.margins.linearise import LinearLoops
from objectives.margins.multirate import Lifting, fundamental, read_lifted
from objectives.margins.plant_period import PlantPeriod
from objectives.margins.results import Realisation
from objectives.margins.structure import Block, blocks_of, with_terms

Array = NDArray[np.float64]
MIDDLE = Case(0.1)
# Lowest frequency that is looked at [rad in a control period]: a plant of hours is seen like one of milliseconds.
LOWEST = 1e-5


class OneRate:
    """Loops of a plant whose channels step together, split into blocks under probes, gains rows (p, g)."""

    def __init__(self, period: PlantPeriod, probes: Array, points: int) -> None:
        self._period, self._grid = period, frequency_grid(period.h, points, LOWEST / period.h)
        (loops,) = period.phases(probes)
        closed = close_terms(loops, _term_gains(period, probes, (MIDDLE,))[:, 0])
        self.blocks = blocks_of(closed, np.eye(loops.a.shape[-1]))

    def closed(self, gains: Array, cases: tuple[Case, ...]) -> Iterator[tuple[Block, LinearLoops]]:
        """Yield the blocks with their loops under gains rows (n, g), terms closed: rows are candidates, then cases."""
        (loops,), term = self._period.phases(gains), _term_gains(self._period, gains, cases)
        for block in self.blocks:
            yield block, with_terms(block, block.part(loops), term)

    def opened(self, gains: Array) -> Iterator[tuple[Block, LinearLoops]]:
        """Yield the blocks with their loops under gains rows (n, g), terms left open."""
        (loops,) = self._period.phases(gains)
        for block in self.blocks:
            yield block, block.part(loops)

    def read(
        self, block: Block, loops: LinearLoops, skew: float, inputs: list[int], asked: frozenset[str]
    ) -> BlockReadings:
        """Read the margins of a block's closed loops; inputs: which of its channels are inputs of the plant."""
        del block
        return read_block(loops, self._grid, self._period.h, skew, inputs, asked)

    def response(
        self, block: Block, loops: LinearLoops, row: int, channel: int, frequency: Array
    ) -> NDArray[np.complex128]:
        """Return T of one loop of a block at frequencies (f,) [rad/s]; row and channel: which of its closed loops."""
        del block
        own = Realisation(loops.a[row], loops.b[row, :, channel], loops.c[row, channel], self._period.h)
        return own.response(frequency).t


class _Lifted(NamedTuple):
    """A block of lifted loops, and the instants of each of its channels."""

    inner: Block
    form: Lifting


class SeveralRates:
    """Loops of a plant whose channels step at several rates, over their common period; see `objectives.margins.multirate`."""

    def __init__(self, period: PlantPeriod, probes: Array, points: int) -> None:
        self._period, self._points = period, points
        self._rates = rates_of(period.plan, period.h)
        loops = self._lifted(probes, (MIDDLE,))
        instants = instants_of(self._rates, period.periods)
        self._parts: dict[tuple[int, ...], _Lifted] = {}
        self.blocks: tuple[Block, ...] = ()
        for inner in blocks_of(loops, np.eye(loops.a.shape[-1])):
            self._add(inner, instants)

    def _add(self, inner: Block, instants: Sequence[range]) -> None:
        channels = tuple(i for i, own in enumerate(instants) if set(own) & set(inner.channels))
        mine = tuple(tuple(n for n, at in enumerate(inner.channels) if at in instants[i]) for i in channels)
        names = [self._period.plan.names[i] for i in channels]
        terms = tuple(i for i, term in enumerate(self._period.terms) if term.axis in names)
        h = self._period.h
        self._parts[channels] = _Lifted(inner, Lifting(h, self._period.periods, mine, LOWEST / h, self._points))
        self.blocks += (replace(inner, channels=channels, terms=terms),)

    def closed(self, gains: Array, cases: tuple[Case, ...]) -> Iterator[tuple[Block, LinearLoops]]:
        """Yield the blocks with their lifted loops, see `OneRate.closed`."""
        loops = self._lifted(gains, cases)
        for block in self.blocks:
            part = self._parts[block.channels].inner.part(loops)
            # Values that are held and given anew are chains of poles at 0, whose eigenvectors depend on each other.
            yield block, replace(part, a=moved(without_idle(part.a, part.b[..., part.injected])))

    def opened(self, gains: Array) -> Iterator[tuple[Block, LinearLoops]]:
        """Yield the blocks with their loops under gains rows (n, g), terms left open."""
        (loops,) = self._period.phases(gains)
        for block in self.blocks:
            yield block, block.part(loops)

    def read(
        self, block: Block, loops: LinearLoops, skew: float, inputs: list[int], asked: frozenset[str]
    ) -> BlockReadings:
        """Read the margins of a block's closed loops, see `OneRate.read`."""
        return read_lifted(loops, self._parts[block.channels].form, skew, inputs, asked)

    def response(
        self, block: Block, loops: LinearLoops, row: int, channel: int, frequency: Array
    ) -> NDArray[np.complex128]:
        """Return what a channel's command holds of a sine injected at its frequency, see `OneRate.response`."""
        return fundamental(loops, self._parts[block.channels].form, row, channel, frequency)

    def _lifted(self, gains: Array, cases: tuple[Case, ...]) -> LinearLoops:
        """Loops over the common period, all terms closed: rows are gains rows (n, g), then cases."""
        term = _term_gains(self._period, gains, cases)
        phases = [close_terms(loops.expanded(), term).flattened() for loops in self._period.phases(gains)]
        return lifted(phases, self._rates)


def rates_for(period: PlantPeriod, probes: Array, points: int) -> OneRate | SeveralRates:
    """Return the loops of a plant, split into blocks under probes, gains rows (p, g)."""
    kind: Any = OneRate if period.periods == 1 else SeveralRates
    return kind(period, probes, points)


def _term_gains(period: PlantPeriod, gains: Array, cases: tuple[Case, ...]) -> Array:
    return term_gains_of(period.terms, period.constants(gains), len(gains), cases)
