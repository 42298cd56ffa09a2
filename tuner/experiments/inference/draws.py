"""The flights of a scenario under one setting after another: what no setting changes is drawn once.

An injected disturbance is normals through a filter, and the normals of flight i depend on the root seed, the stream, the
scenario's name and i alone. So settings that differ in its intensity, correlation time or bias share them (common random
numbers): the wind, the noise and the vehicles stay as they are and only the filter is run again. Anything else that a
setting changes is drawn in full, as `plant.scenarios` does; the bits are the same either way.
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
from plant.scenarios import WIND_COLUMNS, Bands, ScenarioSpec, sample_scenarios
from plant.seeds import generator
from plant.vehicle import Vehicle

# The injection stands behind wind and gust rates in the air's columns.
INJECTED = slice(6, COLUMNS)
# What is kept at most: chunks of flights without injection, and of its normals; 64 flights of 20 s at 250 Hz are 15 MB of
# either, and four times that with sensor noise and gust rates.
KEPT = 8


@dataclass(frozen=True)
class FlightRange:
    """Flights of a scenario: the first to before the last of a stream, under one root seed."""

    spec: ScenarioSpec
    vehicle: Vehicle
    timing: Timing
    stream: str
    first: int
    last: int


class Draws:
    """Draws flights and keeps what the next setting will need again. Any thread may ask.

    root: the seed of the study.
    """

    def __init__(self, root: int) -> None:
        self._root = root
        self._kept: OrderedDict[Any, Any] = OrderedDict()
        self._lock = Lock()

    def inputs(self, asked: FlightRange) -> FlightInputs:
        """Return the drawn flights."""
        injection = asked.spec.air.injection
        if injection is None:
            return self._plain(asked)
        plain = self._plain(replace(asked, spec=replace(asked.spec, air=replace(asked.spec.air, injection=None))))
        added = self._injected(asked, injection)
        if added is None:
            return plain
        blocks, steps, columns, lanes = plain.disturbances.shape
        disturbances = np.zeros((blocks, steps, COLUMNS, lanes))
        disturbances[:, :, :columns] = plain.disturbances
        disturbances[:, :, INJECTED] = added
        return replace(plain, disturbances=disturbances)

    def _plain(self, asked: FlightRange) -> FlightInputs:
        """Return the flights without injection; the bands that settling is judged by are no reason to draw again."""
        key = replace(asked, spec=replace(asked.spec, bands=Bands(), recovery_from=None, steady_share=1.0))
        kept = self._remembered(key, lambda: self._drawn(asked))
        return replace(kept, targets=asked.spec.targets(asked.timing))

    def _drawn(self, asked: FlightRange) -> FlightInputs:
        flights = range(asked.first, asked.last)
        return sample_scenarios(asked.spec, asked.vehicle, asked.timing, self._root, asked.stream, flights)

    def _injected(self, asked: FlightRange, injection: Injection) -> np.ndarray | None:
        """Return the injected accelerations in lanes (blocks, K, 6, lanes), None where there are none."""
        steps, h = asked.spec.steps(asked.timing), asked.timing.control_period
        stream = f"{asked.stream}/{asked.spec.name}/air"
        key = (stream, steps, asked.first, asked.last)
        normals = self._remembered(key, lambda: self._normals(stream, steps, range(asked.first, asked.last)))
        factor = gate(np.arange(steps, dtype=np.float64) * h, asked.spec.air.window)
        added = np.stack([shape_injection(injection, h, factor, row) for row in normals])
        return to_lanes(added) if added.any() else None

    def _normals(self, stream: str, steps: int, flights: range) -> list[np.ndarray]:
        return [injection_normals(steps, generator(self._root, stream, i)) for i in flights]

    def _remembered(self, key: Any, draw: Callable[[], Any]) -> Any:
        """Return what is kept under a key, drawn now if it is not; what was asked for longest ago is forgotten.

        Two threads that miss the same key at once both draw it, and draw the same.
        """
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        drawn = draw()
        with self._lock:
            self._kept[key] = drawn
            while len(self._kept) > KEPT:
                self._kept.popitem(last=False)
        return drawn


assert INJECTED.start >= WIND_COLUMNS, "wind stands before what is injected"
