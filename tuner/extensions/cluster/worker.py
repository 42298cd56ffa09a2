"""The side of a worker: it keeps the briefs it was given, builds each system once, draws scenarios once, and flies blocks.

One process keeps one of each, whatever number of threads fly in it.
"""

import pickle
from collections import OrderedDict
from collections.abc import Hashable
from threading import Lock
from typing import Any

import numpy as np
from distributed import WorkerPlugin

from plant.backends.flyer import FlightInputs, Flyer
from tuner.extensions.cluster.brief import BatchSpec, system_of

# Bytes of drawn scenarios that a process keeps; at 10 s and 250 Hz one takes 0.3 MB of wind and noise.
MAX_BYTES = 400_000_000
# Pickled briefs by key, as the plugin of each brought them.
BRIEFS: dict[str, bytes] = {}


class BriefPlugin(WorkerPlugin):
    """Plugin that brings a brief to every worker: once to each, and to those that join later."""

    def __init__(self, brief: BatchSpec) -> None:
        self.name = f"gainproof-{brief.key}"
        self._key = brief.key
        # Opened by the first task: what it imports would hold up the heartbeat of the worker.
        self._content = pickle.dumps(brief)

    def setup(self, worker: Any) -> None:  # noqa: ARG002
        """Keep the brief."""
        BRIEFS[self._key] = self._content


class Drawn:
    """The scenarios that this process drew last, up to so many bytes; two threads never draw the same."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._guard = Lock()
        self._locks: dict[Hashable, Lock] = {}
        self._cached: OrderedDict[Hashable, FlightInputs] = OrderedDict()

    def inputs(self, brief: BatchSpec, system: Any, first: int, last: int) -> FlightInputs:
        """Return a batch's scenarios of a system, from `first` to before `last`."""
        key = (brief.key, first, last)
        with self._guard:
            lock = self._locks.setdefault(key, Lock())
        with lock:
            inputs = self._lookup(key)
            if inputs is None:
                indices = range(first, last)
                inputs = system.sample(brief.spec, brief.root, brief.stream, indices)
                self._keep(key, inputs)
        return inputs

    def _lookup(self, key: Hashable) -> FlightInputs | None:
        with self._guard:
            if key in self._cached:
                self._cached.move_to_end(key)
            return self._cached.get(key)

    def _keep(self, key: Hashable, inputs: FlightInputs) -> None:
        with self._guard:
            self._cached[key] = inputs
            while len(self._cached) > 1 and sum(map(size_of, self._cached.values())) > self._most:
                self._locks.pop(self._cached.popitem(last=False)[0], None)


def size_of(inputs: FlightInputs) -> int:
    """Return the bytes of drawn scenarios."""
    return inputs.dynamics.nbytes + inputs.disturbances.nbytes + inputs.noises.nbytes + inputs.references.nbytes


class Desk:
    """A system built from a brief, with its kernel; a block flies in the one thread that took it."""

    def __init__(self, brief: BatchSpec) -> None:
        self.system: Any = system_of(brief)
        self.brief, system = brief, self.system
        self._nominal = system.nominal
        self._flyer = Flyer(system.loop, system.limits, system.timing, 1)
        self.cached = self._flyer.cached

    def fly(self, gains: np.ndarray, inputs: FlightInputs) -> np.ndarray:
        """Return results (n, flights, rows)."""
        return self._flyer.fly(gains, self._nominal, inputs)


DRAWN = Drawn(MAX_BYTES)
DESKS: dict[str, Desk] = {}
_opening = Lock()


def desk_of(key: str) -> Desk:
    """Return the desk of a brief, built at first use."""
    with _opening:
        if key not in DESKS:
            DESKS[key] = Desk(pickle.loads(BRIEFS[key]))
        return DESKS[key]


def fly_block(key: str, gains: np.ndarray, first: int, last: int) -> np.ndarray:
    """Fly gains (n, g) through flights first..last of a brief's batch; return results (n, flights, rows)."""
    desk = desk_of(key)
    return desk.fly(gains, DRAWN.inputs(desk.brief, desk.system, first, last))


def is_compiled(key: str) -> bool:
    """Return True if a batch's kernel was cached here at first use."""
    return desk_of(key).cached
