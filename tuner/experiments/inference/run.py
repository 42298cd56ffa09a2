"""An inference from beginning to end: search the settings, look around the best, check on held-out flights, write down."""

from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from objectives.problem import Evaluation
from plant.scenarios import HELD_OUT, SEARCH
from plant.seeds import generator
from tuner.experiments.inference.experiment import Experiment
from tuner.experiments.inference.findings import Findings
from tuner.experiments.inference.ranges import ranges
from tuner.experiments.inference.record import Settings
from tuner.experiments.inference.refine import DAMPINGS, ROUNDS, Slope, refined
from tuner.experiments.inference.tried import AROUND, Tried, front, inferred, joined, tried
from tuner.search.first_generation import first_generation
from tuner.search.loop import Generation, search_generations
from tuner.search.registry import SEARCHES
from tuner.search.watcher import CHECKING, REFINING, SEARCHING, Watcher, compilation
from tuner.store.folder import Folder
from tuner.study.inference import Inference

# Values of each unknown that the sweep tries, the others standing at the best setting: a search crowds together, and would
# leave what does not matter looking as if it did.
SWEEP = 9
# Settings of the front that are flown again at most; a longer one is thinned evenly along its first misfit.
MOST_CHECKED = 12


def run_inference(inference: Inference, folder: Folder, watcher: Watcher, threads: int | None = None) -> Findings:
    """Run an inference in a results folder; every generation is on disk before the next one flies.

    Settings that are in the folder already are not flown again: one that was stopped goes on where it was.
    """
    from tuner.experiments.inference.writing import write_findings, write_inputs

    begin = perf_counter()
    names = tuple(unknown.variable.name for unknown in inference.unknowns)
    settings = Settings(folder, names, len(inference.cells))
    for name in settings.damaged:
        watcher.on_warning(f"{name} is damaged; it is not used, and what it held is flown again.")
    experiment = Experiment(inference, threads, settings)
    write_inputs(inference, folder, experiment.threads)
    warm_up(experiment, inference, watcher)
    spec = inference.contest.base.search
    each = experiment.flights_of(inference.flights)
    watcher.on_stage(SEARCHING, spec.generations * spec.population * each)
    generations, parts = search(experiment, inference, folder, watcher)
    watcher.on_stage(REFINING, most_around(len(inference.unknowns)) * each)
    found, slope = around_best(experiment, inference, joined(parts), watcher)
    findings = check(experiment, inference, generations, found, slope, watcher, begin)
    write_findings(findings, folder, watcher)
    folder.seal()
    return findings


def warm_up(experiment: Experiment, inference: Inference, watcher: Watcher) -> None:
    """Have the kernels compiled (once for each pair of laws) before anything is timed."""
    if experiment.cached:
        return
    with compilation(watcher):
        experiment.fly(np.array(inference.space.base)[None], SEARCH, 1)


def search(
    experiment: Experiment, inference: Inference, folder: Folder, watcher: Watcher
) -> tuple[list[Generation], list[Tried]]:
    """Search the settings and record each generation."""
    from tuner.experiments.inference.writing import settings_table

    spec, space, seed = inference.contest.base.search, inference.space, inference.contest.seed
    start = space.point(np.array(space.base))[None]
    first = first_generation(start, spec.population, generator(seed, "inference/initial", 0))
    draw = int(generator(seed, "inference/algorithm", 0).integers(2**31))
    algorithm = SEARCHES[spec.algorithm](first, len(inference.kinds), 0, draw)
    parts: list[Tried] = []
    experiment.spared = watcher.on_flights_skipped

    def evaluate(points: np.ndarray) -> Evaluation:
        values = space.values(points)
        scores, failed = experiment.fly(values, SEARCH, inference.flights, watcher.on_flights_done)
        parts.append(tried(inference, values, len(parts), scores, failed))
        return evaluation(inference, parts[-1], scores)

    generations = []
    for record in search_generations(algorithm, evaluate, spec.generations):
        # The loop counts one flight for a column of scores; here every contender flew it.
        record = replace(record, flights=record.flights * len(experiment.tasks))
        generations.append(record)
        name = f"generations/{record.number:04d}.parquet"
        folder.write_table(name, settings_table(inference, parts[-1], spec.population * record.number))
        watcher.on_generation(record, spec.generations)
    return generations, parts


def evaluation(inference: Inference, settings: Tried, scores: np.ndarray) -> Evaluation:
    """Return the misfits as the objectives of a search without constraints."""
    none = np.zeros((len(settings.values), 0))
    origin = np.full(scores.shape[-1], "")
    flown = np.ones(len(none), dtype=bool)
    return Evaluation(settings.misfits(inference), none, settings.failures.mean(axis=1), scores, origin, none, flown)


def most_around(unknowns: int) -> int:
    """Return how many settings `around_best` flies at most."""
    return ROUNDS * (2 * unknowns + len(DAMPINGS)) + SWEEP * unknowns


def around_best(experiment: Experiment, inference: Inference, before: Tried, watcher: Watcher) -> tuple[Tried, Slope]:
    """Refine the best setting, then move one unknown after the other through its range, the others standing there.

    Returns all settings flown and the slope at the best.
    """
    space = inference.space

    def fly(points: np.ndarray) -> Tried:
        values = space.values(points)
        scores, failed = experiment.fly(values, SEARCH, inference.flights, watcher.on_flights_done)
        return tried(inference, values, AROUND, scores, failed)

    found, slope = refined(inference, space.point(best_of(inference, before)), before, fly)
    points = np.tile(space.point(best_of(inference, found)), (len(space.variables), SWEEP, 1))
    for i in range(len(space.variables)):
        points[i, :, i] = np.linspace(0.0, 1.0, SWEEP)
    return joined([found, fly(points.reshape(-1, len(space.variables)))]), slope


def best_of(inference: Inference, found: Tried) -> np.ndarray:
    """Return the setting (unknowns,) of least misfit."""
    return found.values[inferred(found.misfits(inference))]


def check(
    experiment: Experiment,
    inference: Inference,
    generations: list[Generation],
    found: Tried,
    slope: Slope,
    watcher: Watcher,
    begin: float,
) -> Findings:
    """Choose the inferred setting and fly it, the default and the front on held-out flights."""
    values = found.misfits(inference)
    chosen, most, shown = inferred(values), most_inside(inference, found), thinned(values, front(values))
    rows = np.array([0, chosen, most, *shown])
    watcher.on_stage(CHECKING, len(rows) * experiment.flights_of(inference.held_out))
    scores, failed = experiment.fly(found.values[rows], HELD_OUT, inference.held_out, watcher.on_flights_done)
    checked = tried(inference, found.values[rows], AROUND, scores, failed)
    told = ranges(inference, found, chosen, slope, scores[1])
    flown = len(found.values) * experiment.flights_of(inference.flights)
    flights = flown + len(rows) * experiment.flights_of(inference.held_out)
    return Findings(
        inference, generations, found, chosen, most, shown, checked, scores[0], scores[1], told, flights,
        perf_counter() - begin,
    )  # fmt: skip


def most_inside(inference: Inference, found: Tried) -> int:
    """Return the setting under which the most published cells lie inside at once; of equals the one of least misfit."""
    counts = found.inside.sum(axis=1)
    best = np.flatnonzero(counts == counts.max(axis=0))
    return int(best[np.argmin(found.overall(inference)[best])])


def thinned(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return at most MOST_CHECKED of the rows of misfits (n, kinds), in the order of the first."""
    rows = rows[np.argsort(values[rows, 0], kind="stable")]
    keep = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), MOST_CHECKED)).round().astype(int))
    return rows[keep]


def default_folder(inference: Inference) -> Path:
    """Return the folder the results go to unless another is given: results/NAME."""
    return Path("results") / inference.path.stem
