"""Linearized loops of one gains row on vehicles besides the nominal one.

`MarginModel` gives the worst over vehicles; maps and responses need each one by itself, and the state behind it. The controller
keeps its nominal, only what flies is exchanged. Which states belong together does not depend on the numbers of a vehicle, so the
blocks are determined once, on the nominal one.
"""

from collections.abc import Sequence

import numpy as np

from objectives.margins.block import EVERY, modes_of_loops, read_block
from objectives.margins.closing import close_terms
from objectives.margins.describing import DEFAULT_CASES, Case
from objectives.margins.frequency import frequency_grid
from objectives.margins.linearise import LinearLoops
from objectives.margins.loop_margins import gains_of_terms
from objectives.margins.period import CHANNELS, PeriodMap
from objectives.margins.results import Margins
from objectives.margins.sheet import WorstCaseAccumulator
from objectives.margins.structure import Block, blocks_of, coordinates, with_terms
from objectives.margins.trim import Trim, TrimPoint, balanced_plant, find_trim, setting_of
from plant.errors import InputError
from plant.loop import Timing
from plant.quadrotor.features import vehicle_features
from plant.quadrotor.nominal import nominal
from plant.quadrotor.vehicle import Vehicle
from tuner.gains import Controller

Array = np.ndarray

# Factors of the gains that the structure is read off.
PROBES = (1.0, 0.83, 1.21)


class Linear:
    """The loop of a controller in a trim; raises InputError where its nominal vehicle has no steady flight there."""

    def __init__(self, controller: Controller, trim: Trim) -> None:
        self.trim = trim
        self.control_period = controller.control_period
        self.nominal = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
        timing = Timing(controller.control_period, controller.plant_step)
        self._map = PeriodMap(
            controller.cascade.at_one_rate,
            timing,
            vehicle_features(controller.airframe.vehicle, self.control_period, self.nominal.harmonics),
        )
        self._row = np.array([controller.gains])
        self.cases = DEFAULT_CASES if self._map.terms else (Case(0.0),)
        self._grid = frequency_grid(self.control_period)
        self._term = gains_of_terms(self._map, self._row, self.cases)
        probes = self._row * np.array(PROBES)[:, None]
        point = self._trimmed(controller.airframe.vehicle, probes)
        closed = close_terms(point.step.loops, gains_of_terms(self._map, probes)[:, 0])
        self.blocks = blocks_of(closed, coordinates(self._map, self.nominal.vehicle, point.state[0]))

    def judge(self, vehicles: Sequence[Vehicle]) -> list[Margins | None]:
        """Return the margins (1, channels) of each vehicle in the worst of all amplitudes; None without steady flight."""
        points = [self._trimmed_or_none(vehicle) for vehicle in vehicles]
        steady = [point for point in points if point is not None]
        if not steady:
            return [None] * len(points)
        margins = self._margins(LinearLoops.stacked([point.step.loops for point in steady]))
        rows = iter(range(len(steady)))
        return [None if point is None else margins.of(next(rows)) for point in points]

    def closed(self, channel: str) -> tuple[LinearLoops, int, Array]:
        """Return a channel's block, its index there, and the block's stability (cases,).

        On the nominal vehicle. Its terms are closed at each of `cases`; a block without terms is a batch of one.
        """
        index = CHANNELS.index(channel)
        block = next(block for block in self.blocks if index in block.channels)
        part = self._part(block, self._trimmed(self.nominal.vehicle, self._row).step.loops)
        return part, block.channels.index(index), modes_of_loops(part).stable

    def _margins(self, loops: LinearLoops) -> Margins:
        n = len(loops.a)
        sheet, everyone = WorstCaseAccumulator(n, 1, self.cases, self.control_period, EVERY), np.ones(n, dtype=bool)
        for block in self.blocks:
            read = read_block(self._part(block, loops), self._grid, self.control_period, 0.0, [])
            sheet.update(0, block, everyone, list(range(len(self.cases))), read)
        return sheet.summed(0.0)

    def _part(self, block: Block, loops: LinearLoops) -> LinearLoops:
        return with_terms(block, block.part(loops), np.repeat(self._term, len(loops.a), axis=0))

    def _trimmed(self, vehicle: Vehicle, rows: Array) -> TrimPoint:
        setting = setting_of(self.trim, self.nominal, vehicle)
        plant = balanced_plant(self._map, self.trim, self.nominal, setting)
        return find_trim(self._map, rows, setting, plant, lambda: gains_of_terms(self._map, rows)[:, 0])

    def _trimmed_or_none(self, vehicle: Vehicle) -> TrimPoint | None:
        try:
            point = self._trimmed(vehicle, self._row)
        except InputError:
            return None
        return point if point.steady.all() else None
