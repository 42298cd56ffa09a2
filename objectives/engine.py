"""Execution backends for flights: local threads, a GPU or a cluster.

A flight is a pure function of system, root seed, batch, index and gains. An engine of the same `arithmetic` gives the same
bits, wherever it flies.
"""

from collections.abc import Iterable, Iterator
from typing import Protocol

import numpy as np

from objectives.flown_system import FlightBackend, FlightBatch, FlownSystem, OnFlightsDone, Scenario
from plant.backends.flyer import FlightInputs, Flyer, Recording

# Scenarios of a batch that are kept between generations, and their control periods together; at 10 s and 250 Hz, 2500 periods,
# one takes 0.3 MB of wind and noise.
MAX_CACHED, MAX_CACHED_PERIODS = 1024, 1024 * 2500
LANES = Flyer.arithmetic
"""Arithmetic of the compiled lanes on the processor, which recorded flights have unless they say otherwise."""


class Engine(Protocol):
    """Flies gains through ranges of a batch. arithmetic: names the bits, see `objectives.memory.scenario_key`.

    An engine of its own has `arithmetic` and `fly`; the rest stands here for classes that derive from this one.
    """

    @property
    def arithmetic(self) -> str:
        """Name of the arithmetic: engines of one name agree to the bit."""
        ...

    def fly(
        self, gains: np.ndarray, batch: FlightBatch, first: int, last: int, on_flights_done: OnFlightsDone | None = None
    ) -> np.ndarray:
        """Fly gains rows (n, g) through the flights first..last of a batch; return results (n, last - first, rows).

        on_flights_done(k) is called as k more flights have ended.
        """
        ...

    def ready(self, batch: FlightBatch) -> bool:  # noqa: ARG002
        """Return True if flights begin at once: if not, the first one waits for a compiler."""
        return True

    def draw_ahead(self, batch: FlightBatch, first: int, last: int) -> None:
        """Sample flights first..last of a batch in advance, from a second thread."""

    def record(self, batch: FlightBatch, recording: Recording) -> None:
        """Record the first flights of a batch from now on, if possible."""

    def warm_up(self, gains: np.ndarray, batch: FlightBatch) -> None:
        """Fly a gains row (g,) once, so that everything is compiled."""
        self.fly(gains[None], batch, 0, 1)

    def stream(
        self,
        parts: Iterable[np.ndarray],
        batch: FlightBatch,
        first: int,
        last: int,
        on_flights_done: OnFlightsDone | None = None,
    ) -> Iterator[np.ndarray]:
        """Fly parts (k, g) of many gains rows and yield their results in turn.

        An engine far away reads the next parts while the results of earlier ones are still to come.
        """
        for part in parts:
            yield self.fly(part, batch, first, last, on_flights_done) if len(part) else np.empty((0, last - first, 0))


def keeps(count: int, steps: int) -> bool:
    """Return True if `count` flights of `steps` control periods are cached."""
    return count <= MAX_CACHED and count * steps <= MAX_CACHED_PERIODS


class Scenarios:
    """Sampled scenarios of a study, cached where they are few."""

    def __init__(self, system: FlownSystem, root: int) -> None:
        self._system = system
        self._root = root
        self._cached: dict[tuple[Scenario, str, int, int], FlightInputs] = {}

    def inputs(self, batch: FlightBatch, first: int, last: int) -> FlightInputs:
        """Return the scenarios of a batch from `first` to before `last`."""
        key = (batch.spec, batch.stream, first, last)
        if key in self._cached:
            return self._cached[key]
        inputs = self._system.sample(batch.spec, self._root, batch.stream, range(first, last))
        if keeps(batch.count, batch.spec.steps(self._system.timing)):
            self._cached[key] = inputs
        return inputs


class LocalEngine(Engine):
    """The cores of this machine."""

    def __init__(self, system: FlownSystem, root: int, flyer: FlightBackend) -> None:
        self._system, self._flyer = system, flyer
        self._scenarios = Scenarios(system, root)
        self._recordings: dict[tuple[Scenario, str], Recording] = {}

    @property
    def arithmetic(self) -> str:
        """Arithmetic of what flies here: that of the compiled lanes, or an FMU's own."""
        return self._flyer.arithmetic

    def ready(self, batch: FlightBatch) -> bool:  # noqa: ARG002
        """Return True if an earlier process compiled the kernel."""
        return self._flyer.cached

    def draw_ahead(self, batch: FlightBatch, first: int, last: int) -> None:
        """Draw flights that are few enough to be kept."""
        if keeps(batch.count, batch.spec.steps(self._system.timing)):
            self._scenarios.inputs(batch, first, last)

    def record(self, batch: FlightBatch, recording: Recording) -> None:
        """Record the first flights of a batch where one range holds all.

        An FMU's flights are not recorded.
        """
        if self._flyer.records:
            self._recordings[batch.spec, batch.stream] = recording

    def fly(
        self, gains: np.ndarray, batch: FlightBatch, first: int, last: int, on_flights_done: OnFlightsDone | None = None
    ) -> np.ndarray:
        """Fly; see `Engine`."""
        arguments = gains, self._system.nominal, self._scenarios.inputs(batch, first, last), on_flights_done
        recording = self._recordings.get((batch.spec, batch.stream))
        if recording and first == 0 and last >= recording.flights:
            return self._flyer.fly(*arguments, recording)
        return self._flyer.fly(*arguments)
