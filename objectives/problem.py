"""The problem a search solves: points of the unit cube in, risks of metrics over the flights of a system out."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.engine import Engine, LocalEngine
from objectives.evaluator import Constraint, Evaluation, Evaluator, Objective, seen_scores
from objectives.flown_system import FlightBatch, FlownSystem, Scenario
from objectives.memory import FlightMemory, scenario_key
from objectives.metrics import FlightContext, MetricAddress, evaluate
from objectives.own_meters import metering
from objectives.requirements import Screen
from plant.backends.flyer import result_parts
from plant.backends.lane_layout import LANES
from plant.quadrotor.scenarios import SEARCH
from plant.status import Status

__all__ = ["Constraint", "Evaluation", "Evaluator", "FlightBatch", "Objective", "Problem", "seen_scores"]

# Scenarios drawn at once, and their control periods together; at 10 s and 250 Hz, 2500 periods, one takes 0.3 MB of wind and
# noise, and laying a chunk out in lanes takes three times that for a moment.
CHUNK, CHUNK_PERIODS = 256, 256 * 2500
# Bytes of results that candidates fly for at a time: 72 numbers a flight are soon scored to a few. 434 candidates on 64
# scenarios, which keep 100 threads busy for half a second.
PART = 16_000_000
# The row of a flight's result that holds its status, see `plant.backends.flyer.result_parts`.
STATUS_ROW = -2


def score_flights(
    system: FlownSystem, metrics: Sequence[MetricAddress], results: np.ndarray, spec: Scenario, targets: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Return scores (metrics, ...) and failures (...) of result rows (..., rows) of flights through a scenario."""
    values, status, end_time = result_parts(results)
    h = system.timing.control_period
    context = FlightContext(spec.steps(system.timing) * h, h, targets, status, end_time, system.metric_limits())
    return evaluate(metrics, values, context, system.loop.Meters).values, status != 0


def chunk_size(steps: int) -> int:
    """Return the number of flights sampled at once, by their control periods: a multiple of the lanes."""
    return max(min(CHUNK, CHUNK_PERIODS // steps) // LANES * LANES, LANES)


class Problem(Evaluator):
    """Evaluates points by flights of a system.

    batches: one for each scenario of the study. on_flights_done(n) is called as n more flights have ended or been spared.
    fly_all: fly what breaks a hard requirement too; a mask (n,) says so for single candidates.
    engine: by which flights are made, by default this machine; flyer: of this machine. model: `objectives.memory.model_key` under
    which the memory keeps flights, by default that of the sources at hand.
    """

    def __init__(
        self,
        system: FlownSystem,
        space: DecisionSpace,
        objectives: tuple[Objective, ...],
        constraints: tuple[Constraint, ...],
        root: int,
        threads: int | None = None,
        screens: tuple[Screen, ...] = (),
        memory: FlightMemory | None = None,
        engine: Engine | None = None,
        model: str | None = None,
    ) -> None:
        super().__init__(space, objectives, constraints, screens)
        self.system = system = metering(system, (quantity.metric for quantity in self.quantities))
        self.flyer = system.flyer(threads)
        self.memory = memory
        self.root = root
        self._model = model
        self.engine = engine or LocalEngine(system, root, self.flyer)
        self._known_targets: dict[Scenario, Any] = {}

    def scored(
        self,
        gains: np.ndarray,
        flown: np.ndarray,
        batch: FlightBatch,
        first: int,
        last: int,
        on_flights_done: Callable[[int], None] | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Fly the `flown` (n,) of the gains rows (n, g) and score all.

        They fly part after part.
        Return scores (n, quantities, last - first) and failures (n, last - first).
        """
        n, spared = len(gains), np.flatnonzero(~flown)
        # Laid out as the scores of one part are, see `seen_scores`.
        scores = np.moveaxis(np.empty((len(self.quantities), n, last - first)), 0, 1)
        failed = np.empty((n, last - first), dtype=bool)
        flying = np.flatnonzero(flown)
        for part, results in self.parts(gains[flying], batch, first, last, on_flights_done):
            scores[flying[part]], failed[flying[part]] = self.score(results, batch.spec)
        if len(spared):
            scores[spared], failed[spared] = self.unflown(batch, last - first)
            self.spare(len(spared) * (last - first), on_flights_done)
        return scores, failed

    def unflown(self, batch: FlightBatch, flights: int) -> tuple[np.ndarray, np.ndarray]:
        """Return scores (1, quantities, flights) and failures (1, flights) of one that was not worth a flight: lost at t = 0."""
        results = np.zeros((1, flights, self.flyer.rows))
        results[..., STATUS_ROW] = Status.LOST.code
        return self.score(results, batch.spec)

    def chunks(self, batch: FlightBatch) -> list[tuple[int, int]]:
        """Return the consecutive ranges of flights of a batch."""
        size = chunk_size(batch.spec.steps(self.system.timing))
        return [(first, min(first + size, batch.count)) for first in range(batch.start, batch.count, size)]

    def key(self, batch: FlightBatch) -> str:
        """Return the key of a batch's flights: see `objectives.memory`; gains and index come on top."""
        return scenario_key(self.system, self.root, batch, self.engine.arithmetic, self._model)

    def results(
        self,
        gains: np.ndarray,
        batch: FlightBatch,
        first: int,
        last: int,
        on_flights_done: Callable[[int], None] | None = None,
    ) -> np.ndarray:
        """Return the results (n, last - first, rows) of gains rows (n, g); all at once, so for few rows: see `parts`."""
        out = np.empty((len(gains), last - first, self.flyer.rows))
        for part, results in self.parts(gains, batch, first, last, on_flights_done):
            out[part] = results
        return out

    def parts(
        self,
        gains: np.ndarray,
        batch: FlightBatch,
        first: int,
        last: int,
        on_flights_done: Callable[[int], None] | None = None,
    ) -> Iterator[tuple[slice, np.ndarray]]:
        """Yield slices of the gains rows (n, g), in order, with their results (k, last - first, rows).

        Recalled where the memory has them, else flown. They are read-only elsewhere: the memory may keep them.
        """
        key, flights = self.key(batch), last - first
        each = max(PART // (8 * flights * self.flyer.rows), 1)
        under_way: deque[tuple[slice, np.ndarray, np.ndarray]] = deque()

        def unknown_parts() -> Iterator[np.ndarray]:
            for start in range(0, len(gains), each):
                part = slice(start, start + each)
                out, unknown = self._recalled(key, gains[part], first, last)
                under_way.append((part, out, unknown))
                yield gains[part][unknown]

        for flown in self.engine.stream(unknown_parts(), batch, first, last, on_flights_done):
            part, out, unknown = under_way.popleft()
            if len(flown):
                out[unknown] = flown
            self.spare((len(out) - len(flown)) * flights, on_flights_done)
            self.flights_made += len(flown) * flights
            if self.memory:
                self.memory.keep(key, batch, gains[part], first, out)
            yield part, out

    def _recalled(self, key: str, gains: np.ndarray, first: int, last: int) -> tuple[np.ndarray, np.ndarray]:
        """Return recorded results (n, last - first, rows), and a mask (n,) of missing ones."""
        out = np.empty((len(gains), last - first, self.flyer.rows))
        unknown = np.ones(len(gains), dtype=bool)
        for i, row in enumerate(gains):
            recalled = self.memory.recall(key, row, first, last) if self.memory else None
            if recalled is not None:
                out[i], unknown[i] = recalled, False
        return out, unknown

    def warm_up(self, gains: np.ndarray, spec: Scenario) -> None:
        """Fly a gains row (g,) once, so that the kernel is compiled.

        The memory does not record the flight.
        Here too where others fly, for the responses: their kernel may be in a cache that is not this machine's.
        """
        batch = FlightBatch(spec, SEARCH, 1)
        self.engine.warm_up(gains, batch)
        if not isinstance(self.engine, LocalEngine):
            LocalEngine(self.system, self.root, self.flyer).warm_up(gains, batch)

    def score(self, results: np.ndarray, spec: Scenario) -> tuple[np.ndarray, np.ndarray]:
        """Turn result rows (n, flights, rows) into scores (n, quantities, flights) and failures (n, flights)."""
        metrics = [quantity.metric for quantity in self.quantities]
        scores, failed = score_flights(self.system, metrics, results, spec, self._targets(spec))
        return np.moveaxis(scores, 0, 1), failed

    def _targets(self, spec: Scenario) -> Any:
        if spec not in self._known_targets:
            self._known_targets[spec] = self.system.targets(spec)
        return self._known_targets[spec]
