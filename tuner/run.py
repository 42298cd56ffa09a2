"""A study from beginning to end: search, re-fly the finalists on held-out scenarios, pick, write everything down."""

from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from objectives.problem import Evaluation, Fleet, Problem
from plant.scenarios import SEARCH
from plant.seeds import generator
from tuner.conclusion import Outcome, conclude, fleets
from tuner.search.first_generation import first_generation
from tuner.search.loop import Generation, search_generations
from tuner.search.registry import SEARCHES
from tuner.search.starts import starting_points
from tuner.store.environment import environment
from tuner.store.folder import Folder
from tuner.store.tables import front_table, generation_table, history_table
from tuner.study.study import Study
from tuner.summary import summary_document
from tuner.watcher import Watcher


def run_study(study: Study, folder: Folder, watcher: Watcher, threads: int | None = None) -> Outcome:
    """Run a study into a new results folder; every generation is on disk before the next one flies."""
    begin = perf_counter()
    problem = Problem(
        study.system, study.space, study.objectives, study.constraints, study.seed, threads, study.screens
    )
    write_inputs(study, folder, problem.flyer.threads)
    warm_up(problem, study, watcher)
    starts, said = starting_points(study)
    generations = search(problem, study, folder, watcher, starts)
    outcome = conclude(problem, study, generations, watcher, begin, said)
    write_outcome(outcome, folder, watcher)
    return outcome


def warm_up(problem: Problem, study: Study, watcher: Watcher) -> None:
    """Have the kernel compiled (once for a combination of laws) before anything is timed."""
    if problem.flyer.cached:
        return
    watcher.compiling()
    begin = perf_counter()
    first = study.scenarios[0].spec
    problem.evaluate_gains(study.default_row[None], (Fleet(first, SEARCH, 1),), fly_all=True)
    watcher.compiled(perf_counter() - begin)


def search(problem: Problem, study: Study, folder: Folder, watcher: Watcher, starts: np.ndarray) -> list[Generation]:
    """Run the search from starting points (k, d), the default first, and record each generation."""
    spec = study.search
    worthy = problem.worth_flying if study.requirements else None
    first = first_generation(starts, spec.population, generator(study.seed, "search/initial", 0), worthy)
    seed = int(generator(study.seed, "search/algorithm", 0).integers(2**31))
    limits = len(study.constraints) + len(study.requirements)
    algorithm = SEARCHES[spec.algorithm](first, len(study.objectives), limits, seed)
    flown = fleets(study, SEARCH)
    watcher.searching(spec.generations, spec.generations * spec.population * sum(fleet.count for fleet in flown))
    generations: list[Generation] = []

    def evaluate(points: np.ndarray) -> Evaluation:
        # The very first candidate is the default: all others are measured by it, so it flies whatever it breaks.
        default = np.arange(len(points)) == 0 if not generations else False
        return problem.evaluate(points, flown, watcher.landed, fly_all=default)

    for record in search_generations(algorithm, evaluate, spec.generations):
        generations.append(record)
        folder.write_table(f"generations/{record.number:04d}.parquet", generation_table(study, generations, record))
        folder.write_table("history.csv", history_table(generations))
        watcher.generation(record)
    return generations


def write_inputs(study: Study, folder: Folder, threads: int) -> None:
    """Write what the run starts from."""
    folder.write_text("study.toml", study.path.read_text(encoding="utf-8"))
    folder.write_json("resolved.json", study.resolved())
    folder.write_json("environment.json", environment(threads))


def write_outcome(outcome: Outcome, folder: Folder, watcher: Watcher) -> None:
    """Write front, summary, gains, responses, figures and report."""
    from tuner.report import write_figures, write_report
    from tuner.run_responses import response_table

    document: dict[str, Any] = summary_document(outcome)
    folder.write_table("front.csv", front_table(outcome))
    folder.write_json("gains.json", document.pop("gains_document"))
    folder.write_json("summary.json", document)
    watcher.writing("responses")
    folder.write_table("responses.parquet", response_table(outcome))
    watcher.writing("figures")
    write_figures(folder.path)
    watcher.writing("report")
    write_report(folder.path)


def default_folder(study: Study) -> Path:
    """Return the folder a study's results go to unless another is given: results/NAME."""
    return Path("results") / study.path.stem
