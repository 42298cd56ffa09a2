"""Margins of the loops of a plant of the user's own: linearized where it rests, for `loop_margins` to read."""

from collections.abc import Sequence
from copy import copy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.closing import close_terms
from objectives.margins.describing import DEFAULT_CASES, Case
from objectives.margins.frequency import POINTS
from objectives.margins.linearise import LinearLoops
from objectives.margins.loop_margins import LoopMargins, TrimmedLoops, gains_of_terms
from objectives.margins.plant_period import PlantPeriod
from objectives.margins.results import Margins
from objectives.margins.structure import blocks_of
from objectives.plant_system import PlantSystem
from plant.seeds import generator

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
# Gains rows that the structure is read off from.
PROBES = 4
# Loops are drawn from a share of Nyquist or of the slowest crossover on, and compared at shares of Nyquist.
DRAWN_FROM, BELOW_CROSSOVER, PROBED = 1e-4, 0.1, np.array([4e-4, 2.5e-3, 0.014, 0.076])


class PlantMargins(LoopMargins):
    """Margins of a plant's loops at rest, as its controller flies them.

    Raises InputError where the rates of channels have too long a common period; see `multirate` for margins of several rates.

    Args:
        system: The plant and its loops.
        low: Gains row (g,), with `high` the corners between which the structure of the loop is looked at.
        high: Gains row (g,).
        others: Further parameters, such as corners of a spread, that the worst is taken over.
        cases: Amplitudes of the nonlinear terms that it is taken over; loops without such terms ignore them.
        skew: Sigma of the disk margins.
        points: Points of the frequency grid.
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
        draws = np.array([generator(0, "margins/probes", i).uniform(size=len(low)) for i in range(PROBES)])
        # The longest dead time of a law's model, at its upper end, has states that shorter ones do not use.
        self._probes = np.concatenate([low + draws * (high - low), np.asarray(high, dtype=float)[None]])
        self._periods = [PlantPeriod(system, parameters) for parameters in (system.parameters, *others)]
        rest = [RestLinearization(period, self._probes) for period in self._periods]
        super().__init__(self._periods[0], rest, cases, skew, points)

    def as_flown(self) -> "PlantMargins":
        """Return the margins with the plant moved by flights' Runge-Kutta steps.

        The loops here are exact.
        """
        flown = copy(self)
        flown._linearizations = [RestLinearization(period.as_flown(), self._probes) for period in self._periods]
        return flown

    def probe_frequencies(self) -> Array:
        """Return the frequencies [rad/s] at which loops are compared."""
        return PROBED * np.pi / self.control_period

    def figure_frequencies(self, margins: Margins, points: int) -> Array:
        """Return the frequencies (points,) [rad/s] for drawing loops with these margins.

        They go up to Nyquist.
        """
        nyquist, crossover = np.pi / self.control_period, margins.crossover.value
        slowest = crossover[np.isfinite(crossover) & (crossover > 0.0)].min(initial=nyquist)
        return np.geomspace(min(DRAWN_FROM * nyquist, BELOW_CROSSOVER * float(slowest)), nyquist, points)


class RestLinearization:
    """Loops of a plant at rest, split into blocks under probes.

    probes: gains rows (p, g).
    """

    def __init__(self, period: PlantPeriod, probes: Array) -> None:
        self._period, self.rates = period, period.rates
        term = gains_of_terms(period, probes)[:, 0]
        closed = LinearLoops.stacked([close_terms(loops, term) for loops in period.phases(probes)])
        self.blocks = blocks_of(closed, np.eye(closed.a.shape[-1]))

    def at(self, gains: Array) -> TrimmedLoops:
        """Linearize the loops under gains rows (n, g).

        A plant rests under any gains.
        """
        phases = self._period.phases(gains)
        every_vehicle = np.ones(len(phases[0].a), dtype=bool)
        return TrimmedLoops(every_vehicle, lambda block, rows: [block.part(loops.of(rows)) for loops in phases])
