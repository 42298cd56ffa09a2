"""A study from beginning to end: search, re-fly the finalists on held-out scenarios, pick, write everything down."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from objectives.engine import Engine
from objectives.memory import FlightMemory
from objectives.problem import Evaluation, Problem
from objectives.racing import Champions, race
from plant.gains import gain_addresses
from plant.input_files import read_input_text
from plant.scenarios import HELD_OUT, SEARCH
from plant.seeds import generator
from tuner.documents.ending import gains_name
from tuner.experiments.tuning.conclusion import batches, conclude
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.starts import starting_points
from tuner.experiments.tuning.summary import summary_document
from tuner.experiments.tuning.tables import front_table, generation_table, history_table
from tuner.search.first_generation import first_generation
from tuner.search.loop import Generation, Search, archive, search_generations
from tuner.search.registry import SEARCHES
from tuner.search.watcher import SEARCHING, Watcher, compilation
from tuner.store.advice import TUNING
from tuner.store.clock import Clock, Spent, recorded
from tuner.store.environment import environment, with_session
from tuner.store.flights import FlightStore
from tuner.store.folder import Folder
from tuner.store.inputs import freeze
from tuner.store.start import FILE as START
from tuner.store.start import read_start, write_start
from tuner.study.study import Study


def run_study(
    study: Study,
    folder: Folder,
    watcher: Watcher,
    threads: int | None = None,
    reuse: tuple[Path, ...] = (),
    engine: Engine | None = None,
) -> Outcome:
    """Run a study in a results folder; every generation is on disk before the next one flies.

    Flights that are in the folder already, or in the results folders `reuse`, are not flown again: a run that was stopped goes
    on where it was, and ends with the bits that it would have ended with. engine: who flies, this machine unless given.
    """
    begin, clock = perf_counter(), Clock()
    store = flight_store(study, folder, reuse)
    problem = problem_of(study, threads, store, engine)
    write_inputs(study, folder, problem)
    for name in store.damaged:
        watcher.on_warning(f"{name} is damaged; it is not used, and what it held is flown again.")
    if store.generations < study.search.generations:
        warm_up(problem, study, watcher)
    first, said = first_points(problem, study, folder)
    generations = search(problem, study, folder, watcher, algorithm_of(study, first), clock)
    begin -= max(generations[-1].seconds - (perf_counter() - begin), 0.0)
    outcome = conclude(problem, study, generations, watcher, begin, said)
    store.commit(HELD_OUT)
    write_outcome(outcome, folder, watcher)
    folder.seal()
    return outcome


def problem_of(study: Study, threads: int | None, memory: FlightMemory | None, engine: Engine | None = None) -> Problem:
    """Return the problem that a study poses."""
    return Problem(
        study.system, study.space, study.objectives, study.constraints, study.seed, threads, study.screens, memory,
        engine,
    )  # fmt: skip


def flight_store(study: Study, folder: Folder | None, others: tuple[Path, ...] = ()) -> FlightStore:
    """Return the flights of a study in its results folder and in others."""
    columns = tuple(gain.address for gain in gain_addresses(study.system.cascade))
    return FlightStore(folder, columns, others)


def warm_up(problem: Problem, study: Study, watcher: Watcher) -> None:
    """Have the kernel compiled (once for a combination of laws) before anything is timed."""
    ready = problem.flyer.cached and problem.engine.ready(batches(study, SEARCH)[0])
    if ready and not (study.table.margin and _margins_are_cold()):
        return
    with compilation(watcher):
        problem.warm_up(study.default_row, study.scenarios[0].spec)


def _margins_are_cold() -> bool:
    from objectives.margins.curve import is_compiled

    return not is_compiled()


def first_points(problem: Problem, study: Study, folder: Folder) -> tuple[np.ndarray, list[str]]:
    """Return the first generation (n, d), as recorded or else made and recorded, and warnings about it."""
    known = read_start(folder.path, len(study.space.variables))
    if known is not None and folder.keep(START):
        return known
    starts, said = starting_points(study)
    worthy = problem.worth_flying if study.requirements else None
    first = first_generation(starts, study.search.population, generator(study.seed, "search/initial", 0), worthy)
    write_start(folder, first, said)
    return first, said


def algorithm_of(study: Study, first: np.ndarray) -> Search:
    """Return the search that a study asks for, seeded, at the beginning."""
    seed = int(generator(study.seed, "search/algorithm", 0).integers(2**31))
    limits = len(study.constraints) + len(study.requirements)
    return SEARCHES[study.search.algorithm](first, len(study.objectives), limits, seed)


def search(
    problem: Problem, study: Study, folder: Folder, watcher: Watcher, algorithm: Search, clock: Clock | None = None
) -> list[Generation]:
    """Run a search, whose very first candidate is the default, and record each generation."""
    clock = clock or Clock()
    spec, past = study.search, recorded(folder.path / "history.csv")
    each = sum(fleet.count for fleet in fleets(study, SEARCH))
    watcher.on_stage(SEARCHING, spec.generations * spec.population * each)
    problem.spared = watcher.on_flights_skipped
    generations: list[Generation] = []

    def evaluate(points: np.ndarray) -> Evaluation:
        # The very first candidate is the default: all others are measured by it, so it flies whatever it breaks.
        default, number = np.arange(len(points)) == 0 if not generations else False, len(generations)
        before = problem.flights_made
        evaluation = evaluated(problem, study, points, generations, watcher.on_flights_done, default)
        if number < len(past) and problem.flights_made == before:
            evaluation = as_recorded(evaluation, past, number)
            clock.at_least(past[number].seconds)
        if problem.memory:
            problem.memory.commit(f"{SEARCH}-{number:04d}")
        return evaluation

    for record in search_generations(algorithm, evaluate, spec.generations, clock.now):
        generations.append(record)
        folder.write_table(f"generations/{record.number:04d}.parquet", generation_table(study, generations, record))
        folder.write_table("history.csv", history_table(generations))
        watcher.on_generation(record, spec.generations)
    return generations


def evaluated(
    problem: Problem,
    study: Study,
    points: np.ndarray,
    before: list[Generation],
    on_flights_done: Callable[[int], None] | None = None,
    fly_all: bool | np.ndarray = False,
) -> Evaluation:
    """Evaluate a generation (n, d) on the search's scenarios, in a race against the best `before` it if the study asks so."""
    flown = batches(study, SEARCH)
    if not study.search.racing:
        return problem.evaluate(points, flown, on_flights_done, fly_all)
    return race(problem, points, flown, champions(before, len(study.objectives)), study.seed, on_flights_done, fly_all)


def champions(generations: list[Generation], objectives: int) -> Champions:
    """Return the front of the candidates so far that flew everything."""
    if not generations:
        return Champions(np.zeros((0, objectives)), np.zeros((0, objectives, 0)))
    found = archive(generations)
    front = found.front()
    scores = np.concatenate([entry.evaluation.scores for entry in generations], axis=0)
    front = front[np.concatenate([entry.evaluation.complete for entry in generations])[front]]
    return Champions(found.values[front], scores[front, :objectives])


def as_recorded(evaluation: Evaluation, past: list[Spent], number: int) -> Evaluation:
    """Return a replayed evaluation with the times that it took when it was flown."""
    before = past[number - 1] if number else Spent(0.0, 0.0, 0.0)
    here = past[number]
    return replace(
        evaluation,
        screening_seconds=here.screening - before.screening,
        flight_seconds=here.flights - before.flights,
    )


def write_inputs(study: Study, folder: Folder, problem: Problem, kind: str = TUNING) -> None:
    """Write what the run starts from; a resumed run adds its session to what is there."""
    if not folder.keep("study.toml"):
        folder.write_text("study.toml", read_input_text(study.path))
    folder.write_json("resolved.json", study.resolved())
    folder.write_json(
        "environment.json", with_session(folder.path / "environment.json", environment(problem.flyer.threads))
    )
    table = study.table.model_dump(mode="json", exclude_unset=True)
    freeze(folder, kind, study.path, table, study.digest(), study.search.generations, problem.engine.arithmetic)


def write_outcome(outcome: Outcome, folder: Folder, watcher: Watcher) -> None:
    """Write front, summary, gains, responses, margins, figures and report."""
    from tuner.experiments.tuning.run_margins import margin_table
    from tuner.report import start_figures, write_report

    drawing = start_figures(folder.path)
    try:
        write_contents(outcome, folder, watcher)
        drawing.begin()
        watcher.on_writing("margins")
        margins = margin_table(outcome)
        if margins is not None:
            folder.write_table("margins.parquet", margins)
        watcher.on_writing("report")
        write_report(folder.path)
        watcher.on_writing("figures")
        drawing.wait()
    except BaseException:
        drawing.stop()
        raise
    folder.written("report.html", "figures/*")


def write_contents(outcome: Outcome, folder: Folder, watcher: Watcher) -> None:
    """Write what the figures show: front, summary, responses; and gains."""
    from tuner.experiments.tuning.run_constraints import constraint_table
    from tuner.experiments.tuning.run_responses import response_table

    document: dict[str, Any] = summary_document(outcome)
    folder.write_table("front.csv", front_table(outcome))
    folder.remove(gains_name(not outcome.feasible))
    folder.write_json(gains_name(outcome.feasible), document.pop("gains_document"))
    folder.write_json("summary.json", document)
    watcher.on_writing("responses")
    folder.write_table("responses.parquet", response_table(outcome))
    if outcome.study.constraints:
        folder.write_table("constraints.csv", constraint_table(outcome))


def default_folder(study: Study) -> Path:
    """Return the folder a study's results go to unless another is given: results/NAME."""
    return Path("results") / study.path.stem
