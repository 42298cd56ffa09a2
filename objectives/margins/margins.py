"""Margins of the loop that flies, for batches of gains.

Linearised about its trim, with the nonlinear terms closed at each amplitude, split into blocks, and read off block by block.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.assembly import Assembly
from objectives.margins.block import EVERY, MULTILOOP, read_block
from objectives.margins.closing import close_terms
from objectives.margins.describing import DEFAULT_CASES, Case, constants_of, term_gains
from objectives.margins.frequency import POINTS, frequency_grid
from objectives.margins.linearise import LinearLoops, Plant, Surroundings
from objectives.margins.period import CHANNELS, Term, period_map
from objectives.margins.requirement import MarginRequirement
from objectives.margins.results import LoopResponse, Margins, Realisation, joined
from objectives.margins.sheet import Sheet
from objectives.margins.slow_position import Paced, SlowBlock, SlowLoop, SlowPosition
from objectives.margins.structure import Block, blocks_of, coordinates, with_images, with_terms
from objectives.margins.trim import Trim, TrimPoint, balanced_plant, find_trim, setting_of
from plant.cascade import ATTITUDE_AXES, Cascade
from plant.errors import InputError
from plant.fittings import fittings
from plant.gains import gain_addresses
from plant.loop import Timing
from plant.nominal import Nominal, vary
from plant.scenarios import Spread
from plant.seeds import generator
from plant.vehicle import Vehicle

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Gains rows that the structure is read off from, and the amplitude at which terms are closed for that and to find a trim.
# Of laws with filters, some of which a probe may leave out, there are more.
PROBES, FILTER_PROBES, MIDDLE = 4, 16, (Case(0.1),)
# Candidates worked on at once: off hover, where all channels are one block, a hundred with six cases take 0.5 GB.
CHUNK = 100
# The same without the margin of all loops at once, which is what takes the room, and candidates from which on it pays to look at
# the amplitudes that most often decide before the others.
LARGE_CHUNK, MANY = 250, 16
SMALL = Case(0.0)
NOT_STEADY = "no steady flight is found under any of a few gains from their search ranges"
# Channels that are inputs of the plant itself; x and y are demands inside the controller.
PLANT_INPUTS = tuple(CHANNELS.index(name) for name in ("z", *ATTITUDE_AXES))


def spread_corners(vehicle: Vehicle, spread: Spread) -> tuple[Vehicle, ...]:
    """The vehicles at the corners of a spread of mass, inertia, thrust and lag: 2 to the number of those that are spread.

    The centre of mass stays in the middle: off it, thrust turns the body, but no loop's own margins change.
    """
    ends = [(middle - width, middle + width) if width > 0.0 else (middle,) for middle, width in spread.factors]
    return tuple(vary(vehicle, *corner) for corner in product(*ends))


@dataclass(frozen=True)
class Scope:
    """The part of an evaluation that somebody wants: fields of `Margins`, and of which channels.

    decisive: channels any of which, not stable, decides all that is wanted.
    """

    asked: frozenset[str]
    channels: frozenset[int]
    decisive: frozenset[int]


ALL_OF_IT = Scope(EVERY, frozenset(range(len(CHANNELS))), frozenset())


def scope_of(requirements: Sequence[MarginRequirement]) -> Scope:
    """Return what requirements need."""
    asked = frozenset(field for entry in requirements for field in entry.quantity.fields)
    channels = [
        frozenset(CHANNELS.index(axis) for axis in (CHANNELS if entry.quantity.whole else entry.axes))
        for entry in requirements
    ]
    return Scope(asked, frozenset().union(*channels), frozenset.intersection(*channels))


@dataclass(frozen=True)
class _Situation:
    """A vehicle in its trim, as rows of numbers, and the blocks that its loop falls into."""

    setting: Surroundings
    plant: Plant
    blocks: tuple[Block, ...]
    assemblies: tuple[Assembly, ...]
    slow: tuple[SlowBlock, ...] = ()

    def parts(self, channels: frozenset[int]) -> list[tuple[Block, Assembly]]:
        """Return the blocks of some channels, and those of which they may be images, with their assemblies, small ones first."""
        asked = [not channels.isdisjoint(block.channels) for block in self.blocks]
        originals = {block.image for block, here in zip(self.blocks, asked, strict=True) if here}
        pairs = enumerate(zip(self.blocks, self.assemblies, strict=True))
        return sorted((pair for i, pair in pairs if asked[i] or i in originals), key=lambda pair: len(pair[0].into))

    def slow_in(self, block: Block) -> list[SlowLoop]:
        """Return the position loops of a block that wait."""
        return [loop for part in self.slow for loop in part.loops if loop.channel in block.channels]

    def is_beside_slow(self, block: Block) -> bool:
        """Return True if all channels of a block are in blocks with a position loop that waits."""
        return set(block.channels) <= {channel for part in self.slow for channel in part.block.channels}


class MarginModel:
    """Margins of a cascade on a vehicle in a trim, as the controller with this `nominal` and timing flies it.

    Position loops that step less often than the attitude loops have the margins of `slow_position`, and so have the attitude
    loops inside them, but in `limited`, where a search asks for thousands.

    exact: in `limited` too, at 0.1 s a candidate; otherwise attitude loops are read there with the position loops around them
    taken as if they stepped as often, which is off by up to 2 %.

    others: further vehicles, such as `spread_corners`, that the worst is taken over. cases: amplitudes of the nonlinear terms
    that it is taken over; loops without such terms ignore them. skew: sigma of the disk margins. points: of the frequency grid.
    Raises InputError where there is no steady flight.
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
        self._exact = exact
        self.trim = trim or Trim()
        self.vehicles = (vehicle, *others)
        self.skew = skew
        fitted = fittings(vehicle, timing.control_period, nominal.harmonics)
        self._map = period_map(cascade.at_one_rate, timing, fitted)
        self._slow = SlowPosition(cascade, timing, fitted, points) if cascade.position_every > 1 else None
        self.cases = tuple(cases) if self._map.terms else (Case(0.0),)
        self._grid = frequency_grid(timing.control_period, points)
        addresses = gain_addresses(cascade)
        self._columns = {axis: [gain.column for gain in addresses if gain.axis == axis] for axis in CHANNELS}
        self._situations = [self._situation(nominal, each) for each in self.vehicles]

    @property
    def timing(self) -> Timing:
        """Control period and plant step."""
        return self._map.timing

    @property
    def period(self) -> float:
        """Control period [s]."""
        return self.timing.control_period

    @property
    def flown(self) -> Cascade:
        """The cascade with the rates that it flies at."""
        return self.cascade if self._slow is None else self._slow.flown.cascade

    @property
    def cascade(self) -> Cascade:
        """The cascade whose loops are judged."""
        return self._map.cascade

    @property
    def terms(self) -> tuple[Term, ...]:
        """Nonlinear terms of the cascade's laws."""
        return self._map.terms

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of all channels."""
        return CHANNELS

    @property
    def blocks(self) -> tuple[tuple[str, ...], ...]:
        """Channels of the blocks that the first vehicle's loop falls into."""
        return tuple(tuple(CHANNELS[i] for i in block.channels) for block in self._situations[0].blocks)

    def evaluate(self, gains: Array) -> Margins:
        """Return the margins of candidates, in the worst vehicle and case.

        Args:
            gains: One row for each candidate (n, gains).

        Returns:
            Margins (n, channels) in SI units: factors, rad, s; see `objectives.margins.quantities`.
        """
        return joined([self._read(part, ALL_OF_IT, exact=True).summed(self.skew) for part in _parts(gains, CHUNK)])

    def limited(self, gains: Array, requirements: Sequence[MarginRequirement]) -> Array:
        """Return the values (n, requirements) of limits on margins, those of `evaluate`, working out nothing else.

        gains (n, gains). Where a loop that all of them ask for is not stable, the candidate's other loops are not looked at.
        """
        scope = scope_of(requirements)
        return np.concatenate(
            [
                np.stack([entry.values(margins) for entry in requirements], axis=1)
                for part in _parts(gains, CHUNK if scope.asked >= {MULTILOOP} else LARGE_CHUNK)
                for margins in [self._read(part, scope, self._exact).summed(self.skew)]
            ],
            axis=0,
        )

    def _read(self, gains: Array, scope: Scope, exact: bool) -> Sheet:
        sheet = Sheet(len(gains), len(self.vehicles), self.cases, self.period, scope.asked)
        if not len(gains):
            return sheet
        term, undecided = self._term_gains(gains, self.cases), np.ones(len(gains), dtype=bool)
        for i, situation in enumerate(self._situations):
            point = self._trimmed(situation.setting, situation.plant, gains)
            paced = self._paced(situation.setting, situation.plant, gains) if situation.slow else None
            steady = point.steady if paced is None else point.steady & paced.steady
            for block, assembly in situation.parts(scope.channels):
                sheet.sweep(block)
                if exact and situation.is_beside_slow(block):
                    continue
                rows = steady & undecided
                if block.image is not None:
                    original = situation.blocks[block.image]
                    alike = self._alike(gains, block, original)
                    sheet.copy(i, block, alike, original)
                    rows &= ~alike
                for cases in self._rounds(len(gains), block, scope):
                    if rows.any():
                        closed = with_terms(block, assembly(point.step, rows), term[rows][:, cases])
                        inputs = [j for j, channel in enumerate(block.channels) if channel in PLANT_INPUTS]
                        read = read_block(closed, self._grid, self.period, self.skew, inputs, scope.asked)
                        sheet.enter(i, block, rows, cases, read)
                        stable = read.modes.stable
                        for slow in situation.slow_in(block):
                            assert paced is not None
                            own = slow.read(slow.closed(paced, rows, term[rows][:, cases]), self.skew, scope.asked)
                            sheet.destabilise(i, block, rows, cases, own.modes.stable)
                            sheet.enter(i, slow.own, rows, cases, own)
                            stable = stable & own.modes.stable
                        if not scope.decisive.isdisjoint(block.channels):
                            stable = stable.reshape(np.count_nonzero(rows), -1).all(axis=1)
                            undecided[np.nonzero(rows)[0][~stable]] = False
                            rows &= undecided
            for part in situation.slow if exact else ():
                if paced is not None and steady.any() and not scope.channels.isdisjoint(part.block.channels):
                    loops = part.lifted(paced, steady, term[steady])
                    inputs = [j for j, channel in enumerate(part.block.channels) if channel in PLANT_INPUTS]
                    read = part.read(loops, self.skew, inputs, scope.asked)
                    sheet.enter(i, part.block, steady, list(range(len(self.cases))), read)
            sheet.discard(i, ~steady)
        return sheet

    def _rounds(self, n: int, block: Block, scope: Scope) -> list[list[int]]:
        """Cases in the order in which n candidates are looked at: where one may decide, those that most often do first."""
        cases = list(range(len(self.cases)))
        if n < MANY or not block.terms or scope.decisive.isdisjoint(block.channels) or len(cases) < 3:
            return [cases]
        return [[cases[0], cases[-1]], cases[1:-1]]

    def constants(self, gains: Array) -> Any:
        """Constants of all axes for gains rows (n, g): leaves are arrays (n, 1, 1) or numbers."""
        return constants_of(self._map.cascade, gains, self.period)

    def open_blocks(self, gains: Array, vehicle: int = 0) -> list[tuple[Block, LinearLoops]]:
        """Blocks under a gains row (g,) with their loops (1, ...), nonlinear terms left open."""
        situation = self._situations[vehicle]
        row = np.asarray(gains, dtype=float)[None]
        loops = self._trimmed(situation.setting, situation.plant, row).step.loops
        return [(block, block.part(loops)) for block in situation.blocks]

    def realisation(self, gains: Array, channel: str, case: Case = SMALL, vehicle: int = 0) -> Realisation:
        """State space of one closed loop under a gains row (g,); empty where a channel has no loop."""
        index, row = CHANNELS.index(channel), np.asarray(gains, dtype=float)[None]
        situation = self._situations[vehicle]
        block = next((block for block in situation.blocks if index in block.channels), None)
        if block is None:
            return Realisation(np.zeros((0, 0)), np.zeros(0), np.zeros(0), self.period)
        if slow := next(iter(slow for slow in situation.slow_in(block) if slow.channel == index), None):
            return self._slow_realisation(situation, slow, row, case)
        point = self._trimmed(situation.setting, situation.plant, row)
        loops = _closed(block, point.step.loops, self._term_gains(row, (case,)))
        j = block.channels.index(index)
        return Realisation(loops.a[0], loops.b[0, :, j], loops.c[0, j], self.period)

    def loop(
        self, gains: Array, channel: str, case: Case = SMALL, frequency: Array | None = None, vehicle: int = 0
    ) -> LoopResponse:
        """Response of one loop under a gains row (g,), at frequencies (f,) [rad/s], by default the grid."""
        w = self._grid[0, 1:] if frequency is None else np.asarray(frequency, dtype=float)
        return self.realisation(gains, channel, case, vehicle).response(w)

    def _paced(self, setting: Surroundings, plant: Plant, gains: Array) -> Paced:
        """Return both kinds of control period of position loops that wait."""
        assert self._slow is not None
        return self._slow.paced(gains, setting, plant, self._term_gains(gains, MIDDLE)[:, 0])

    def _slow_realisation(self, situation: _Situation, slow: SlowLoop, row: Array, case: Case) -> Realisation:
        """Return the state space of a position loop that waits; it is sampled at its own period."""
        paced = self._paced(situation.setting, situation.plant, row)
        loops = slow.closed(paced, np.ones(1, dtype=bool), self._term_gains(row, (case,)))
        return Realisation(loops.a[0], loops.b[0, :, 0], loops.c[0, 0], slow.period)

    def curves(self, gains: Array, cases: NDArray[np.intp], frequency: Array) -> NDArray[np.complex128]:
        """Loop transfer functions (n, channels, f) of the first vehicle under gains rows (n, g) at frequencies (f,) [rad/s].

        cases (n, channels): number of the amplitude in `cases` for each. A channel without a loop has zeros. A loop that has the
        gains and the dynamics of another has its curve too.
        """
        situation, terms = self._situations[0], self._term_gains(gains, self.cases)
        loops = self._trimmed(situation.setting, situation.plant, gains).step.loops
        found = np.zeros((len(gains), len(CHANNELS), len(frequency)), dtype=complex)
        for block in situation.blocks:
            original = block if block.image is None else situation.blocks[block.image]
            alike = self._alike(gains, block, original) & (original is not block)
            for j, (channel, like) in enumerate(zip(block.channels, original.channels, strict=True)):
                same = alike & (cases[:, channel] == cases[:, like])
                found[same, channel] = found[same, like]
                rows = np.flatnonzero(~same)
                closed = _closed(block, loops.of(~same), terms[rows, cases[rows, channel]][:, None])
                for row, a, b, c in zip(rows, closed.a, closed.b[:, :, j], closed.c[:, j], strict=True):
                    found[row, channel] = Realisation(a, b, c, self.period).response(frequency).loop
        for slow in [loop for part in situation.slow for loop in part.loops]:
            for row, own in enumerate(gains):
                case = self.cases[cases[row, slow.channel]]
                found[row, slow.channel] = self.loop(own, CHANNELS[slow.channel], case, frequency).loop
        return found

    def _situation(self, nominal: Nominal, vehicle: Vehicle) -> _Situation:
        setting = setting_of(self.trim, nominal, vehicle)
        plant = balanced_plant(self._map, self.trim, nominal, setting)
        gains = self._probes()
        point = self._trimmed(setting, plant, gains)
        if not point.steady.any():
            raise InputError(NOT_STEADY, key="trim")
        gains = gains[point.steady]
        closed = close_terms(point.step.loops.of(point.steady), self._term_gains(gains, MIDDLE)[:, 0])
        blocks = blocks_of(closed, coordinates(self._map, nominal.vehicle, point.state[point.steady][0]))
        # The same probes with the gains of x in y and of pitch in roll.
        for axis, like in (("y", "x"), ("roll", "pitch")):
            gains[:, self._columns[axis]] = gains[:, self._columns[like]]
        term, loops = self._term_gains(gains, MIDDLE), self._trimmed(setting, plant, gains).step.loops
        blocks = with_images(blocks, tuple(_closed(block, loops, term) for block in blocks))
        decide = self._map.decide
        assemblies = [Assembly(block, plant, len(self.terms), decide.where, decide.shape) for block in blocks]
        slow = () if self._slow is None else self._slow_blocks(nominal, setting, plant)
        return _Situation(setting, plant, blocks, tuple(assemblies), slow)

    def _slow_blocks(self, nominal: Nominal, setting: Surroundings, plant: Plant) -> tuple[SlowBlock, ...]:
        """Return the blocks with position loops that wait."""
        assert self._slow is not None
        gains = self._probes()
        paced = self._paced(setting, plant, gains)
        if not paced.steady.any():
            raise InputError(NOT_STEADY, key="trim")
        blocks = self._slow.blocks(paced, self._term_gains(gains[paced.steady], MIDDLE)[:, 0], nominal)
        return tuple(self._slow.loops(block, plant) for block in blocks)

    def _probes(self) -> Array:
        """Gains rows spread over the search ranges."""
        spans = [gain.span for gain in gain_addresses(self._map.cascade)]
        low, high = np.array([span.low for span in spans]), np.array([span.high for span in spans])
        filtered = any(gain.info.cutoff for gain in gain_addresses(self._map.cascade))
        count = FILTER_PROBES if filtered else PROBES
        draws = [generator(0, "margins/probes", i).uniform(size=len(spans)) for i in range(count)]
        return low + np.array(draws) * (high - low)

    def _alike(self, gains: Array, block: Block, original: Block) -> Mask:
        """Candidates whose gains in the channels of two blocks are the same."""
        same = np.ones(len(gains), dtype=bool)
        for one, other in zip(block.channels, original.channels, strict=True):
            mine, its = (gains[:, self._columns[CHANNELS[channel]]] for channel in (one, other))
            same &= np.all(mine == its, axis=1)
        return same

    def _term_gains(self, gains: Array, cases: Sequence[Case]) -> Array:
        return term_gains(self._map.terms, self._map.cascade, gains, self.period, tuple(cases))

    def _trimmed(self, setting: Surroundings, plant: Plant, gains: Array) -> TrimPoint:
        return find_trim(self._map, gains, setting, plant, lambda: self._term_gains(gains, MIDDLE)[:, 0])


def _parts(gains: Array, size: int) -> list[Array]:
    """Return gains rows in batches of some size, at least one."""
    gains = np.asarray(gains, dtype=float)
    return [gains[i : i + size] for i in range(0, max(len(gains), 1), size)]


def _closed(block: Block, loops: LinearLoops, term: Array) -> LinearLoops:
    """The block's loops, closed with term gains (n, cases, terms): rows are candidates, then cases; without terms, candidates."""
    return with_terms(block, block.part(loops), term)
