"""The graphics card as an engine of flights, see `objectives.engine`.

Its bits differ from those of the processor, so its flights have keys of their own. Traces for reports stay on the processor.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from objectives.engine import Engine, OnFlightsDone, Scenarios
from objectives.flown_system import FlightBatch, FlownSystem
from tuner.extensions.cuda.flights import CudaFlyer

FLOAT64, FLOAT32 = "float64", "float32"


class CudaEngine(Engine):
    """The first CUDA device of this machine; raises what Numba raises where there is none, see `card.missing`."""

    def __init__(self, system: FlownSystem, root: int, precision: str = FLOAT64) -> None:
        self._system = system
        self._flyer = CudaFlyer(system.loop, system.limits, system.timing, precision)
        self._scenarios = Scenarios(system, root)
        self._arithmetic = f"cuda-{precision}, {self._flyer.card.words}"

    @property
    def arithmetic(self) -> str:
        """Precision, kind of card, compiler and driver: together with the sources they decide the bits."""
        return self._arithmetic

    def ready(self, batch: FlightBatch) -> bool:
        """Return True if a batch's kernel is in the cache."""
        return self._flyer.kernel(self._scenarios.inputs(batch, 0, 1)).cached

    def fly(
        self, gains: np.ndarray, batch: FlightBatch, first: int, last: int, on_flights_done: OnFlightsDone | None = None
    ) -> np.ndarray:
        """Fly; see `Engine`."""
        return self._flyer.fly(gains, self._system.nominal, self._scenarios.inputs(batch, first, last), on_flights_done)

    def stream(
        self,
        parts: Iterable[np.ndarray],
        batch: FlightBatch,
        first: int,
        last: int,
        on_flights_done: OnFlightsDone | None = None,
    ) -> Iterator[np.ndarray]:
        """Fly as many parts together as fill the card: one launch takes as long for half of it as for all of it."""
        waiting: list[np.ndarray] = []
        for part in parts:
            waiting.append(part)
            if sum(map(len, waiting)) * (last - first) >= self._flyer.resident:
                yield from self._together(waiting, batch, first, last, on_flights_done)
                waiting = []
        yield from self._together(waiting, batch, first, last, on_flights_done)

    def _together(
        self, parts: list[np.ndarray], batch: FlightBatch, first: int, last: int, on_flights_done: OnFlightsDone | None
    ) -> Iterator[np.ndarray]:
        if not any(map(len, parts)):
            yield from (np.empty((0, last - first, self._flyer.rows)) for _ in parts)
            return
        results = self.fly(np.concatenate(parts, axis=0), batch, first, last, on_flights_done)
        ends = np.cumsum([len(part) for part in parts], axis=0)
        yield from np.split(results, ends[:-1], axis=0)
