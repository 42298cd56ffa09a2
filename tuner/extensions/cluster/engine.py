"""Flights on the workers of a Dask cluster: blocks of candidates as tasks, with the bits of the local run.

A block's results depend on its gains and its scenarios alone, so neither the number of workers nor the order in which they
finish matters, and the blocks of a worker that was lost are flown again by another. A task keeps one thread: the threads of a
worker share its scenarios, and none waits for the last candidate of another's block. Results come back in order, a part at a
time, and no more is asked for than the driver holds.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Any

import numpy as np
from distributed import Client, Future

from objectives.engine import LANES, Engine, OnFlightsDone
from objectives.flown_system import FlightBatch
from plant.backends import lane_layout
from tuner.extensions.cluster.brief import brief_of
from tuner.extensions.cluster.watch import LOOK, PATIENCE, Watch
from tuner.extensions.cluster.worker import BriefPlugin, fly_block, is_compiled

# Flights of a block: some 50 ms of work for a task that costs 1 ms. Blocks under way for each thread; the fewest that a thread
# gets of a part, so that none is idle while the last blocks of a small generation fly.
BLOCK, WAITING, SHARES = 256, 3, 2
# Bytes of results that may be under way before another part is begun; what is done waits for a slow block before it.
HELD = 128_000_000


@dataclass
class Part:
    """The results (n, flights, rows) of a part so far; missing: number of blocks to come."""

    out: np.ndarray
    missing: int


@dataclass(frozen=True)
class FlightBlock:
    """Rows of a part that fly as one task; flights: counted from the first one of the stream."""

    part: Part
    rows: slice
    gains: np.ndarray
    flights: slice

    @property
    def size(self) -> int:
        """Number of flights of all rows."""
        return len(self.gains) * (self.flights.stop - self.flights.start)


class Tasks:
    """The tasks of one stream: which block each flies, and those that ended, in that order."""

    def __init__(self, client: Client, watch: Watch) -> None:
        self._client, self._watch = client, watch
        self._blocks: dict[Future, FlightBlock] = {}
        self._ended: SimpleQueue[Future] = SimpleQueue()

    def __len__(self) -> int:
        return len(self._blocks)

    def add(self, block: FlightBlock, *arguments: Any) -> None:
        """Have a worker fly a block."""
        future = self._client.submit(*arguments, pure=False)
        self._blocks[future] = block
        future.add_done_callback(self._ended.put)

    def land(self) -> FlightBlock:
        """Wait for a task, store its results and return its block."""
        future = self._next()
        block = self._blocks[future]
        block.part.out[block.rows, block.flights] = self._watch.result(future)
        block.part.missing -= 1
        del self._blocks[future]
        return block

    def _next(self) -> Future:
        while True:
            try:
                return self._ended.get(timeout=LOOK)
            except Empty:
                self._watch.look()

    def cancel(self) -> None:
        """Forget the tasks that have not ended."""
        if self._blocks:
            with suppress(Exception):
                self._client.cancel(list(self._blocks))


class DaskEngine(Engine):
    """All threads of a scheduler's workers, whatever their number at the moment.

    block: flights of a task, about; patience: seconds that the cluster may be without workers.
    """

    def __init__(self, client: Client, system: Any, root: int, block: int = BLOCK, patience: float = PATIENCE) -> None:
        self._client, self._system, self._root, self._block = client, system, root, block
        self._watch = Watch(client, patience)
        rows = lane_layout.result_rows(system.loop)
        self._rows = rows.stop - rows.start
        self._sent: dict[FlightBatch, str] = {}

    @property
    def arithmetic(self) -> str:
        """The compiled lanes of the workers, which are as this machine."""
        return LANES

    def fly(
        self, gains: np.ndarray, batch: FlightBatch, first: int, last: int, on_flights_done: OnFlightsDone | None = None
    ) -> np.ndarray:
        """Fly; see `Engine`."""
        return next(iter([*self.stream([gains], batch, first, last, on_flights_done)]))

    def ready(self, batch: FlightBatch) -> bool:
        """Return True if every worker has the kernel in its cache."""
        return all(self._everywhere(is_compiled, self._brief(batch)))

    def warm_up(self, gains: np.ndarray, batch: FlightBatch) -> None:
        """Fly a gains row once on every worker; on each machine the first of them compiles."""
        self._everywhere(fly_block, self._brief(batch), gains[None], 0, 1)

    def stream(
        self,
        parts: Iterable[np.ndarray],
        batch: FlightBatch,
        first: int,
        last: int,
        on_flights_done: OnFlightsDone | None = None,
    ) -> Iterator[np.ndarray]:
        """Fly; see `Engine`."""
        key, source = self._brief(batch), iter(parts)
        begun, blocks, tasks, more = deque[Part](), deque[FlightBlock](), Tasks(self._client, self._watch), True
        try:
            while more or begun:
                room = WAITING * self._watch.threads
                while more and len(blocks) + len(tasks) < room and sum(part.out.nbytes for part in begun) < HELD:
                    gains = next(source, None)
                    more = gains is not None
                    if gains is not None:
                        begun.append(Part(np.empty((len(gains), last - first, self._rows)), 0))
                        blocks.extend(self._blocks(begun[-1], gains, last - first))
                while blocks and len(tasks) < room:
                    block = blocks.popleft()
                    tasks.add(
                        block, fly_block, key, block.gains, first + block.flights.start, first + block.flights.stop
                    )
                while begun and not begun[0].missing:
                    yield begun.popleft().out
                if len(tasks):
                    block = tasks.land()
                    if on_flights_done is not None:
                        on_flights_done(block.size)
        finally:
            tasks.cancel()

    def _blocks(self, part: Part, gains: np.ndarray, flights: int) -> list[FlightBlock]:
        """Split a part into blocks: of BLOCK flights, or fewer where every thread is to get its share."""
        shares = SHARES * self._watch.threads
        # Few candidates with many flights are split by flights too, into whole blocks of lanes; a worker draws those alone.
        ranges = split(flights, min(shares // max(len(gains), 1), flights // lane_layout.LANES), lane_layout.LANES)
        fair = -(-len(gains) * len(ranges) // shares)
        each = max(min(self._block // ranges[0].stop, fair), 1)
        blocks = [
            FlightBlock(part, slice(start, start + each), gains[start : start + each], entry)
            for start in range(0, len(gains), each)
            for entry in ranges
        ]
        part.missing = len(blocks)
        return blocks

    def _brief(self, batch: FlightBatch) -> str:
        """Return the key of a batch's brief, which every worker has; those that join later get it too."""
        if batch not in self._sent:
            brief = brief_of(self._system, self._root, batch)
            self._client.register_plugin(BriefPlugin(brief))
            self._sent[batch] = brief.key
        return self._sent[batch]

    def _everywhere(self, task: Callable[..., Any], *arguments: Any) -> list[Any]:
        """Return a task's results of each worker; of another one where its worker is lost."""
        workers: dict[str, int] = self._client.nthreads()  # pyright: ignore[reportAssignmentType]
        tasks = [
            self._client.submit(task, *arguments, pure=False, workers=[worker], allow_other_workers=True)
            for worker in workers
        ]
        return [self._watch.result(entry) for entry in tasks]


def split(count: int, parts: int, multiple: int) -> list[slice]:
    """Split 0 to `count` into at most `parts` ranges of one size; a multiple of `multiple` but for the last one."""
    size = count if parts < 2 else -(-count // (parts * multiple)) * multiple
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]
