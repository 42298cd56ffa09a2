"""Margins of the loops of a plant of the user's own, for batches of gains: those of `objectives.margins.margins`, at rest."""

from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.block import EVERY
from objectives.margins.describing import DEFAULT_CASES, Case
from objectives.margins.frequency import POINTS, frequency_grid
from objectives.margins.linearise import LinearLoops
from objectives.margins.plant_period import PlantPeriod
from objectives.margins.plant_rates import LOWEST, MIDDLE, OneRate, rates_for
from objectives.margins.requirement import MarginRequirement
from objectives.margins.results import LoopResponse, Margins, joined
from objectives.margins.sheet import Sheet
from objectives.margins.structure import Block
from objectives.plant_system import PlantSystem
from plant.seeds import generator

Array = NDArray[np.float64]
# Candidates worked on at once, and gains rows that the structure is read off from.
CHUNK, PROBES = 250, 4


class PlantMargins:
    """Margins of a plant's loops at rest, as its controller flies them.

    low, high: gains rows (g,), the corners between which the structure of the loop is looked at. others: further parameters, such
    as corners of a spread, that the worst is taken over. cases, skew and points as in `MarginModel`. Raises InputError where the
    rates of channels have too long a common period; `multirate` says what margins of several rates are.
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
        self._grid, self._points = frequency_grid(self.period, points, LOWEST / self.period), points
        draws = np.array([generator(0, "margins/probes", i).uniform(size=len(low)) for i in range(PROBES)])
        self._probes = low + draws * (high - low)
        self._plants = [rates_for(period, self._probes, points) for period in self._periods]

    def as_flown(self) -> "PlantMargins":
        """Return the margins of the loops whose plant moves by the Runge-Kutta steps of flights; these here are exact."""
        flown = copy(self)
        flown._periods = [period.as_flown() for period in self._periods]  # noqa: SLF001
        flown._plants = [rates_for(period, self._probes, self._points) for period in flown._periods]  # noqa: SLF001
        return flown

    @property
    def period(self) -> float:
        """Control period [s]."""
        return self.system.timing.control_period

    @property
    def at_one_rate(self) -> bool:
        """Whether all channels step together; else blocks are known with their terms closed alone."""
        return isinstance(self._plants[0], OneRate)

    @property
    def blocks(self) -> tuple[tuple[str, ...], ...]:
        """Channels of the blocks that the loop of the nominal plant falls into."""
        return tuple(tuple(self.channels[i] for i in block.channels) for block in self._plants[0].blocks)

    def evaluate(self, gains: Array) -> Margins:
        """Return the margins (n, channels) of gains rows (n, g) in SI units, in the worst plant and case."""
        return self._evaluate(np.asarray(gains, dtype=float), EVERY)

    def limited(self, gains: Array, requirements: Sequence[MarginRequirement]) -> Array:
        """Return the values (n, requirements) of limits on margins of gains rows (n, g)."""
        asked = frozenset(field for entry in requirements for field in entry.quantity.fields)
        margins = self._evaluate(np.asarray(gains, dtype=float), asked)
        return np.stack([entry.values(margins) for entry in requirements], axis=1)

    def constants(self, gains: Array) -> Any:
        """Constants of all channels for gains rows (n, g): leaves are arrays (n, 1, 1) or numbers."""
        return self._periods[0].constants(gains)

    def open_blocks(self, gains: Array) -> list[tuple[Block, LinearLoops]]:
        """Blocks of the nominal plant under a gains row (g,) with their loops (1, ...), nonlinear terms left open.

        Of channels that step together, see `at_one_rate`.
        """
        plant = self._plants[0]
        assert isinstance(plant, OneRate), "several rates"
        return list(plant.opened(np.asarray(gains, dtype=float)[None]))

    def loop(self, gains: Array, channel: str, case: Case = MIDDLE, frequency: Array | None = None) -> LoopResponse:
        """Response of one loop of the nominal plant under a gains row (g,), at frequencies (f,) [rad/s], by default the grid."""
        w = self._grid[0, 1:] if frequency is None else np.asarray(frequency, dtype=float)
        index, plant = self.channels.index(channel), self._plants[0]
        for block, loops in plant.closed(np.asarray(gains, dtype=float)[None], (case,)):
            if index in block.channels:
                return LoopResponse(w, plant.response(block, loops, 0, block.channels.index(index), w))
        return LoopResponse(w, np.zeros(len(w), dtype=complex))

    def curves(self, gains: Array, cases: NDArray[np.intp], frequency: Array) -> NDArray[np.complex128]:
        """Loop transfer functions (n, channels, f) of the nominal plant under gains rows (n, g) at frequencies (f,) [rad/s].

        cases (n, channels): number of the amplitude in `cases` for each. A channel without a loop has zeros.
        """
        found = np.zeros((len(gains), len(self.channels), len(frequency)), dtype=complex)
        for row, own in enumerate(gains):
            for channel, case in enumerate(cases[row]):
                found[row, channel] = self.loop(own, self.channels[channel], self.cases[case], frequency).loop
        return found

    def _evaluate(self, gains: Array, asked: frozenset[str]) -> Margins:
        parts = [gains[i : i + CHUNK] for i in range(0, max(len(gains), 1), CHUNK)]
        return joined([self._read(part, asked).summed(self.skew) for part in parts])

    def _read(self, gains: Array, asked: frozenset[str]) -> Sheet:
        sheet = Sheet(len(gains), len(self._periods), self.cases, self.period, asked, self.channels)
        everyone, cases = np.ones(len(gains), dtype=bool), list(range(len(self.cases)))
        if not len(gains):
            return sheet
        for i, plant in enumerate(self._plants):
            for block, closed in plant.closed(gains, self.cases):
                sheet.sweep(block)
                inputs = [j for j, channel in enumerate(block.channels) if self._is_input(channel)]
                sheet.enter(i, block, everyone, cases, plant.read(block, closed, self.skew, inputs, asked))
        return sheet

    def _is_input(self, channel: int) -> bool:
        plan = self.system.plan
        return not plan.cascades(plan.channels[channel])
