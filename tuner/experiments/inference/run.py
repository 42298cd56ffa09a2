"""An inference: search the settings, look around the best, check on held-out flights, write down."""

from dataclasses import replace

import numpy as np

from objectives.problem import Evaluation
from plant.quadrotor.scenarios import SEARCH
from plant.seeds import generator
from tuner.experiments.experiment import Experiment
from tuner.experiments.inference import misfit
from tuner.experiments.inference.document import inference_document
from tuner.experiments.inference.findings import Findings, checked_findings
from tuner.experiments.inference.flying import SettingFlyer
from tuner.experiments.inference.record import SettingStore
from tuner.experiments.inference.refine import DAMPINGS, ROUNDS, Jacobian, refine
from tuner.experiments.inference.tables import candidates_table, settings_table, with_values
from tuner.experiments.tuning.tables import history_table
from tuner.report.contest import write_inference_figures, write_inference_report
from tuner.search.initial_design import initial_design
from tuner.search.loop import Generation, search_generations
from tuner.search.registry import SEARCHES
from tuner.search.watcher import REFINING, SEARCHING, Watcher, compilation
from tuner.store.advice import INFERENCE
from tuner.store.folder import Folder
from tuner.study.inference import Inference
from tuner.text.toml_text import toml_text

# Values of each unknown in the sweep, the others at the best setting: a search clusters, and would make unknowns without effect
# look as if they had one.
SWEEP = 9


class InferenceRun(Experiment[Inference, Findings]):
    """An inference in a results folder; every generation is on disk before the next one flies.

    Settings that are in the folder already are not flown again: one that was stopped goes on where it was.
    """

    kind = INFERENCE
    draw_figures = staticmethod(write_inference_figures)
    draw_page = staticmethod(write_inference_report)

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
        """Compile the kernels (once for each pair of laws) before anything is timed."""
        if self.flyer.cached:
            return
        with compilation(self.watcher):
            self.flyer.fly(np.array(self.study.space.base)[None], SEARCH, 1)

    def fly(self) -> Findings:
        """Search the settings, refine the best and check it on held-out flights."""
        inference, flyer, watcher = self.study, self.flyer, self.watcher
        spec = inference.search
        each = flyer.flights_of(inference.flights)
        watcher.on_stage(SEARCHING, spec.generations * spec.population * each)
        generations, parts = search(flyer, inference, self.folder, watcher)
        watcher.on_stage(REFINING, most_around(len(inference.unknowns)) * each)
        settings, jacobian = around_best(flyer, inference, misfit.concatenate(parts), watcher)
        return checked_findings(flyer, inference, generations, settings, jacobian, watcher, self.begin)

    def write_documents(self, result: Findings) -> None:
        """Write tables, numbers, and the study with the inferred values."""
        inference, folder = self.study, self.folder
        folder.write_table("history.csv", history_table(result.generations))
        folder.write_table("candidates.npz", candidates_table(result))
        values = with_values(inference, result.settings.values[result.chosen], folder)
        folder.write_text("inferred.toml", toml_text(values))
        folder.write_json("inference.json", inference_document(result))


def search(
    flyer: SettingFlyer, inference: Inference, folder: Folder, watcher: Watcher
) -> tuple[list[Generation], list[misfit.EvaluatedSettings]]:
    """Search the settings and record each generation."""
    spec, space, seed = inference.search, inference.space, inference.contest.seed
    start = space.point(np.array(space.base))[None]
    first = initial_design(start, spec.population, generator(seed, "inference/initial", 0))
    draw = int(generator(seed, "inference/algorithm", 0).integers(2**31))
    algorithm = SEARCHES[spec.algorithm](first, len(inference.kinds), 0, draw)
    parts: list[misfit.EvaluatedSettings] = []
    flyer.spared = watcher.on_flights_skipped

    def evaluate(points: np.ndarray) -> Evaluation:
        values = space.values(points)
        scores, failed = flyer.fly(values, SEARCH, inference.flights, watcher.on_flights_done)
        parts.append(misfit.evaluate_settings(inference, values, len(parts), scores, failed))
        return evaluation(inference, parts[-1], scores)

    generations = []
    for done in search_generations(algorithm, evaluate, spec.budget):
        # The loop counts one flight for a column of scores; here every contender flew it.
        record = replace(done[-1], flights=done[-1].flights * len(flyer.tasks))
        generations.append(record)
        name = f"generations/{record.number:04d}.npz"
        folder.write_table(name, settings_table(inference, parts[-1], spec.population * record.number))
        watcher.on_generation(record, spec.generations)
    return generations, parts


def evaluation(inference: Inference, settings: misfit.EvaluatedSettings, scores: np.ndarray) -> Evaluation:
    """Return the misfits as the objectives of a search without constraints."""
    none = np.zeros((len(settings.values), 0))
    origin = np.full(scores.shape[-1], "")
    flown = np.ones(len(none), dtype=bool)
    return Evaluation(settings.misfits(inference), none, settings.failures.mean(axis=1), scores, origin, none, flown)


def most_around(unknowns: int) -> int:
    """Return the largest number of settings that `around_best` flies."""
    return ROUNDS * (2 * unknowns + len(DAMPINGS)) + SWEEP * unknowns


def around_best(
    flyer: SettingFlyer, inference: Inference, before: misfit.EvaluatedSettings, watcher: Watcher
) -> tuple[misfit.EvaluatedSettings, Jacobian]:
    """Refine the best setting, then sweep each unknown through its range.

    Returns all settings flown and the Jacobian at the best.
    """
    space = inference.space

    def fly(points: np.ndarray) -> misfit.EvaluatedSettings:
        values = space.values(points)
        scores, failed = flyer.fly(values, SEARCH, inference.flights, watcher.on_flights_done)
        return misfit.evaluate_settings(inference, values, misfit.LOCAL_REFINEMENT, scores, failed)

    settings, jacobian = refine(inference, space.point(best_of(inference, before)), before, fly)
    points = np.tile(space.point(best_of(inference, settings)), (len(space.variables), SWEEP, 1))
    for i in range(len(space.variables)):
        points[i, :, i] = np.linspace(0.0, 1.0, SWEEP)
    return misfit.concatenate([settings, fly(points.reshape(-1, len(space.variables)))]), jacobian


def best_of(inference: Inference, settings: misfit.EvaluatedSettings) -> np.ndarray:
    """Return the setting (unknowns,) of least misfit."""
    return settings.values[misfit.best_row(settings.misfits(inference))]
