"""Fly many candidates through many scenarios on the lanes backend: blocks of SIMD lanes, threads over candidates.

The bits of a flight depend on its gains and its scenario alone, not on the lane, block, batch or thread that it flew in:
lanes never mix, a block is always full (spare lanes repeat the last scenario), and nothing is summed across flights.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from plant.backends.lane_layout import LANES, layout, result_rows
from plant.loop import ClosedLoop, Timing
from plant.records import flatten
from plant.threads import available_threads


@dataclass(frozen=True)
class FlightInputs:
    """Scenarios of a batch in blocks of lanes.

    Attributes:
        dynamics: (blocks, rows, lanes).
        starts: (blocks, 17, lanes), the body at the start, about where the reference starts.
        disturbances: (blocks, K, rows, lanes).
        noises: the same.
        references: (K, 14).
        targets: those that they are judged by.
        count: number of scenarios, the rest of the last block is padding.
    """

    dynamics: np.ndarray
    starts: np.ndarray
    disturbances: np.ndarray
    noises: np.ndarray
    references: np.ndarray
    targets: Any
    count: int

    def blocks(self, first: int, last: int) -> "FlightInputs":
        """Return the scenarios of the blocks from `first` to before `last`."""
        names = ("dynamics", "starts", "disturbances", "noises")
        parts = {name: getattr(self, name)[first:last] for name in names}
        return replace(self, **parts, count=min(self.count, last * LANES) - first * LANES)


class Recording(NamedTuple):
    """A recorder of the first flights of each candidate.

    Attributes:
        flights: how many.
        rows: rows of the workspace, in the order in which they are wanted.
        every: at each so many-th instant.
        take: called with gains (n,), trace (flights, instants, rows) and results (flights, rows) of a candidate and the
            references (K, 14) that it flew, from the threads that fly.
    """

    flights: int
    rows: Sequence[int] | np.ndarray
    every: int
    take: Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], None]


def to_lanes(per_scenario: Sequence[np.ndarray] | np.ndarray) -> np.ndarray:
    """Turn scenarios, arrays of one shape (...), into (blocks, ..., lanes): the last one fills the last block."""
    return filled_lanes(len(per_scenario), per_scenario[0].shape, lambda i, out: np.copyto(out, per_scenario[i]))


def filled_lanes(count: int, shape: tuple[int, ...], fill: Callable[[int, np.ndarray], None]) -> np.ndarray:
    """Return scenarios as (blocks, *shape, lanes): the last one fills the last block.

    fill: writes the scenario of a number into an array of the shape; called in the order of the numbers.
    """
    # A block is filled scenario by scenario and turned at once: writing a lane at a time takes a cache line for each number.
    out, block = np.empty((-(-count // LANES), *shape, LANES)), np.empty((LANES, *shape))
    for number, lanes in enumerate(out):
        for lane in range(LANES):
            i = number * LANES + lane
            if i < count:
                fill(i, block[lane])
            else:
                block[lane] = block[lane - 1]
        lanes[...] = np.moveaxis(block, 0, -1)
    return out


NOTHING, UNTRACED = np.empty(0, dtype=np.intp), np.empty((1, 1, 1, 1, 1))
"""Rows and memory of a trace of nothing."""


def by_scenario(lanes: np.ndarray) -> np.ndarray:
    """Turn blocks of lanes (blocks, ..., lanes) into scenarios (blocks * lanes, ...), spare ones included."""
    return np.moveaxis(lanes, -1, 1).reshape(-1, *lanes.shape[1:-1])


class Flyer:
    """A closed loop compiled for the lanes backend.

    arithmetic: names its bits, see `objectives.engine`. rows: of a flight's result.
    cached: whether the kernel was compiled by an earlier process; if not, the first flight waits for the compiler. records:
    whether `fly` takes a recording. say: told of flights that a backend lost, of which this one has none.
    fly(gains (candidates, n), nominal, inputs) -> results (candidates, scenarios, rows): the meters of each flight in leaf
    order, then status and end time.
    """

    arithmetic = "lanes"
    records = True

    def __init__(self, loop: ClosedLoop, limits: Any, timing: Timing, threads: int | None = None) -> None:
        # Here, because a study that flies nothing needs no compiler.
        from plant.backends.lanes import kernel_of

        self.loop = loop
        self.say: Callable[[str], None] = lambda _: None
        self.threads = threads or available_threads()
        self._limits = np.array(flatten(limits))
        self._timing = timing
        kernel = kernel_of(loop)
        self._kernel = kernel.run
        self.cached = kernel.cached
        rows = result_rows(loop)
        self.rows = rows.stop - rows.start

    def at(self, timing: Timing) -> "Flyer":
        """Return the same kernel with another control period and plant step."""
        other = copy(self)
        other._timing = timing
        return other

    def fly(
        self,
        gains: np.ndarray,
        nominal: Any,
        inputs: FlightInputs,
        on_flights_done: Callable[[int], None] | None = None,
        recording: Recording | None = None,
    ) -> np.ndarray:
        """Fly every candidate through every scenario.

        Args:
            gains: One row for each candidate (candidates, gains), in the order of `plant.quadrotor.gains.gain_addresses`.
            nominal: The controller's knowledge of the vehicle.
            inputs: The scenarios, see `plant.quadrotor.scenarios.sample_scenarios`.
            on_flights_done: Called with n as n more flights have ended, from the threads that fly.
            recording: Records the first flights of each candidate, of which there must be as many.

        Returns:
            Results (candidates, scenarios, rows): meters in leaf order, status, end time [s]; see `result_parts`.
        """
        blocks = len(inputs.dynamics)
        out = np.empty((len(gains), blocks, self.rows, LANES))
        recorded = -(-recording.flights // LANES) if recording else 0

        def task(candidate: int) -> None:
            row, results = gains[candidate], out[candidate]
            if recording:
                first = inputs.blocks(0, recorded)
                trace = self._traced(row, nominal, first, results[:recorded], recording.rows, recording.every)
                n = recording.flights
                recording.take(row, trace[:n], by_scenario(results[:recorded])[:n], inputs.references)
            if recorded < blocks:
                self._run(row, nominal, inputs.blocks(recorded, blocks), results[recorded:], NOTHING, UNTRACED, 0)
            if on_flights_done is not None:
                on_flights_done(inputs.count)

        if len(gains) == 1:
            # A thread for it would take as long as a short flight.
            task(0)
        else:
            with ThreadPoolExecutor(self.threads) as pool:
                list(pool.map(task, range(len(gains))))
        return np.moveaxis(out, -1, 2).reshape(len(gains), blocks * LANES, self.rows)[:, : inputs.count]

    def trace(
        self,
        gains: np.ndarray,
        nominal: Any,
        inputs: FlightInputs,
        every: int = 1,
        traced: Sequence[int] | np.ndarray | None = None,
    ) -> np.ndarray:
        """Fly one candidate, gains (n,), and return every `every`-th instant: (scenarios, instants, rows).

        traced: rows of the workspace in the order they are wanted, by default all of them; a few take a twentieth of the memory.
        """
        chosen = np.arange(layout(self.loop).total) if traced is None else traced
        out = np.empty((len(inputs.dynamics), self.rows, LANES))
        return self._traced(gains, nominal, inputs, out, chosen, every)[: inputs.count]

    def _traced(
        self,
        gains: np.ndarray,
        nominal: Any,
        inputs: FlightInputs,
        out: np.ndarray,
        traced: Sequence[int] | np.ndarray,
        every: int,
    ) -> np.ndarray:
        """Fly one candidate into out (blocks, rows, lanes) and return the trace, spare lanes included."""
        chosen = np.array(traced, dtype=np.intp)
        trace = np.empty((1, len(inputs.dynamics), -(-len(inputs.references) // every), len(chosen), LANES))
        self._run(gains, nominal, inputs, out, chosen, trace, every)
        return by_scenario(trace[0])

    def _run(
        self,
        gains: np.ndarray,
        nominal: Any,
        inputs: FlightInputs,
        out: np.ndarray,
        traced: np.ndarray,
        trace: np.ndarray,
        every: int,
    ) -> None:
        """Fly one candidate, gains (n,), and write the results into out (blocks, rows, lanes)."""
        self._kernel(
            np.ascontiguousarray(gains[None], dtype=float),
            np.array(flatten(nominal), dtype=float),
            inputs.dynamics,
            inputs.starts,
            inputs.disturbances,
            inputs.noises,
            inputs.references,
            np.array(flatten(inputs.targets), dtype=float),
            self._limits,
            *self._timing,
            self._timing.steps,
            out[None],
            traced,
            trace,
            every,
        )


def result_parts(results: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Split results (..., rows) into meters (..., n), status codes (...) as integers and end times (...) [s]."""
    return results[..., :-2], results[..., -2].astype(np.int64), results[..., -1]
