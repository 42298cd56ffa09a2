"""The linearised loop under one gains row on vehicles that differ from what its controller takes them for.

`MarginModel` gives the worst over vehicles; maps and responses need each one by itself, and the state behind it. The controller
keeps its nominal, only what flies is exchanged. Which states belong together does not depend on the numbers of a vehicle, so the
blocks are found once, on the nominal one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from objectives.margins.block import BlockReadings, modes_of_loops, read_block
from objectives.margins.closing import close_terms
from objectives.margins.describing import DEFAULT_CASES, Case, term_gains
from objectives.margins.frequency import frequency_grid
from objectives.margins.linearise import LinearLoops
from objectives.margins.period import CHANNELS, PeriodMap
from objectives.margins.quantities import LOOP_QUANTITIES
from objectives.margins.structure import Block, blocks_of, coordinates
from objectives.margins.trim import Trim, TrimPoint, balanced_plant, find_trim, setting_of
from plant.errors import InputError
from plant.fittings import fittings
from plant.loop import Timing
from plant.nominal import nominal
from plant.vehicle import Vehicle
from tuner.gains import Controller

Array = np.ndarray

# Amplitude at which terms are closed to find a trim and the structure, and factors of the gains that the structure is read off.
MIDDLE = (Case(0.1),)
PROBES = (1.0, 0.83, 1.21)


@dataclass(frozen=True)
class Judged:
    """One vehicle: stable, growth [1/s] and quantities of `objectives.margins.results`, each (channels,) in their worst case."""

    stable: Array
    growth: Array
    quantities: dict[str, Array]


class Linear:
    """The loop of a controller in a trim; raises InputError where its nominal vehicle has no steady flight there."""

    def __init__(self, controller: Controller, trim: Trim) -> None:
        self.trim = trim
        self.period = controller.control_period
        self.nominal = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
        timing = Timing(controller.control_period, controller.plant_step)
        self._map = PeriodMap(
            controller.cascade.at_one_rate,
            timing,
            fittings(controller.airframe.vehicle, self.period, self.nominal.harmonics),
        )
        self._row = np.array([controller.gains])
        self.cases = DEFAULT_CASES if self._map.terms else (Case(0.0),)
        self._grid = frequency_grid(self.period)
        self._term = self._gains_of_terms(self._row, self.cases)
        probes = self._row * np.array(PROBES)[:, None]
        point = self._trimmed(controller.airframe.vehicle, probes)
        closed = close_terms(point.step.loops, self._gains_of_terms(probes, MIDDLE)[:, 0])
        self.blocks = blocks_of(closed, coordinates(self._map, self.nominal.vehicle, point.state[0]))

    def judge(self, vehicles: Sequence[Vehicle]) -> list[Judged | None]:
        """Judge vehicles, in the worst of all amplitudes; None where no steady flight of one is found."""
        points = [self._trimmed_or_none(vehicle) for vehicle in vehicles]
        steady = [point for point in points if point is not None]
        if not steady:
            return [None] * len(points)
        judged = iter(self._judged(stacked([point.step.loops for point in steady])))
        return [None if point is None else next(judged) for point in points]

    def closed(self, channel: str) -> tuple[LinearLoops, int, Array]:
        """Return the block of a channel on the nominal vehicle, the channel's place in it, and whether it is stable (cases,).

        Its terms are closed at each of `cases`; a block without terms is a batch of one.
        """
        index = CHANNELS.index(channel)
        block = next(block for block in self.blocks if index in block.channels)
        part = self._part(block, self._trimmed(self.nominal.vehicle, self._row).step.loops)
        return part, block.channels.index(index), modes_of_loops(part).stable

    def _judged(self, loops: LinearLoops) -> list[Judged]:
        n, worst = len(loops.a), _Worst(len(loops.a))
        for block in self.blocks:
            read = read_block(self._part(block, loops), self._grid, self.period, 0.0, [])
            worst.enter(block, read, self.period)
        return [worst.of(i) for i in range(n)]

    def _part(self, block: Block, loops: LinearLoops) -> LinearLoops:
        part, term = block.part(loops), self._term[:, :, list(block.terms)]
        return close_terms(part.expanded(), np.repeat(term, len(loops.a), axis=0)).flattened() if block.terms else part

    def _gains_of_terms(self, rows: Array, cases: tuple[Case, ...]) -> Array:
        return term_gains(self._map.terms, self._map.cascade, rows, self.period, cases)

    def _trimmed(self, vehicle: Vehicle, rows: Array) -> TrimPoint:
        setting = setting_of(self.trim, self.nominal, vehicle)
        plant = balanced_plant(self._map, self.trim, self.nominal, setting)
        return find_trim(self._map, rows, setting, plant, lambda: self._gains_of_terms(rows, MIDDLE)[:, 0])

    def _trimmed_or_none(self, vehicle: Vehicle) -> TrimPoint | None:
        try:
            point = self._trimmed(vehicle, self._row)
        except InputError:
            return None
        return point if point.steady.all() else None


class _Worst:
    """BlockReadings of n vehicles, channel by channel, in the worst of their amplitudes."""

    def __init__(self, n: int) -> None:
        self._stable, self._growth = np.ones((n, len(CHANNELS)), dtype=bool), np.full((n, len(CHANNELS)), -np.inf)
        self._quantities = {entry.field: np.full((n, len(CHANNELS)), entry.open) for entry in LOOP_QUANTITIES}

    def enter(self, block: Block, read: BlockReadings, h: float) -> None:
        """Enter a block, whose rows are vehicles, then amplitudes."""
        n, channels = len(self._stable), list(block.channels)
        self._stable[:, channels] = np.all(read.modes.stable.reshape(n, -1), axis=1, keepdims=True)
        self._growth[:, channels] = read.modes.growth.reshape(n, -1).max(axis=1)[:, None] / h
        for entry in LOOP_QUANTITIES:
            values = read.quantities[entry.field].value.reshape(n, -1, len(channels))
            worst = values.min(axis=1) if entry.sense == "least" else values.max(axis=1)
            self._quantities[entry.field][:, channels] = worst

    def of(self, i: int) -> Judged:
        """Return one vehicle."""
        return Judged(self._stable[i], self._growth[i], {name: values[i] for name, values in self._quantities.items()})


def stacked(loops: Sequence[LinearLoops]) -> LinearLoops:
    """Return batches of loops as one."""
    parts = {name: np.concatenate([getattr(each, name) for each in loops], axis=0) for name in "abcd"}
    return replace(loops[0], **parts)
