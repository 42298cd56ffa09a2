"""Sensitivity analysis of a study: its objectives on its search scenarios, the same ones for every sample."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np

from objectives.problem import Problem
from objectives.requirements import worth_flying
from plant.quadrotor.scenarios import SEARCH
from tuner.experiments.experiment import Experiment
from tuner.experiments.tuning.problem import batches, check_searched, problem_of, warm_up
from tuner.extensions.sensitivity.analysis import Analysis, Sampled, analyze
from tuner.extensions.sensitivity.design import checked_base
from tuner.extensions.sensitivity.document import SensitivityDocument
from tuner.extensions.sensitivity.tables import index_table, sample_table, sensitivity_document, variance_table
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.study import TuningStudy


@dataclass(frozen=True)
class AnalysisCost:
    """The cost of an analysis: candidates, flights and seconds, the last extrapolated from the flights of a few candidates."""

    candidates: int
    flights: int
    seconds: float


@dataclass(frozen=True)
class SensitivityOutcome:
    """An analysis and its document, the content of sensitivity.json."""

    analysis: Analysis
    document: SensitivityDocument


class SensitivityRun(Experiment[TuningStudy, SensitivityOutcome]):
    """A sensitivity analysis with `base` samples, with or without a results folder."""

    kind = "sensitivity"
    inside = "figures"
    resumable = False

    def __init__(
        self,
        study: TuningStudy,
        base: int,
        folder: Folder | None = None,
        watcher: Watcher | None = None,
        threads: int | None = None,
    ) -> None:
        super().__init__(study, folder, watcher, threads=threads)
        self.base = base
        self.problem = study_problem(study, threads)

    def warm_up(self) -> None:
        """Compile the kernel."""
        warm_up(self.problem, self.study, self.watcher)

    def fly(self) -> SensitivityOutcome:
        """Fly all samples and analyse what they give."""
        study, begin = self.study, perf_counter()
        expected = analysis_cost(self.problem, study, self.base)
        self.watcher.on_message(announcement(study, expected, self.base, self.problem.flyer.threads))
        self.watcher.on_stage("Sampling", expected.flights)
        analysis = study_sensitivity(self.problem, study, self.base, self.watcher.on_flights_done)
        return SensitivityOutcome(analysis, sensitivity_document(study, analysis, perf_counter() - begin))

    def write_documents(self, result: SensitivityOutcome) -> None:
        """Write sensitivity.json and the tables of indices, variances and samples."""
        self.folder.write_json("sensitivity.json", result.document)
        self.folder.write_table("indices.csv", index_table(self.study, result.analysis))
        self.folder.write_table("variance.csv", variance_table(self.study, result.analysis))
        self.folder.write_table("samples.csv", sample_table(self.study, result.analysis))

    def write(self, result: SensitivityOutcome) -> None:
        """Write documents, tables and the figure."""
        from tuner.extensions.sensitivity.figure import write_figure

        self.write_documents(result)
        write_figure(self.study, result.analysis, self.folder.path)
        self.folder.written("figures/*")


def analyse_sensitivity(
    study: TuningStudy,
    samples: int,
    out: Path | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> SensitivityOutcome:
    """Analyse a study, base number of samples a power of two; out: a new folder to write tables and figure to, or None.

    Raises InputError where the study searches nothing or the number is none.
    """
    base = checked_base(samples)
    check_searched(study)
    folder = None if out is None else Folder.create(out, inside=SensitivityRun.inside)
    return SensitivityRun(study, base, folder, watcher, threads).carry_out()


def announcement(study: TuningStudy, expected: AnalysisCost, base: int, threads: int) -> str:
    """Return the sentence on what is about to be flown."""
    flights = sum(entry.search for entry in study.scenarios)
    return (
        f"{base} base samples of {len(study.space.variables)} variables: {expected.candidates:,} candidates, "
        f"{flights} search scenarios each, {expected.flights:,} flights, about {expected.seconds:.0f} s on {threads} threads "
        f"(seed {study.seed})."
    )


def study_problem(study: TuningStudy, threads: int | None) -> Problem:
    """Return the problem of a study; InputError where it searches nothing."""
    check_searched(study)
    return problem_of(study, threads, None)


def analysis_cost(problem: Problem, study: TuningStudy, base: int) -> AnalysisCost:
    """Return the cost of `base` samples: from flights of one candidate per thread."""
    flown, threads = batches(study, SEARCH), problem.flyer.threads
    few = np.tile(study.default_row, (threads, 1))
    # Once for models and scenarios that are built when they are first needed.
    problem.evaluate_gains(few, flown, fly_all=True)
    begin = perf_counter()
    problem.evaluate_gains(few, flown, fly_all=True)
    each = (perf_counter() - begin) / threads
    candidates = base * (len(study.space.variables) + 2)
    return AnalysisCost(candidates, candidates * sum(batch.count for batch in flown), candidates * each)


def study_sensitivity(
    problem: Problem, study: TuningStudy, base: int, on_flights_done: Callable[[int], None] | None = None
) -> Analysis:
    """Analyse a study with `base` samples; on_flights_done(n) is called as n more flights end."""
    flown = batches(study, SEARCH)

    def evaluate(points: np.ndarray) -> Sampled:
        # All of the box is flown, also points that fail pre-screening: the indices need independent inputs.
        evaluation = problem.evaluate(points, flown, on_flights_done, fly_all=True)
        scores = tuple(evaluation.samples(i, objective.scenario) for i, objective in enumerate(study.objectives))
        passes_screening = worth_flying(study.requirements, evaluation.requirements)
        return Sampled(evaluation.values, evaluation.failures, passes_screening, scores)

    return analyze(base, len(study.space.variables), evaluate, study.seed)
