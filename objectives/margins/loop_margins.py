"""Margins of sampled loops for batches of gains: one engine for quadrotors and plants, and for channels of any rates.

A system gives its loops linearized about the trim of each vehicle, one control period after another (`Linearization`). Their
nonlinear terms are closed at each amplitude. A block whose channels step together is read at its period (`block`); one of several
rates is lifted over its common period (`lifting`) and read there (`multirate`).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from objectives.margins.block import EVERY, MULTILOOP, BlockReadings, read_block
from objectives.margins.describing import Case, term_gains
from objectives.margins.frequency import frequency_grid
from objectives.margins.injection import Term
from objectives.margins.lifting import Rate, common_period, over_period
from objectives.margins.linearise import LinearLoops
from objectives.margins.multirate import Lifting, read_lifted, response
from objectives.margins.requirement import MarginRequirement
from objectives.margins.results import LoopResponse, Margins, joined
from objectives.margins.sheet import WorstCaseAccumulator
from objectives.margins.structure import Block
from plant.ties import first_largest

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Amplitude at which terms are closed to find the structure and a trim.
MIDDLE = (Case(0.1),)
SMALL = Case(0.0)
# Candidates worked on at once: off hover, where all channels are one block, a hundred with six cases take 0.5 GB.
CHUNK = 100
# The same without the margin of all loops at once, which is what takes the room, and candidates from which on it pays to look at
# the amplitudes that most often decide before the others.
LARGE_CHUNK, MANY = 250, 16


Complex = NDArray[np.complex128]
Channels = tuple[int, ...]
Phases = Sequence[LinearLoops]


class SampledLoop(Protocol):
    """The closed loop of a system, for any vehicle or plant.

    Attributes:
        channels: Names of its channels.
        terms: Nonlinear terms of its laws.
        plant_inputs: Those channels that are inputs of the plant.
        control_period: [s].
        lowest: Frequency from which on curves are read [rad/s].
        columns: Columns of a gains row, by channel.
    """

    channels: tuple[str, ...]
    terms: tuple[Term, ...]
    plant_inputs: tuple[int, ...]
    control_period: float
    lowest: float
    columns: dict[str, list[int]]

    def constants(self, gains: Array) -> Any:
        """Return the constants of all laws for gains rows (n, g): leaves are arrays (n, 1, 1) or numbers."""
        ...


class TrimmedLoops(NamedTuple):
    """Linear loops of gains rows (n, g) about their trims; is_trimmed: rows (n,) that have a trim.

    phases(block, rows): a block's loops under some rows in each control period of the common one, terms left open.
    """

    is_trimmed: Mask
    phases: Callable[[Block, Mask], Sequence[LinearLoops]]


class Linearization(Protocol):
    """Loops of one vehicle or plant about its trim, in blocks; rates: of all channels."""

    blocks: tuple[Block, ...]
    rates: tuple[Rate, ...]

    def at(self, gains: Array) -> TrimmedLoops:
        """Linearize the loops about the trims of gains rows (n, g)."""
        ...


@dataclass(frozen=True)
class Scope:
    """The requested part of an evaluation: fields of `Margins`, and channels.

    decisive: channels any of which, not stable, decides all that is wanted.
    """

    fields: frozenset[str]
    channels: frozenset[int]
    decisive: frozenset[int]


def scope_of(requirements: Sequence[MarginRequirement], names: tuple[str, ...]) -> Scope:
    """Return the part of an evaluation that requirements need.

    names: of the channels.
    """
    requested = frozenset(field for entry in requirements for field in entry.quantity.fields)
    channels = [
        frozenset(names.index(axis) for axis in (names if entry.quantity.is_multiloop else entry.axes))
        for entry in requirements
    ]
    return Scope(requested, frozenset().union(*channels), frozenset.intersection(*channels))


class Reading(NamedTuple):
    """A linearization whose blocks are read.

    slow_only: of each block only the channels that step once in its common period, not all.
    """

    loops: Linearization
    slow_only: bool = False


class LoopMargins(ABC):
    """Worst-case margins of a loop for batches of gains.

    The worst is taken over vehicles and amplitudes.

    Args:
        loop: Channels, terms and period of the loop.
        linearizations: Linearizations of the nominal vehicle first, then of others over which the worst is taken.
        cases: Amplitudes of nonlinear terms that it is taken over; loops without such terms ignore them.
        skew: Sigma of the disk margins.
        points: Points of the frequency grid.
        coarse: Linearizations at one rate that limits are read from in place of those of several, but for their slow channels.
    """

    def __init__(
        self,
        loop: SampledLoop,
        linearizations: Sequence[Linearization],
        cases: Sequence[Case],
        skew: float,
        points: int,
        coarse: Sequence[Linearization] = (),
    ) -> None:
        self._loop, self._linearizations, self._coarse = loop, list(linearizations), list(coarse)
        self.cases = tuple(cases) if loop.terms else (SMALL,)
        self.skew, self._points = skew, points
        self._grid = frequency_grid(self.control_period, points, loop.lowest)

    @property
    def control_period(self) -> float:
        """Control period [s]."""
        return self._loop.control_period

    @property
    def terms(self) -> tuple[Term, ...]:
        """Nonlinear terms of the laws."""
        return self._loop.terms

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of all channels."""
        return self._loop.channels

    @property
    def blocks(self) -> tuple[tuple[str, ...], ...]:
        """Channels of the blocks that the first vehicle's loop falls into."""
        return tuple(tuple(self.channels[i] for i in block.channels) for block in self._linearizations[0].blocks)

    @abstractmethod
    def probe_frequencies(self) -> Array:
        """Return the frequencies [rad/s] at which loops are compared."""

    @abstractmethod
    def figure_frequencies(self, margins: Margins, points: int) -> Array:
        """Return the frequencies (points,) [rad/s] at which loops with these margins are drawn."""

    def evaluate(self, gains: Array) -> Margins:
        """Return the margins of candidates, in the worst vehicle and case.

        Args:
            gains: One row for each candidate (n, gains).

        Returns:
            Margins (n, channels) in SI units: factors, rad, s; see `objectives.margins.quantities`.
        """
        everything = Scope(EVERY, frozenset(range(len(self.channels))), frozenset())
        readings = [[Reading(each)] for each in self._linearizations]
        return joined([self._read(part, everything, readings, True).summed(self.skew) for part in _parts(gains, CHUNK)])

    def limited(self, gains: Array, requirements: Sequence[MarginRequirement]) -> Array:
        """Return the values (n, requirements) of limits on margins.

        They are those of `evaluate`; nothing else is worked out.
        gains (n, gains). If a loop that all of them ask for is not stable, the candidate's other loops are not looked at.
        """
        scope = scope_of(requirements, self.channels)
        readings = [[Reading(each)] for each in self._linearizations]
        if self._coarse:
            pairs = zip(self._coarse, self._linearizations, strict=True)
            readings = [[Reading(coarse), Reading(each, slow_only=True)] for coarse, each in pairs]
        return np.concatenate(
            [
                np.stack([entry.values(margins) for entry in requirements], axis=1)
                for part in _parts(gains, CHUNK if scope.fields >= {MULTILOOP} else LARGE_CHUNK)
                for margins in [self._read(part, scope, readings, False).summed(self.skew)]
            ],
            axis=0,
        )

    def _read(
        self, gains: Array, scope: Scope, readings: Sequence[Sequence[Reading]], is_located: bool
    ) -> WorstCaseAccumulator:
        sheet = WorstCaseAccumulator(
            len(gains), len(readings), self.cases, self.control_period, scope.fields, self.channels, is_located
        )
        if not len(gains):
            return sheet
        term, undecided = self._term_gains(gains, self.cases), np.ones(len(gains), dtype=bool)
        for i, of_vehicle in enumerate(readings):
            lost = np.zeros(len(gains), dtype=bool)
            for loops, slow_only in of_vehicle:
                trimmed = loops.at(gains)
                lost |= ~trimmed.is_trimmed
                for block in _requested(loops.blocks, scope.channels):
                    picked = _picked(block, loops.rates, slow_only)
                    if not picked:
                        continue
                    sheet.sweep(block)
                    rows = ~lost & undecided
                    if block.image is not None:
                        original = loops.blocks[block.image]
                        alike = self._alike(gains, block, original)
                        sheet.copy(i, block, alike, original)
                        rows &= ~alike
                    for cases in self._rounds(len(gains), block, scope):
                        if rows.any():
                            read = self._block(
                                loops, block, picked, trimmed.phases(block, rows), term[rows][:, cases], scope
                            )
                            if slow_only:
                                sheet.destabilize(i, block, rows, cases, read.modes.stable)
                            sheet.update(i, replace(block, channels=picked), rows, cases, read)
                            if not scope.decisive.isdisjoint(block.channels):
                                stable = read.modes.stable.reshape(np.count_nonzero(rows), -1).all(axis=1)
                                undecided[np.nonzero(rows)[0][~stable]] = False
                                rows &= undecided
            sheet.discard(i, lost)
        return sheet

    def _block(
        self, loops: Linearization, block: Block, picked: Channels, phases: Phases, term: Array, scope: Scope
    ) -> BlockReadings:
        """Read the margins of some channels of a block, the others closed; the disk of all inputs is that of all channels."""
        fields = scope.fields if picked == block.channels else scope.fields - {MULTILOOP}
        inputs = [j for j, channel in enumerate(picked) if channel in self._loop.plant_inputs]
        closed, form = self._closed(loops, block, picked, phases, term)
        if form.periods == 1:
            return read_block(closed, self._grid, self.control_period, self.skew, inputs, fields)
        return read_lifted(closed, form, self.skew, inputs, fields)

    def _closed(
        self, loops: Linearization, block: Block, picked: Channels, phases: Phases, term: Array
    ) -> tuple[LinearLoops, Lifting]:
        """Return channels of a block over its common period, and their form.

        term (n, cases, terms): gains of its terms.
        """
        rates = [loops.rates[channel] for channel in picked]
        periods = common_period(block.channels, loops.rates)
        form = Lifting.of(rates, self.control_period, periods, self._loop.lowest, self._points)
        return over_period(block, phases[:periods], term, picked, rates), form

    def _rounds(self, n: int, block: Block, scope: Scope) -> list[list[int]]:
        """Cases in the order in which n candidates are looked at: where one may decide, those that most often do first."""
        cases = list(range(len(self.cases)))
        if n < MANY or not block.terms or scope.decisive.isdisjoint(block.channels) or len(cases) < 3:
            return [cases]
        return [[cases[0], cases[-1]], cases[1:-1]]

    def constants(self, gains: Array) -> Any:
        """Constants of all channels for gains rows (n, g): leaves are arrays (n, 1, 1) or numbers."""
        return self._loop.constants(gains)

    def open_blocks(self, gains: Array) -> list[tuple[Block, Phases]]:
        """Return the first vehicle's blocks and loops under a gains row (g,).

        The loops (1, ...) are those in each control period, terms open.
        """
        loops, every_vehicle = self._linearizations[0], np.ones(1, dtype=bool)
        trimmed = loops.at(np.asarray(gains, dtype=float)[None])
        return [
            (block, trimmed.phases(block, every_vehicle)[: common_period(block.channels, loops.rates)])
            for block in loops.blocks
        ]

    def slowest_poles(self, gains: Array) -> list[tuple[tuple[str, ...], complex]]:
        """Return the least stable pole [1/s] of each block.

        Each stands behind the names of the block's channels. The poles are those of the first vehicle under a gains row (g,), in
        the worst amplitude.
        """
        term, rates = self._term_gains(np.asarray(gains, dtype=float)[None], self.cases), self._linearizations[0].rates
        poles = []
        for block, phases in self.open_blocks(gains):
            closed = over_period(block, phases, term, block.channels, [rates[channel] for channel in block.channels])
            z = np.linalg.eigvals(closed.a).astype(complex).ravel()
            slowest = np.log(z[first_largest(np.abs(z))]) / (len(phases) * self.control_period)
            poles.append((tuple(self.channels[channel] for channel in block.channels), complex(slowest)))
        return poles

    def loop(self, gains: Array, channel: str, case: Case = SMALL, frequency: Array | None = None) -> LoopResponse:
        """Return the response of the first vehicle's loop in a channel.

        gains: a gains row (g,). frequency: (f,) [rad/s], by default the grid.
        Of a channel with several instants in a common period it is the part at the frequency of the signal injected.
        """
        w = self._grid[0, 1:] if frequency is None else np.asarray(frequency, dtype=float)
        row, first = np.asarray(gains, dtype=float)[None], np.zeros((1, len(self.channels)), dtype=int)
        t = self._responses(row, self._term_gains(row, (case,)), first, w, {self.channels.index(channel)})
        return LoopResponse(w, t[0, self.channels.index(channel)])

    def curves(self, gains: Array, cases: NDArray[np.intp], frequency: Array) -> Complex:
        """Loop transfer functions (n, channels, f) of the first vehicle under gains rows (n, g) at frequencies (f,) [rad/s].

        cases (n, channels): number of the amplitude in `cases` for each. A channel without a loop has zeros.
        """
        t = self._responses(
            gains, self._term_gains(gains, self.cases), cases, frequency, set(range(len(self.channels)))
        )
        return LoopResponse(frequency, t).loop

    def _responses(self, gains: Array, term: Array, cases: NDArray[np.intp], w: Array, channels: set[int]) -> Complex:
        """T (n, channels, f) of some channels; of a block that is the image of another where their gains are alike, its T."""
        loops, t = self._linearizations[0], np.zeros((len(gains), len(self.channels), len(w)), dtype=complex)
        trimmed = loops.at(gains)
        for block in loops.blocks:
            original = block if block.image is None else loops.blocks[block.image]
            alike = self._alike(gains, block, original) & (original is not block)
            for index, like in zip(block.channels, original.channels, strict=True):
                if index not in channels:
                    continue
                same = alike & (cases[:, index] == cases[:, like]) & (like in channels)
                t[same, index] = t[same, like]
                rows = np.flatnonzero(~same)
                if len(rows):
                    phases = trimmed.phases(block, ~same)
                    closed, form = self._closed(loops, block, (index,), phases, term[rows, cases[rows, index]][:, None])
                    for i, row in enumerate(rows):
                        t[row, index] = response(closed, form, i, w)
        return t

    def _alike(self, gains: Array, block: Block, original: Block) -> Mask:
        """Candidates whose gains in the channels of two blocks are the same."""
        pairs = zip(block.channels, original.channels, strict=True)
        columns = [[self._loop.columns[self.channels[channel]] for channel in pair] for pair in pairs]
        return np.all([np.all(gains[:, mine] == gains[:, its], axis=1) for mine, its in columns], axis=0)

    def _term_gains(self, gains: Array, cases: Sequence[Case]) -> Array:
        return gains_of_terms(self._loop, gains, cases)


def gains_of_terms(loop: SampledLoop, gains: Array, cases: Sequence[Case] = MIDDLE) -> Array:
    """Return the equivalent gains (n, cases, terms) of a loop's nonlinear terms.

    gains: gains rows (n, g).
    """
    return term_gains(loop.terms, loop.constants(gains), len(gains), tuple(cases))


def _parts(gains: Array, size: int) -> list[Array]:
    """Return gains rows in batches of some size, at least one."""
    gains = np.asarray(gains, dtype=float)
    return [gains[i : i + size] for i in range(0, max(len(gains), 1), size)]


def _requested(blocks: Sequence[Block], channels: frozenset[int]) -> list[Block]:
    """Return the blocks of channels and their possible originals, small ones first.

    An original is a block of which another may be an image.
    """
    direct = [i for i, block in enumerate(blocks) if not channels.isdisjoint(block.channels)]
    images = {image for i in direct if (image := blocks[i].image) is not None}
    return sorted((blocks[i] for i in sorted({*direct, *images})), key=lambda block: len(block.into))


def _picked(block: Block, rates: Sequence[Rate], slow_only: bool) -> Channels:
    """Return the channels of a block that are read; of one of a single rate all or, where slow ones alone are, none."""
    if not slow_only:
        return block.channels
    periods = common_period(block.channels, rates)
    return tuple(channel for channel in block.channels if 1 < periods == rates[channel].every)
