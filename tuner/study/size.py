"""Largest size of a run: beyond it a digit slipped, and the run would fill the memory or not end."""

from collections.abc import Iterable
from typing import NamedTuple

from plant.errors import InputError
from plant.loop import Timing
from plant.quadrotor.scenarios import ScenarioSpec

MAX_FLIGHTS = 1_000_000
"""Flights of one candidate in one scenario."""
MAX_POPULATION, MAX_CANDIDATES = 10_000, 1_000_000
MAX_STEPS = 1e12
"""Plant steps of all flights: more than a day on one thread at ten million a second."""
# Candidates that fly held-out scenarios, about.
CHECKED = 50


class ScenarioSize(NamedTuple):
    """A scenario: plant steps of a flight, flights of a candidate in the search and in the held-out check."""

    steps: float
    search: int
    held_out: int


def flight_steps(spec: ScenarioSpec, timing: Timing) -> float:
    """Return the plant steps of a flight."""
    return spec.duration / timing.plant_step


def check_candidates(population: int, generations: int) -> int:
    """Return the number of candidates of a search; InputError with the key inside [search] where it is out of all proportion."""
    if population > MAX_POPULATION:
        raise InputError(f"given {population}; allowed: up to {MAX_POPULATION:,}", key="population")
    candidates = population * generations
    if candidates > MAX_CANDIDATES:
        message = f"{generations} generations of {population} are {candidates:,} candidates; allowed: up to {MAX_CANDIDATES:,}"
        raise InputError(message, key="generations")
    return candidates


def check_size(population: int, generations: int, scenarios: Iterable[ScenarioSize]) -> None:
    """Refuse a run that is out of all proportion; InputError with the key inside [search]."""
    candidates = check_candidates(population, generations)
    each = list(scenarios)
    flights = sum(candidates * entry.search + CHECKED * entry.held_out for entry in each)
    steps = sum(entry.steps * (candidates * entry.search + CHECKED * entry.held_out) for entry in each)
    if steps > MAX_STEPS:
        raise InputError(
            f"about {flights:,} flights of {steps:.1e} plant steps in all; allowed: up to {MAX_STEPS:.0e} steps: make "
            "population, generations, or search, held_out or duration of a [[scenario]] smaller"
        )
