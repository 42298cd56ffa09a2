"""The published experiment, flown again under any setting of the unknowns.

Every setting meets the same draws (common random numbers), and so does every contender within a setting: flight i of one is
to be compared with flight i of another. Threads fly different settings; a setting's result depends on nothing but itself.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from objectives.problem import score_flights
from objectives.system import System
from plant.backends.flyer import FlightInputs, Flyer
from plant.threads import available_threads
from tuner.experiments.inference.draws import FlightRange, FlightSampler
from tuner.experiments.inference.record import SettingStore
from tuner.study.inference import Inference

# Flights drawn at once: those of a whole setting in a search, and a part of those at the end that the memory can hold.
CHUNK = 64


@dataclass(frozen=True)
class Task:
    """The flights of one contender: the scenario's number, and the numbers of the cells that it is flown for."""

    contender: str
    scenario: int
    cells: tuple[int, ...]


class SettingFlyer:
    """Flies settings. threads: by default one for each core. settings: what was flown before; flights_made counts the rest;
    spared(n) is called for the others, if set.

    flights_of(count): flights of one setting with so many flights of each contender and scenario.
    """

    def __init__(self, inference: Inference, threads: int | None = None, settings: SettingStore | None = None) -> None:
        self._inference = inference
        self._settings = settings
        self.flights_made = 0
        self.spared: Callable[[int], None] | None = None
        self._sampler = FlightSampler(inference.contest.seed)
        self._flyers: dict[tuple[object, ...], Flyer] = {}
        self.threads = threads or available_threads()
        self.tasks = tasks_of(inference)
        self.cached = self._prepare()

    def flights_of(self, count: int) -> int:
        """Return the number of flights of one setting."""
        return len(self.tasks) * count

    def fly(
        self, values: np.ndarray, stream: str, count: int, on_flights_done: Callable[[int], None] | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return scores (n, cells, flights) and failed (n, cells, flights) of settings (n, unknowns), recalled or flown."""
        stored = [self._settings.load(stream, count, row) if self._settings else None for row in values]
        missing = np.array([part is None for part in stored], dtype=bool)
        scores = np.empty((len(values), len(self._inference.cells), count))
        failed = np.empty(scores.shape, dtype=bool)
        for i, part in enumerate(stored):
            if part is not None:
                scores[i], failed[i] = part
        if on_flights_done is not None:
            (self.spared or on_flights_done)(int(np.sum(~missing, axis=0)) * self.flights_of(count))
        if missing.any():
            scores[missing], failed[missing] = self._fly_missing(values[missing], stream, count, on_flights_done)
        if self._settings is not None:
            self._settings.add(stream, values, scores, failed)
        return scores, failed

    def _fly_missing(
        self, values: np.ndarray, stream: str, count: int, on_flights_done: Callable[[int], None] | None
    ) -> tuple[np.ndarray, np.ndarray]:
        self.flights_made += len(values) * self.flights_of(count)
        scores = np.empty((len(values), len(self._inference.cells), count))
        failed = np.empty(scores.shape, dtype=bool)

        def one(setting: int, first: int, last: int) -> None:
            self._fly(values[setting], stream, first, scores[setting, :, first:last], failed[setting, :, first:last])
            if on_flights_done is not None:
                on_flights_done(self.flights_of(last - first))

        with ThreadPoolExecutor(self.threads) as pool:
            # Chunk by chunk over all settings, so that what is drawn once is still there for the next setting.
            try:
                for first in range(0, count, CHUNK):
                    last = min(first + CHUNK, count)
                    list(pool.map(lambda setting, a=first, b=last: one(setting, a, b), range(len(values))))
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
        return scores, failed

    def _prepare(self) -> bool:
        """Load the kernels of all contenders as given; return whether all were compiled by an earlier process."""
        studies = self._inference.studies(np.array(self._inference.space.base))
        return all([self._flyer(studies[task.contender].system).cached for task in self.tasks])

    def _fly(self, values: np.ndarray, stream: str, first: int, scores: np.ndarray, failed: np.ndarray) -> None:
        """Fly one setting and fill scores and failed (cells, flights) from flight `first` on."""
        studies = self._inference.studies(values)
        drawn: dict[FlightRange, FlightInputs] = {}
        for task in self.tasks:
            study = studies[task.contender]
            spec, system = study.scenarios[task.scenario].spec, study.system
            flights = FlightRange(spec, system.vehicle, system.timing, stream, first, first + scores.shape[1])
            if flights not in drawn:
                drawn[flights] = self._sampler.inputs(flights)
            results = self._flyer(system).fly(study.default_row[None], system.nominal, drawn[flights])
            rows, metrics = list(task.cells), [self._inference.cells[i].metric for i in task.cells]
            scores[rows], failed[rows] = score_flights(system, metrics, results[0], spec, drawn[flights].targets)

    def _flyer(self, system: System) -> Flyer:
        """Return the flyer of a system; those of one pair of laws, with the same limits and timing, share it."""
        key = (system.cascade.position.name, system.cascade.attitude.name, system.limits, system.timing)
        if key not in self._flyers:
            self._flyers[key] = Flyer(system.loop, system.limits, system.timing, threads=1)
        return self._flyers[key]


def tasks_of(inference: Inference) -> tuple[Task, ...]:
    """Return the flights of one setting: every contender through every scenario that it has a cell in."""
    names = [scenario.spec.name for scenario in inference.contest.scenarios]
    cells: dict[tuple[str, int], list[int]] = {}
    for i, cell in enumerate(inference.cells):
        cells.setdefault((cell.contender, names.index(cell.scenario)), []).append(i)
    return tuple(Task(name, scenario, tuple(numbers)) for (name, scenario), numbers in cells.items())
