"""Margins of position loops that step every few control periods, and of the attitude loops inside them.

Broken at its command, which changes once in a common period, such a loop is one of constant matrices from one common period to
the next: those of the period in which the position loops step and of those in which they wait, one after another (`lifting`). So
its margins are the classical ones of a loop sampled at that period, exactly, and so are the poles of all that it closes. An
attitude loop inside has one instant in each control period, and its exact margins are those of `multirate`, at some 30 ms a
candidate; a search reads it at its own rate, with the position loops around it taken as if they stepped as often.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.margins.assembly import Assembly
from objectives.margins.block import MULTILOOP, BlockReadings, read_block
from objectives.margins.closing import close_terms
from objectives.margins.frequency import LOWEST, frequency_grid, moved, without_idle
from objectives.margins.lifting import Rate, instants_of, lifted
from objectives.margins.linearise import LinearLoops, PeriodStep, Plant, Surroundings, one_period
from objectives.margins.multirate import Lifting, read_lifted
from objectives.margins.period import CHANNELS, PeriodMap
from objectives.margins.structure import Block, blocks_of, coordinates, with_terms
from objectives.margins.trim import find_trim
from plant.cascade import POSITION_AXES, Cascade, close_cascade
from plant.fittings import Fittings
from plant.laws.slower import always_due
from plant.loop import Timing
from plant.nominal import Nominal
from plant.records import paths

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# Crossings and peaks of a lifted loop are refined, and a point of its grid takes as many eigenvalues as it has instants.
COARSER = 3
PLACES = tuple(CHANNELS.index(axis) for axis in POSITION_AXES)


class Paced(NamedTuple):
    """The control period in which position loops step and one in which they wait, and which candidates (n,) are steady."""

    due: PeriodStep
    waiting: PeriodStep
    steady: Mask


class SlowPosition:
    """The control periods of a cascade whose position loops step every `every` of them, fitted as `PeriodMap` has it."""

    def __init__(self, cascade: Cascade, timing: Timing, fitted: Fittings, points: int) -> None:
        plain = cascade.position.plain
        assert plain is not None
        self.every = cascade.position_every
        self.flown = PeriodMap(cascade, timing, fitted)
        self._resting = PeriodMap(close_cascade(always_due(plain, self.every), cascade.attitude), timing, fitted)
        self.period = self.every * timing.control_period
        self.points, self.grid = points, frequency_grid(self.period, points)
        self._from_rest = _places(self._resting, self.flown)
        names = paths(self.flown.state)
        self._index = {
            part: [names.index(f"control.{axis}.{part}") for axis in POSITION_AXES]
            for part in ("turn", "count", "effect", "command")
        }
        self._demand = [names.index(f"control.acceleration.{axis}") for axis in POSITION_AXES]

    def paced(self, gains: Array, setting: Surroundings, plant: Plant, secant: Array) -> Paced:
        """Return both kinds of control period in steady flight of gains rows (n, g); see `find_trim`."""
        point = find_trim(self._resting, gains, setting, plant, lambda: secant)
        state = np.zeros((len(gains), len(self._from_rest)))
        known = self._from_rest >= 0
        state[:, known] = point.state[:, self._from_rest[known]]
        state[:, self._index["command"]] = state[:, self._demand]
        first = one_period(self.flown, state, point.w, gains, setting, plant)
        waiting = one_period(self.flown, first.state, point.w, gains, setting, plant)
        state[:, self._index["count"]] = self.every - 1.0
        state[:, self._index["effect"]] = (self.every - 1.0) * waiting.state[:, self._index["effect"]]
        return Paced(one_period(self.flown, state, point.w, gains, setting, plant), waiting, point.steady)

    def blocks(self, paced: Paced, term: Array, nominal: Nominal) -> tuple[Block, ...]:
        """Return the blocks with a position loop, common to both kinds of period; term (n, terms): gains of the steady probes."""
        steady = paced.steady
        closed = [close_terms(step.loops.of(steady), term) for step in (paced.due, paced.waiting)]
        both = replace(closed[0], **{name: np.concatenate([getattr(each, name) for each in closed]) for name in "abcd"})
        found = blocks_of(both, coordinates(self.flown, nominal.vehicle, paced.due.state[steady][0]))
        return tuple(block for block in found if not set(PLACES).isdisjoint(block.channels))

    def over_period(self, phases: Sequence[LinearLoops], rates: Sequence[Rate]) -> LinearLoops:
        """Return the loops over a common period of those of its due period and of one that waits, terms closed."""
        due, waiting = phases
        loops = lifted([due, *[waiting] * (self.every - 1)], rates)
        return replace(loops, a=moved(without_idle(loops.a, loops.b[..., loops.injected])))

    def loops(self, block: Block, plant: Plant) -> "SlowBlock":
        """Return the loops of a block."""
        decide = self.flown.decide
        return SlowBlock(self, block, Assembly(block, plant, len(self.flown.terms), decide.where, decide.shape))


@dataclass(frozen=True)
class SlowBlock:
    """A block with position loops of a vehicle in its trim, and the attitude loops inside them."""

    slow: SlowPosition
    block: Block
    assembly: Assembly

    @property
    def loops(self) -> "list[SlowLoop]":
        """The position loops of the block."""
        return [SlowLoop(self, channel) for channel in self.block.channels if channel in PLACES]

    def lifted(self, paced: Paced, rows: Mask, term: Array) -> LinearLoops:
        """Return all loops of the block over a common period; term (n, cases, terms) of the rows: candidates, then cases."""
        return self.slow.over_period(self.phases(paced, rows, term), self._rates)

    def read(self, loops: LinearLoops, skew: float, plant_inputs: list[int], asked: frozenset[str]) -> BlockReadings:
        """Read the exact margins of all loops of the block, lifted; growth counts by control period."""
        instants = tuple(tuple(own) for own in instants_of(self._rates, self.slow.every))
        form = Lifting(
            self.slow.flown.timing.control_period, self.slow.every, instants, LOWEST, self.slow.points // COARSER
        )
        return read_lifted(loops, form, skew, plant_inputs, asked)

    @property
    def _rates(self) -> list[Rate]:
        return [Rate(self.slow.every if channel in PLACES else 1, 0) for channel in self.block.channels]

    def phases(self, paced: Paced, rows: Mask, term: Array) -> list[LinearLoops]:
        """Return the loops of the period in which the position loops step and of one in which they wait, terms closed."""
        return [with_terms(self.block, self.assembly(step, rows), term) for step in (paced.due, paced.waiting)]


@dataclass(frozen=True)
class SlowLoop:
    """One position loop of a block, whose other loops stay closed."""

    part: SlowBlock
    channel: int

    def closed(self, paced: Paced, rows: Mask, term: Array) -> LinearLoops:
        """Return the position loop over a common period; term (n, cases, terms) of the rows: they are candidates, then cases."""
        j, slow = self.part.block.channels.index(self.channel), self.part.slow
        phases = [_only(loops, j) for loops in self.part.phases(paced, rows, term)]
        return slow.over_period(phases, [Rate(slow.every, 0)])

    def read(self, loops: LinearLoops, skew: float, asked: frozenset[str]) -> BlockReadings:
        """Read the margins of closed loops; growth counts by control period."""
        slow = self.part.slow
        read = read_block(loops, slow.grid, slow.period, skew, [], asked - {MULTILOOP})
        return replace(read, modes=replace(read.modes, size=read.modes.size ** (1.0 / slow.every)))

    @property
    def period(self) -> float:
        """Period of the loop [s]."""
        return self.part.slow.period

    @property
    def own(self) -> Block:
        """The position loop alone, for who enters its readings."""
        return replace(self.part.block, channels=(self.channel,))


def _places(resting: PeriodMap, flown: PeriodMap) -> NDArray[np.intp]:
    """Return for each state of the loop that is flown the one of the loop at rest, -1 where that has none."""
    known = {name: place for place, name in enumerate(paths(resting.state))}
    return np.array([known.get(_resting_name(name), -1) for name in paths(flown.state)])


def _resting_name(name: str) -> str:
    """Return the name at rest of a state; that of a slower law holds the law's own and what the waiting takes."""
    room, part, *rest = name.split(".")
    if room != "control" or part not in POSITION_AXES:
        return name
    return ".".join([room, part, *rest[1:]]) if rest[0] == "law" else ""


def _only(loops: LinearLoops, channel: int) -> LinearLoops:
    """Return loops with the signals of one channel alone; their terms are closed."""
    k, w = loops.n_channels, loops.n_terms
    spot = channel + np.array([0, k + w, k + w + k])
    return LinearLoops(loops.a, loops.b[..., spot], loops.c[..., spot, :], loops.d[..., spot[:, None], spot], 1, 0)
