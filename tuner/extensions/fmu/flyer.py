"""FMUs flown by processes, with the interface of `plant.backends.flyer.Flyer`: threads here only wait for their workers.

A flight depends on its gains and its scenario alone, so it does not matter which worker flies it. One that the FMU ends, by an
error, a crash or silence, is a result like that of a flight that diverged; the next one meets a new worker.
"""

import weakref
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from queue import LifoQueue
from typing import Any

import numpy as np

from objectives.plant_system import PlantSystem
from plant.backends.flyer import FlightInputs, Recording
from plant.backends.lane_layout import LANES
from plant.backends.stepping import lane_of
from plant.loop import ClosedLoop, Timing
from plant.records import flatten, size
from plant.status import NON_FINITE
from plant.threads import available_threads
from tuner.extensions.fmu.messages import Flown, Fly, Refused
from tuner.extensions.fmu.process import FmuProcess, WorkerLostError

Array = np.ndarray


class FmuFlyer:
    """Worker processes for an FMU, as many as threads; they start with the first flights and end with the flyer.

    process: makes one. patience: seconds that a flight may take. arithmetic, rows: as of `Flyer`. cached: nothing has to be
    compiled. say: told in one line, from the thread that asked for flights, of each way in which the FMU failed first.
    """

    cached, records = True, False

    def __init__(
        self, system: PlantSystem, process: Callable[[], FmuProcess], patience: float, threads: int | None = None
    ) -> None:
        self.loop: ClosedLoop = system.loop
        self.threads = threads or available_threads()
        self.arithmetic = system.arithmetic
        self.rows = size(self.loop.Meters) + 2
        self.say: Callable[[str], None] = lambda _: None
        self._limits, self._timing, self._patience = tuple(flatten(system.limits)), system.timing, patience
        self._name, self._reported = system.plant.name, set[str]()
        processes = [process() for _ in range(self.threads)]
        self._idle: LifoQueue[FmuProcess] = LifoQueue()
        for each in processes:
            self._idle.put(each)
        self._end = weakref.finalize(self, _close, processes)

    def at(self, timing: Timing) -> "FmuFlyer":
        """Return the same workers with another plant step."""
        other = copy(self)
        other._timing = timing
        return other

    def fly(
        self,
        gains: Array,
        nominal: Any,
        inputs: FlightInputs,
        on_flights_done: Callable[[int], None] | None = None,
        recording: Recording | None = None,  # noqa: ARG002
    ) -> Array:
        """Fly every candidate (n, gains) through every scenario; return results (n, scenarios, rows) as `Flyer.fly` does."""
        wanted = [(candidate, i) for candidate in range(len(gains)) for i in range(inputs.count)]

        def one(place: tuple[int, int]) -> Flown:
            flown = self._fly_one(self._request(gains[place[0]], nominal, inputs, place[1]))
            if on_flights_done is not None:
                on_flights_done(1)
            return flown

        flown = self._in_processes(one, wanted)
        return np.array([each.result for each in flown]).reshape(len(gains), inputs.count, self.rows)

    def trace(
        self,
        gains: Array,
        nominal: Any,
        inputs: FlightInputs,
        every: int = 1,
        traced: Sequence[int] | Array | None = None,
    ) -> Array:
        """Fly one candidate, gains (n,), and return its trace (scenarios, instants, rows).

        It has every `every`-th instant; its rows are those of the flight.
        A flight that ended early stays where it was; one of which nothing is known is NaN.
        """
        chosen = tuple(range(size(self.loop.Flight))) if traced is None else tuple(int(row) for row in traced)
        out = np.full((inputs.count, -(-len(inputs.references) // every), len(chosen)), np.nan)

        def one(i: int) -> Flown:
            return self._fly_one(self._request(gains, nominal, inputs, i)._replace(traced=chosen, every=every))

        for i, flown in enumerate(self._in_processes(one, list(range(inputs.count)))):
            if flown.trace:
                out[i, : len(flown.trace)] = flown.trace
                out[i, len(flown.trace) :] = flown.trace[-1]
        return out

    def _request(self, gains: Array, nominal: Any, inputs: FlightInputs, i: int) -> Fly:
        drawn = lane_of(inputs, i % LANES, i // LANES)
        numbers = tuple(flatten(nominal)), tuple(flatten(inputs.targets)), self._limits
        return Fly(np.array(gains, dtype=float), drawn, *numbers, self._timing)

    def _in_processes(self, task: Callable[[Any], Flown], places: Sequence[Any]) -> list[Flown]:
        with ThreadPoolExecutor(self.threads) as pool:
            flown = list(pool.map(task, places))
        failures = [each.failed for each in flown if each.failed]
        for failure in dict.fromkeys(failures):
            if failure not in self._reported:
                self._reported.add(failure)
                count = failures.count(failure)
                self.say(
                    f"The FMU {self._name} failed in {count} of {len(flown)} flights: {failure}. They count as flights that "
                    "diverged; the run goes on."
                )
        return flown

    def _fly_one(self, request: Fly) -> Flown:
        process = self._idle.get()
        try:
            answer = process.ask(request, self._patience)
        except WorkerLostError as error:
            return self._lost(f"it {error}")
        finally:
            self._idle.put(process)
        return self._lost(answer.why) if isinstance(answer, Refused) else answer

    def _lost(self, why: str) -> Flown:
        """Return the result of a flight that failed without any data.

        It is that of a flight that diverged at once.
        """
        return Flown([*[0.0] * (self.rows - 2), NON_FINITE, 0.0], [], why)


def _close(processes: Sequence[FmuProcess]) -> None:
    for process in processes:
        process.close()
