"""Margins of the loops of a plant of the user's own, for batches of gains: those of `objectives.margins.margins`, at rest."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.block import EVERY, read_block
from objectives.margins.describing import DEFAULT_CASES, Case, term_gains_of
from objectives.margins.frequency import POINTS, frequency_grid
from objectives.margins.linearise import LinearLoops, close_terms
from objectives.margins.plant_period import PlantPeriod
from objectives.margins.requirement import MarginRequirement
from objectives.margins.results import LoopResponse, Margins, Realisation, joined
from objectives.margins.sheet import Sheet
from objectives.margins.structure import Block, blocks_of, with_terms
from objectives.plant_system import PlantSystem
from plant.seeds import generator

Array = NDArray[np.float64]
# Candidates worked on at once, and gains rows that the structure is read off from.
CHUNK, PROBES = 250, 4
MIDDLE = Case(0.1)
# Lowest frequency that is looked at [rad in a control period]: a plant of hours is seen like one of milliseconds.
LOWEST = 1e-5


class PlantMargins:
    """Margins of a plant's loops at rest, as its controller flies them.

    low, high: gains rows (g,), the corners between which the structure of the loop is looked at. others: further parameters, such
    as corners of a spread, that the worst is taken over. cases, skew and points as in `MarginModel`.
    """

    def __init__(
        self,
        system: PlantSystem,
        low: Array,
        high: Array,
        *,
        others: Sequence[Any] = (),
        cases: Sequence[Case] = DEFAULT_CASES,
        skew: float = 0.0,
        points: int = POINTS,
    ) -> None:
        self.system, self.skew = system, skew
        self._periods = [PlantPeriod(system, parameters) for parameters in (system.parameters, *others)]
        self.terms = self._periods[0].terms
        self.cases = tuple(cases) if self.terms else (Case(0.0),)
        self.channels = system.plan.names
        self._grid = frequency_grid(self.period, points, LOWEST / self.period)
        draws = np.array([generator(0, "margins/probes", i).uniform(size=len(low)) for i in range(PROBES)])
        self._blocks = [self._structure(period, low + draws * (high - low)) for period in self._periods]

    @property
    def period(self) -> float:
        """Control period [s]."""
        return self.system.timing.control_period

    @property
    def blocks(self) -> tuple[tuple[str, ...], ...]:
        """Channels of the blocks that the loop of the nominal plant falls into."""
        return tuple(tuple(self.channels[i] for i in block.channels) for block in self._blocks[0])

    def evaluate(self, gains: Array) -> Margins:
        """Return the margins (n, channels) of gains rows (n, g) in SI units, in the worst plant and case."""
        return self._evaluate(np.asarray(gains, dtype=float), EVERY)

    def limited(self, gains: Array, requirements: Sequence[MarginRequirement]) -> Array:
        """Return the values (n, requirements) of limits on margins of gains rows (n, g)."""
        asked = frozenset(field for entry in requirements for field in entry.quantity.fields)
        margins = self._evaluate(np.asarray(gains, dtype=float), asked)
        return np.stack([entry.values(margins) for entry in requirements], axis=1)

    def realisation(self, gains: Array, channel: str, case: Case = MIDDLE, plant: int = 0) -> Realisation:
        """State space of one closed loop, from the signal injected to the command, under a gains row (g,)."""
        index = self.channels.index(channel)
        block = next(block for block in self._blocks[plant] if index in block.channels)
        row = np.asarray(gains, dtype=float)[None]
        loops = self._closed(self._periods[plant], block, row, (case,))
        j = block.channels.index(index)
        return Realisation(loops.a[0], loops.b[0, :, j], loops.c[0, j], self.period)

    def loop(self, gains: Array, channel: str, case: Case = MIDDLE, frequency: Array | None = None) -> LoopResponse:
        """Response of one loop under a gains row (g,), at frequencies (f,) [rad/s], by default the grid."""
        w = self._grid[0, 1:] if frequency is None else np.asarray(frequency, dtype=float)
        return self.realisation(gains, channel, case).response(w)

    def curves(self, gains: Array, cases: NDArray[np.intp], frequency: Array) -> NDArray[np.complex128]:
        """Loop transfer functions (n, channels, f) of the nominal plant under gains rows (n, g) at frequencies (f,) [rad/s].

        cases (n, channels): number of the amplitude in `cases` for each. A channel without a loop has zeros.
        """
        period, found = self._periods[0], np.zeros((len(gains), len(self.channels), len(frequency)), dtype=complex)
        loops, terms = period.loops(gains), self._term_gains(period, gains, self.cases)
        for block in self._blocks[0]:
            part = block.part(loops)
            for j, channel in enumerate(block.channels):
                chosen = terms[np.arange(len(gains)), cases[:, channel]][:, None]
                closed = with_terms(block, part, chosen)
                for row in range(len(gains)):
                    own = Realisation(closed.a[row], closed.b[row, :, j], closed.c[row, j], self.period)
                    found[row, channel] = own.response(frequency).loop
        return found

    def _evaluate(self, gains: Array, asked: frozenset[str]) -> Margins:
        parts = [gains[i : i + CHUNK] for i in range(0, max(len(gains), 1), CHUNK)]
        return joined([self._read(part, asked).summed(self.skew) for part in parts])

    def _read(self, gains: Array, asked: frozenset[str]) -> Sheet:
        sheet = Sheet(len(gains), len(self._periods), self.cases, self.period, asked, self.channels)
        everyone, cases = np.ones(len(gains), dtype=bool), list(range(len(self.cases)))
        if not len(gains):
            return sheet
        for i, (period, blocks) in enumerate(zip(self._periods, self._blocks, strict=True)):
            loops = period.loops(gains)
            term = self._term_gains(period, gains, self.cases)
            for block in blocks:
                sheet.sweep(block)
                closed = with_terms(block, block.part(loops), term)
                inputs = [j for j, channel in enumerate(block.channels) if self._is_input(channel)]
                sheet.enter(
                    i, block, everyone, cases, read_block(closed, self._grid, self.period, self.skew, inputs, asked)
                )
        return sheet

    def _is_input(self, channel: int) -> bool:
        plan = self.system.plan
        return not plan.cascades(plan.channels[channel])

    def _structure(self, period: PlantPeriod, gains: Array) -> tuple[Block, ...]:
        term = self._term_gains(period, gains, (MIDDLE,))
        loops = period.loops(gains)
        return blocks_of(close_terms(loops, term[:, 0]), np.eye(loops.a.shape[-1]))

    def _closed(self, period: PlantPeriod, block: Block, gains: Array, cases: tuple[Case, ...]) -> LinearLoops:
        return with_terms(block, block.part(period.loops(gains)), self._term_gains(period, gains, cases))

    def _term_gains(self, period: PlantPeriod, gains: Array, cases: tuple[Case, ...]) -> Array:
        return term_gains_of(period.terms, period.constants(gains), len(gains), cases)
