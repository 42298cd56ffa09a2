"""The limit function of an event: flights from standard normals."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from objectives.flown_system import FlownSystem, OnFlightsDone, Scenario
from objectives.problem import chunk_size
from plant.backends.flyer import FlightInputs
from plant.backends.lane_layout import LANES
from plant.threads import available_threads
from tuner.extensions.tails.events import Event
from tuner.extensions.tails.normals import NormalSpace

AT_ONCE = 2 * LANES
"""Flights that a thread draws at once, of 1 MB each: half as many took a fifth longer where flights are short, most of it their
trim, and twice as many save no time."""


def space_of(system: FlownSystem, spec: Scenario) -> NormalSpace:
    """Return the Gaussian space of the flights of a scenario."""
    return NormalSpace.of(lambda source: system.draw(spec, source, [0]))


def inputs_of(system: FlownSystem, spec: Scenario, space: NormalSpace, normals: np.ndarray) -> FlightInputs:
    """Return the flights of vectors of normals (n, dimension)."""
    return system.draw(spec, space.source(normals), range(len(normals)))


class FlightLimit:
    """Limit function of an event in flights of a gains row (g,).

    A flight has the same bits whatever flies with it, so threads change nothing.

    Attributes:
        flyer: Flyer of its flights.
        space: Space of all random numbers.
        names_of_draws: Names of single random numbers, by part.

    """

    def __init__(
        self, event: Event, spec: Scenario, gains: np.ndarray, threads: int | None, on_flights_done: OnFlightsDone
    ) -> None:
        self._event, self._spec, self._gains = event, spec, gains[None]
        self._threads = threads or available_threads()
        self._on_flights_done = on_flights_done
        self.flyer = event.system.flyer(self._threads)
        self.space = space_of(event.system, spec)
        self.names_of_draws = event.system.names_of_draws(spec)

    @property
    def dimension(self) -> int:
        """Number of normals of a flight."""
        return self.space.dimension

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of the event's modes."""
        return self._event.modes

    def values(self, normals: np.ndarray) -> np.ndarray:
        """Return demand over capacity (n, modes) of normals (n, dimension)."""
        share = -(-len(normals) // (self._threads * LANES)) * LANES
        each = min(max(share, LANES), AT_ONCE, chunk_size(self._spec.steps(self._event.system.timing)))
        parts = [normals[first : first + each] for first in range(0, len(normals), each)]
        with ThreadPoolExecutor(self._threads) as pool:
            return np.concatenate(list(pool.map(self._demands, parts)))

    def _demands(self, normals: np.ndarray) -> np.ndarray:
        system = self._event.system
        inputs = inputs_of(system, self._spec, self.space, normals)
        results = self.flyer.fly(self._gains, system.nominal, inputs)[0]
        self._on_flights_done(len(normals))
        return self._event.demands(results)
