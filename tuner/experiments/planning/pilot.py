"""The pilot: the default and a few other candidates, flown and timed on scenarios of their own stream."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from objectives.flown_system import FlightBatch
from objectives.problem import Problem
from objectives.requirements import known_values
from plant.backends.lane_layout import LANES
from plant.seeds import generator
from tuner.analysis.plant_step import estimated_plant_step
from tuner.documents.parts import PlantStep
from tuner.search.initial_design import initial_design, latin_hypercube
from tuner.store.flights import PendingFlights, encoded
from tuner.study.study import TuningStudy

Array = np.ndarray
PILOT = "plan"
# Flights of each candidate in each scenario, whole blocks of lanes; candidates at least; points asked how many are worth flying.
FLIGHTS, CANDIDATES, PROBES = 64, 8, 64


@dataclass(frozen=True)
class ScenarioPilot:
    """One scenario's part in the pilot of p candidates and q quantities.

    Attributes:
        scores: Scores (p, q, FLIGHTS).
        failed: Failures (p, FLIGHTS).
        block_seconds: Time of LANES flights on one thread, all threads being busy [s].
        draw_seconds: Time to draw one scenario [s].
        input_bytes: Size of one scenario drawn.
        stored_bytes: Size of one flight in the results folder.
    """

    spec: Any
    scores: Array
    failed: Array
    block_seconds: float
    draw_seconds: float
    input_bytes: float
    stored_bytes: float


@dataclass(frozen=True)
class Pilot:
    """The pilot of a run.

    Attributes:
        points: Points (p, d), the default first.
        worthy_share: Share of the ranges that is flown, as far as requirements decide it.
        screen_seconds: Time to evaluate the requirements of one candidate [s].
        rows: Number of results of a flight.
        plant_step: Error of the plant's step in the default's flights.
        seconds: Time that the pilot took [s].
    """

    points: Array
    scenarios: tuple[ScenarioPilot, ...]
    worthy_share: float
    screen_seconds: float
    rows: int
    threads: int
    plant_step: PlantStep
    seconds: float

    @property
    def complete(self) -> Array:
        """Candidates (p,) that lost no flight."""
        return ~np.any([entry.failed.any(axis=1) for entry in self.scenarios], axis=0)

    @property
    def flights(self) -> int:
        """Number of flights made."""
        return len(self.points) * FLIGHTS * len(self.scenarios)


def pilot_size(threads: int) -> int:
    """Return the number of pilot candidates: as many for every thread, at least CANDIDATES in all."""
    return threads * -(-CANDIDATES // threads)


def fly_pilot(problem: Problem, study: TuningStudy, on_flights_done: Callable[[int], None] | None = None) -> Pilot:
    """Draw candidates that are worth a flight, fly and time them; the kernel must be compiled already."""
    begin, threads = perf_counter(), problem.flyer.threads
    excess = problem.excess if study.requirements else None
    draw = generator(study.seed, "plan/candidates", 0)
    default = study.space.point(study.default_row)[None]
    if study.space.variables:
        points = initial_design(default, pilot_size(threads), draw, excess)
        probes = latin_hypercube(PROBES, points.shape[1], generator(study.seed, "plan/worthy", 0))
        share = 1.0 if excess is None else float(np.mean(problem.worth_flying(probes), axis=0))
    else:
        points, share = np.repeat(default, pilot_size(threads), axis=0), 1.0
    # The default row itself: a gain outside its searched range would be moved by the way through the unit cube.
    gains = np.concatenate([study.default_row[None], study.space.gains(points[1:])], axis=0)
    started = perf_counter()
    known_values(study.screens, gains)
    screening = (perf_counter() - started) / len(gains)
    flown = tuple(_fly_scenario(problem, study, entry.spec, gains, on_flights_done) for entry in study.scenarios)
    plant_step = estimated_plant_step(problem, study, gains[:1])
    return Pilot(points, flown, share, screening, problem.flyer.rows, threads, plant_step, perf_counter() - begin)


def _fly_scenario(
    problem: Problem, study: TuningStudy, spec: Any, gains: Array, on_flights_done: Callable[[int], None] | None
) -> ScenarioPilot:
    system, begin = study.system, perf_counter()
    inputs = system.sample(spec, study.seed, PILOT, range(FLIGHTS))
    drawn = perf_counter()
    results = problem.flyer.fly(gains, system.nominal, inputs, on_flights_done)
    flown = perf_counter()
    scores, failed = problem.score(results, spec)
    blocks = len(gains) / problem.flyer.threads * FLIGHTS / LANES
    held = sum(part.nbytes for part in (inputs.dynamics, inputs.disturbances, inputs.noises))
    columns = tuple(gain.address for gain in system.gains)
    stored = len(
        encoded(
            [PendingFlights("pilot", FlightBatch(spec, PILOT, FLIGHTS), gains, 0, results)],
            columns,
            problem.system.loop.results,
        )
    )
    return ScenarioPilot(
        spec,
        scores,
        failed,
        (flown - drawn) / blocks,
        (drawn - begin) / FLIGHTS,
        held / FLIGHTS,
        stored / (len(gains) * FLIGHTS),
    )
