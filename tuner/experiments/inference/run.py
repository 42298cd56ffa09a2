"""An inference: search the settings, look around the best, check on held-out flights, write down."""

from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from objectives.problem import Evaluation
from plant.scenarios import HELD_OUT, SEARCH
from plant.seeds import generator
from tuner.experiments.experiment import Experiment
from tuner.experiments.inference.findings import Findings
from tuner.experiments.inference.flying import SettingFlyer
from tuner.experiments.inference.misfit import (
    LOCAL_REFINEMENT,
    EvaluatedSettings,
    best_row,
    concatenate,
    evaluate_settings,
    front,
)
from tuner.experiments.inference.ranges import ranges
from tuner.experiments.inference.record import SettingStore
from tuner.experiments.inference.refine import DAMPINGS, ROUNDS, Slope, refined
from tuner.experiments.inference.writing import settings_table, write_findings
from tuner.search.first_generation import first_generation
from tuner.search.loop import Generation, search_generations
from tuner.search.registry import SEARCHES
from tuner.search.watcher import CHECKING, REFINING, SEARCHING, Watcher, compilation
from tuner.store.advice import INFERENCE
from tuner.store.folder import Folder
from tuner.study.inference import Inference

# Values of each unknown that the sweep tries, the others standing at the best setting: a search crowds together, and would
# leave what does not matter looking as if it did.
SWEEP = 9
# Settings of the front that are flown again at most; a longer one is thinned evenly along its first misfit.
MOST_CHECKED = 12


class InferenceRun(Experiment[Inference, Findings]):
    """An inference in a results folder; every generation is on disk before the next one flies.

    Settings that are in the folder already are not flown again: one that was stopped goes on where it was.
    """

    kind = INFERENCE

    def prepare(self) -> None:
        """Index the settings on record and build what flies them."""
        names = tuple(unknown.variable.name for unknown in self.study.unknowns)
        self.settings = SettingStore(self.folder, names, len(self.study.cells))
        self.flyer = SettingFlyer(self.study, self.threads, self.settings)

    @property
    def damaged(self) -> list[str]:
        """Names of damaged files of settings."""
        return self.settings.damaged

    def resolved(self) -> None:
        """Return nothing: the contest that is flown changes with the setting."""

    def warm_up(self) -> None:
        """Have the kernels compiled (once for each pair of laws) before anything is timed."""
        if self.flyer.cached:
            return
        with compilation(self.watcher):
            self.flyer.fly(np.array(self.study.space.base)[None], SEARCH, 1)

    def fly(self) -> Findings:
        """Search the settings, refine the best and check it on held-out flights."""
        inference, flyer, watcher = self.study, self.flyer, self.watcher
        spec = inference.contest.base.search
        each = flyer.flights_of(inference.flights)
        watcher.on_stage(SEARCHING, spec.generations * spec.population * each)
        generations, parts = search(flyer, inference, self.folder, watcher)
        watcher.on_stage(REFINING, most_around(len(inference.unknowns)) * each)
        found, slope = around_best(flyer, inference, concatenate(parts), watcher)
        return check(flyer, inference, generations, found, slope, watcher, self.begin)

    def write_documents(self, found: Findings) -> None:
        """Write tables, numbers, and the study with the inferred values."""
        write_findings(found, self.folder)

    @staticmethod
    def draw(path: Path, watcher: Watcher) -> None:
        """Draw figures and report."""
        from tuner.report.contest import write_inference_report
        from tuner.report.inference_figure import write_inference_figures

        watcher.on_writing("figures")
        write_inference_figures(path)
        watcher.on_writing("report")
        write_inference_report(path)


def run_inference(
    inference: Inference, folder: Folder, watcher: Watcher | None = None, threads: int | None = None
) -> Findings:
    """Carry out an inference in a results folder, see `InferenceRun`."""
    return InferenceRun(inference, folder, watcher, threads).carry_out()


def search(
    flyer: SettingFlyer, inference: Inference, folder: Folder, watcher: Watcher
) -> tuple[list[Generation], list[EvaluatedSettings]]:
    """Search the settings and record each generation."""
    spec, space, seed = inference.contest.base.search, inference.space, inference.contest.seed
    start = space.point(np.array(space.base))[None]
    first = first_generation(start, spec.population, generator(seed, "inference/initial", 0))
    draw = int(generator(seed, "inference/algorithm", 0).integers(2**31))
    algorithm = SEARCHES[spec.algorithm](first, len(inference.kinds), 0, draw)
    parts: list[EvaluatedSettings] = []
    flyer.spared = watcher.on_flights_skipped

    def evaluate(points: np.ndarray) -> Evaluation:
        values = space.values(points)
        scores, failed = flyer.fly(values, SEARCH, inference.flights, watcher.on_flights_done)
        parts.append(evaluate_settings(inference, values, len(parts), scores, failed))
        return evaluation(inference, parts[-1], scores)

    generations = []
    for record in search_generations(algorithm, evaluate, spec.generations):
        # The loop counts one flight for a column of scores; here every contender flew it.
        record = replace(record, flights=record.flights * len(flyer.tasks))
        generations.append(record)
        name = f"generations/{record.number:04d}.parquet"
        folder.write_table(name, settings_table(inference, parts[-1], spec.population * record.number))
        watcher.on_generation(record, spec.generations)
    return generations, parts


def evaluation(inference: Inference, settings: EvaluatedSettings, scores: np.ndarray) -> Evaluation:
    """Return the misfits as the objectives of a search without constraints."""
    none = np.zeros((len(settings.values), 0))
    origin = np.full(scores.shape[-1], "")
    flown = np.ones(len(none), dtype=bool)
    return Evaluation(settings.misfits(inference), none, settings.failures.mean(axis=1), scores, origin, none, flown)


def most_around(unknowns: int) -> int:
    """Return how many settings `around_best` flies at most."""
    return ROUNDS * (2 * unknowns + len(DAMPINGS)) + SWEEP * unknowns


def around_best(
    flyer: SettingFlyer, inference: Inference, before: EvaluatedSettings, watcher: Watcher
) -> tuple[EvaluatedSettings, Slope]:
    """Refine the best setting, then move one unknown after the other through its range, the others standing there.

    Returns all settings flown and the slope at the best.
    """
    space = inference.space

    def fly(points: np.ndarray) -> EvaluatedSettings:
        values = space.values(points)
        scores, failed = flyer.fly(values, SEARCH, inference.flights, watcher.on_flights_done)
        return evaluate_settings(inference, values, LOCAL_REFINEMENT, scores, failed)

    found, slope = refined(inference, space.point(best_of(inference, before)), before, fly)
    points = np.tile(space.point(best_of(inference, found)), (len(space.variables), SWEEP, 1))
    for i in range(len(space.variables)):
        points[i, :, i] = np.linspace(0.0, 1.0, SWEEP)
    return concatenate([found, fly(points.reshape(-1, len(space.variables)))]), slope


def best_of(inference: Inference, found: EvaluatedSettings) -> np.ndarray:
    """Return the setting (unknowns,) of least misfit."""
    return found.values[best_row(found.misfits(inference))]


def check(
    flyer: SettingFlyer,
    inference: Inference,
    generations: list[Generation],
    found: EvaluatedSettings,
    slope: Slope,
    watcher: Watcher,
    begin: float,
) -> Findings:
    """Choose the inferred setting and fly it, the default and the front on held-out flights."""
    values = found.misfits(inference)
    chosen, most, shown = best_row(values), most_inside(inference, found), thinned(values, front(values))
    rows = np.array([0, chosen, most, *shown])
    watcher.on_stage(CHECKING, len(rows) * flyer.flights_of(inference.held_out))
    scores, failed = flyer.fly(found.values[rows], HELD_OUT, inference.held_out, watcher.on_flights_done)
    checked = evaluate_settings(inference, found.values[rows], LOCAL_REFINEMENT, scores, failed)
    told = ranges(inference, found, chosen, slope, scores[1])
    flown = len(found.values) * flyer.flights_of(inference.flights)
    flights = flown + len(rows) * flyer.flights_of(inference.held_out)
    return Findings(
        inference, generations, found, chosen, most, shown, checked, scores[0], scores[1], told, flights,
        perf_counter() - begin,
    )  # fmt: skip


def most_inside(inference: Inference, found: EvaluatedSettings) -> int:
    """Return the setting under which the most published cells lie inside at once; of equals the one of least misfit."""
    counts = found.inside.sum(axis=1)
    best = np.flatnonzero(counts == counts.max(axis=0))
    return int(best[np.argmin(found.overall(inference)[best])])


def thinned(values: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return at most MOST_CHECKED of the rows of misfits (n, kinds), in the order of the first."""
    rows = rows[np.argsort(values[rows, 0], kind="stable")]
    keep = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), MOST_CHECKED)).round().astype(int))
    return rows[keep]
