"""Flights of a scenario under many settings, with common random numbers.

An injected disturbance is filtered white noise; the noise of flight i depends on root seed, stream, scenario name and i alone.
So settings that differ in its intensity, correlation time or bias share it, and only the filter runs anew. Any other change is
sampled in full by `plant.quadrotor.scenarios`; the bits are the same either way.
"""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any

import numpy as np

from plant.air.air import COLUMNS, injection_normals
from plant.air.injection import Injection, shape_injection
from plant.air.window import gate
from plant.backends.flyer import FlightInputs, to_lanes
from plant.loop import Timing
from plant.quadrotor.scenarios import WIND_COLUMNS, Bands, ScenarioSpec, sample_scenarios
from plant.quadrotor.vehicle import Vehicle
from plant.seeds import generator

# The injection stands behind wind and gust rates in the air's columns.
INJECTED = slice(6, COLUMNS)
# Largest number of cached values: chunks of flights without injection, and of its normals; 64 flights of 20 s at 250 Hz are 15 MB
# of either, and four times that with sensor noise and gust rates.
MAX_CACHED = 8


@dataclass(frozen=True)
class FlightRange:
    """Flights of a scenario: the first to before the last of a stream, under one root seed."""

    spec: ScenarioSpec
    vehicle: Vehicle
    timing: Timing
    stream: str
    first: int
    last: int


class FlightSampler:
    """Sampler of flights with a cache of inputs shared by settings; thread-safe.

    root: the seed of the study.
    """

    def __init__(self, root: int) -> None:
        self._root = root
        self._cache: OrderedDict[Any, Any] = OrderedDict()
        self._lock = Lock()

    def inputs(self, requested: FlightRange) -> FlightInputs:
        """Return the drawn flights."""
        injection = requested.spec.air.injection
        if injection is None:
            return self._without_injection(requested)
        plain = self._without_injection(
            replace(requested, spec=replace(requested.spec, air=replace(requested.spec.air, injection=None)))
        )
        added = self._injected(requested, injection)
        if added is None:
            return plain
        blocks, steps, columns, lanes = plain.disturbances.shape
        disturbances = np.zeros((blocks, steps, COLUMNS, lanes))
        disturbances[:, :, :columns] = plain.disturbances
        disturbances[:, :, INJECTED] = added
        return replace(plain, disturbances=disturbances)

    def _without_injection(self, requested: FlightRange) -> FlightInputs:
        """Return the flights without injection; the bands that settling is judged by are no reason to draw again."""
        key = replace(requested, spec=replace(requested.spec, bands=Bands(), recovery_from=None, steady_share=1.0))
        cached = self._cached(key, lambda: self._sample(requested))
        return replace(cached, targets=requested.spec.targets(requested.timing))

    def _sample(self, requested: FlightRange) -> FlightInputs:
        flights = range(requested.first, requested.last)
        return sample_scenarios(
            requested.spec, requested.vehicle, requested.timing, self._root, requested.stream, flights
        )

    def _injected(self, requested: FlightRange, injection: Injection) -> np.ndarray | None:
        """Return the injected accelerations in lanes (blocks, K, 6, lanes), None where there are none."""
        steps, h = requested.spec.steps(requested.timing), requested.timing.control_period
        stream = f"{requested.stream}/{requested.spec.name}/air"
        key = (stream, steps, requested.first, requested.last)
        draws = (generator(self._root, stream, i) for i in range(requested.first, requested.last))
        normals = self._cached(key, lambda: [injection_normals(steps, draw) for draw in draws])
        factor = gate(np.arange(steps, dtype=np.float64) * h, requested.spec.air.window)
        added = np.stack([shape_injection(injection, h, factor, row) for row in normals])
        return to_lanes(added) if added.any() else None

    def _cached(self, key: Any, draw: Callable[[], Any]) -> Any:
        """Return a cached value, drawn if missing; the least recently used is evicted.

        Two threads that miss the same key at once both draw it, and draw the same.
        """
        with self._lock:
            if key in self._cache:
                self._cache.move_to_end(key)
                return self._cache[key]
        drawn = draw()
        with self._lock:
            self._cache[key] = drawn
            while len(self._cache) > MAX_CACHED:
                self._cache.popitem(last=False)
        return drawn


assert INJECTED.start >= WIND_COLUMNS, "wind stands before what is injected"
