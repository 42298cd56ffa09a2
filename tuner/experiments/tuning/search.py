"""The search of a study by generations; each is recorded before the next one flies."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from objectives.problem import Evaluation, Evaluator
from objectives.racing import Champions, race
from plant.errors import StoreError
from plant.quadrotor.scenarios import SEARCH
from plant.seeds import generator
from tuner.experiments.tuning.flight_growth import FlightGrowth
from tuner.experiments.tuning.limit_aim import LimitAim
from tuner.experiments.tuning.limit_watch import LimitWatch
from tuner.experiments.tuning.problem import first_batches
from tuner.experiments.tuning.starts import earlier_points, starting_points, surrounding_points
from tuner.experiments.tuning.tables import generation_table, history_table
from tuner.search.convergence import StoppingRule
from tuner.search.initial_design import initial_design
from tuner.search.loop import Archive, Generation, Review, Search, archive, search_generations
from tuner.search.names import ALGORITHMS
from tuner.search.registry import SEARCHES
from tuner.search.watcher import SEARCHING, BestValue, Watcher
from tuner.store.clock import Clock, ElapsedTimes, recorded
from tuner.store.flights import FlightStore
from tuner.store.folder import Folder
from tuner.store.start import FILE as START
from tuner.store.start import read_start, write_start
from tuner.study.study import SearchedStudy, TuningStudy


def flight_store(study: TuningStudy, folder: Folder | None, others: tuple[Path, ...] = ()) -> FlightStore:
    """Return the store of a study's flights in its folder and others."""
    columns = tuple(gain.address for gain in study.system.gains)
    return FlightStore(folder, columns, others, study.system.loop.results)


def first_points(problem: Evaluator, study: SearchedStudy, folder: Folder) -> tuple[np.ndarray, list[str]]:
    """Return the first generation (n, d) and warnings about it; made and recorded where there is none."""
    started = read_start(folder.path, len(study.space.variables))
    if started is not None and folder.keep(START):
        return started
    first, texts = first_generation(problem, study)
    write_start(folder, first, texts)
    return first, texts


def first_generation(problem: Evaluator, study: SearchedStudy) -> tuple[np.ndarray, list[str]]:
    """Return the first generation (n, d) and warnings about it."""
    starts, texts = starting_points(study)
    worthy, excess = (problem.worth_flying, problem.excess) if study.requirements else (None, None)
    earlier, spare, lost = earlier_points(study, starts, study.search.most_starts, worthy)
    around = surrounding_points(
        earlier, study.search.most_around_starts, generator(study.seed, "search/around", 0), worthy
    )
    starts = np.concatenate([starts, earlier, around])[: study.search.population]
    draw = generator(study.seed, "search/initial", 0)
    return initial_design(starts, study.search.population, draw, excess, spare), [*texts, *lost]


def algorithm_of(problem: Evaluator, study: SearchedStudy, first: np.ndarray) -> Search:
    """Return the search that a study asks for, seeded, at the beginning."""
    seed = int(generator(study.seed, "search/algorithm", 0).integers(2**31))
    limits = len(study.constraints) + len(study.requirements)
    name = study.search.algorithm
    started: dict[str, Any] = {"excesses": problem.excesses} if ALGORITHMS[name].screens and study.requirements else {}
    if study.search.reference:
        started["reference"] = study.search.reference_point(study.objectives)
    return SEARCHES[name](first, len(study.objectives), limits, seed, **started)


def search(
    problem: Evaluator,
    study: SearchedStudy,
    folder: Folder,
    watcher: Watcher,
    algorithm: Search,
    budget: StoppingRule,
    clock: Clock | None = None,
) -> list[Generation]:
    """Run a search and record each generation; its very first candidate is the default."""
    clock = clock or Clock()
    past = recorded(folder.path / "history.csv")
    each = sum(batch.count for batch in first_batches(study))
    watcher.on_stage(SEARCHING, budget.generations * study.search.population * each)
    problem.spared = watcher.on_flights_skipped
    generations: list[Generation] = []
    flights_before = problem.flights_made
    growth = FlightGrowth(problem, study, algorithm, watcher.on_flights_done)

    def review(done: Sequence[Generation]) -> list[Evaluation] | None:
        anew = growth.review(done)
        if anew is not None:
            watcher.on_message(growth.text)
        if problem.memory:
            problem.memory.commit(f"growth-{len(done):04d}")
        return anew

    def complete(evaluation: Evaluation) -> Evaluation:
        nonlocal flights_before
        number = len(generations)
        made, flights_before = problem.flights_made > flights_before, problem.flights_made
        if number < len(past) and not made:
            evaluation = as_recorded(evaluation, past, number)
            clock.at_least(past[number].seconds)
        if problem.memory:
            problem.memory.commit(f"{SEARCH}-{number:04d}")
        return evaluation

    flights_each = growth.study.search.first
    for generations in study_generations(growth, algorithm, budget, clock.now, complete, review):
        record = generations[-1]
        # With more flights, candidates of earlier generations have other values.
        written = [record] if growth.study.search.first == flights_each else generations
        flights_each = growth.study.search.first
        tables = {
            f"generations/{entry.number:04d}.npz": generation_table(study, generations[: entry.number + 1], entry)
            for entry in written
        }
        folder.write_tables({**tables, "history.csv": history_table(generations)})
        watcher.on_best_values(best_values(study, archive(generations)))
        watcher.on_generation(record, budget.generations)
    if len(generations) < budget.generations:
        watcher.on_message(
            f"The search has converged after {len(generations)} of at most {budget.generations} generations."
        )
    return generations


def best_values(study: SearchedStudy, tried: Archive) -> list[BestValue]:
    """Return the smallest feasible value of each objective next to the default's."""
    feasible = tried.flown & np.all(tried.violations <= 0.0, axis=1)
    best = tried.values[feasible].min(axis=0).tolist() if feasible.any() else [None] * len(study.objectives)
    return [
        BestValue(entry.label, entry.metric.unit, best[i], float(tried.values[0, i]), bool(feasible[0]))
        for i, entry in enumerate(study.objectives)
    ]


def study_generations(
    growth: FlightGrowth,
    algorithm: Search,
    budget: StoppingRule,
    now: Callable[[], float] | None = None,
    complete: Callable[[Evaluation], Evaluation] | None = None,
    review: Review | None = None,
) -> Iterator[list[Generation]]:
    """Yield all generations so far of a study's search, after each one.

    Args:
        growth: The number of flights that candidates make.
        algorithm: The search, at its beginning.
        budget: Number of generations.
        now: See `search_generations`.
        complete: See there.
        review: See there; the growth's unless given.
    """
    done: list[Generation] = []

    def evaluate(points: np.ndarray) -> Evaluation:
        # The very first candidate is the default: all others are measured by it, so it flies whatever it breaks.
        default = np.arange(len(points)) == 0 if not done else False
        return evaluated(growth.problem, growth.study, points, done, growth.on_flights_done, default)

    aim = LimitAim(LimitWatch(growth.problem, growth.study, growth.on_flights_done))
    for done in search_generations(algorithm, evaluate, budget, now, complete, review or growth.review, aim):
        yield done


def evaluated(
    problem: Evaluator,
    study: SearchedStudy,
    points: np.ndarray,
    before: list[Generation],
    on_flights_done: Callable[[int], None] | None = None,
    fly_all: bool | np.ndarray = False,
) -> Evaluation:
    """Evaluate a generation (n, d) on the search's scenarios.

    If the study asks for it, in a race against the best `before` it.
    """
    flown = first_batches(study)
    if not study.search.racing:
        return problem.evaluate(points, flown, on_flights_done, fly_all)
    return race(problem, points, flown, champions(before, len(study.objectives)), study.seed, on_flights_done, fly_all)


def champions(generations: list[Generation], objectives: int) -> Champions:
    """Return the front of the candidates so far that flew everything."""
    if not generations:
        return Champions(np.zeros((0, objectives)), np.zeros((0, objectives, 0)))
    tried = archive(generations)
    front = tried.front()
    scores = np.concatenate([entry.evaluation.scores for entry in generations], axis=0)
    front = front[np.concatenate([entry.evaluation.complete for entry in generations])[front]]
    return Champions(tried.values[front], scores[front, :objectives])


def as_recorded(evaluation: Evaluation, past: list[ElapsedTimes], number: int) -> Evaluation:
    """Return a replayed evaluation with the recorded times."""
    before = past[number - 1] if number else ElapsedTimes(0.0, 0.0, 0.0)
    flown_record = past[number]
    return replace(
        evaluation,
        screening_seconds=flown_record.screening - before.screening,
        flight_seconds=flown_record.flights - before.flights,
    )


def replayed(path: Path, study: SearchedStudy, problem: Evaluator, budget: StoppingRule) -> Iterator[list[Generation]]:
    """Yield all generations so far of a results folder, after each one.

    Flights that the problem's memory does not hold are flown.
    """
    started = read_start(path, len(study.space.variables))
    if started is None:
        raise StoreError(f"{path / START} is missing or damaged; `tuner resume {path}` writes it again")
    algorithm = algorithm_of(problem, study, started[0])
    yield from study_generations(FlightGrowth(problem, study, algorithm), algorithm, budget)
