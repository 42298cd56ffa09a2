"""The run of a study whose trials another program runs: a tuning run, replayed for every list of pending trials.

Search, held-out check, choice, confirmation and report are those of every tuning run.
"""

from collections.abc import Callable
from typing import TypeAlias

from plant.errors import InputError
from tuner import report
from tuner.documents.parts import GainValue
from tuner.documents.summary import Summary, gains_name
from tuner.documents.variables import VariablesDocument
from tuner.experiments.experiment import Experiment
from tuner.experiments.tuning.conclusion import conclude
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.search import algorithm_of, first_points, search
from tuner.experiments.tuning.summary import summary_document
from tuner.experiments.tuning.tables import constraint_table, front_table
from tuner.extensions.trials.answers import ResultParser
from tuner.extensions.trials.problem import TrialProblem
from tuner.extensions.trials.record import REQUESTS_FILE, RESULTS_FILE, Trial, TrialRecord
from tuner.extensions.trials.study import TrialStudy
from tuner.search import bayesian_optimization, covariance
from tuner.search.names import ALGORITHMS
from tuner.search.watcher import compilation
from tuner.store.advice import RECORD, TRIALS
from tuner.store.clock import Clock
from tuner.store.folder import Folder

TrialOutcome: TypeAlias = Outcome[TrialStudy, TrialProblem]
TrialRunner: TypeAlias = Callable[[Trial, ResultParser], object]
"""Runs a trial and records its result."""
FIRST = ("study.toml", "resolved.json", "environment.json")
"""Files that a run writes once, before its first trials."""


class FixedClock(Clock):
    """A clock at 0: times of trials are not recorded, and a replayed run writes the same bytes."""

    def now(self) -> float:
        """Return 0."""
        return 0.0


class TrialRun(Experiment[TrialStudy, TrialOutcome]):
    """A study of trials in a results folder. make: runs each pending trial; without it the run stops at these."""

    kind = TRIALS
    draw_figures = staticmethod(report.write_figures)
    draw_page = staticmethod(report.write_report)
    make: TrialRunner | None = None

    @classmethod
    def check(cls, study: TrialStudy) -> None:
        """Raise InputError: another program runs the trials."""
        raise InputError(
            f"another program makes the trials of this study; `tuner ask {study.path}` prints those that are to be made, and "
            "`tuner tell` takes what they gave",
            file=study.path,
            key="trials",
        )

    def prepare(self) -> None:
        """Read the recorded trials and results."""
        self.record = TrialRecord(self.folder.path)
        self.problem = TrialProblem(self.study, self.record, self.answer if self.make else None)

    def warm_up(self) -> None:
        """Compile the model of the search where it has one."""
        if not ALGORITHMS[self.study.search.algorithm].screens:
            return
        if not covariance.is_compiled():
            with compilation(self.watcher):
                bayesian_optimization.warm_up()

    def answer(self, trials: list[Trial]) -> None:
        """Run trials, one after the other."""
        assert self.make is not None, "called only where something makes trials"
        answers = ResultParser(self.record, [metric.text for metric in self.study.metrics])
        for trial in trials:
            self.make(trial, answers)
            self.watcher.on_flights_done(1)

    def fly(self) -> TrialOutcome:
        """Replay search and conclusion; MissingResultError has the pending trials."""
        first, warnings = first_points(self.problem, self.study, self.folder)
        algorithm = algorithm_of(self.problem, self.study, first)
        generations = search(
            self.problem, self.study, self.folder, self.watcher, algorithm, self.study.search.budget, FixedClock()
        )
        return conclude(self.problem, self.study, generations, self.watcher, self.begin, warnings)

    @staticmethod
    def is_feasible(result: TrialOutcome) -> bool:
        """Return true where the run recommends a point."""
        return result.feasible

    def write_documents(self, result: TrialOutcome) -> None:
        """Write front, recommended values and summary."""
        folder = self.folder
        # Times are not recorded.
        summary = summary_document(result).model_copy(update={"wall_seconds": None, "search_seconds": None})
        folder.write_table("front.csv", front_table(result))
        folder.remove(gains_name(not result.feasible))
        folder.write_json(gains_name(result.feasible), variables_document(result, summary))
        folder.write_json("summary.json", summary)
        if result.study.constraints:
            folder.write_table("constraints.csv", constraint_table(result))
        folder.written(REQUESTS_FILE, RESULTS_FILE)

    def _write_inputs(self, folder: Folder) -> None:
        """Write the inputs once: later replays keep them."""
        if (folder.path / RECORD).exists():
            for name in (*FIRST, RECORD):
                folder.keep(name)
            folder.written("inputs/*")
            return
        super()._write_inputs(folder)


def variables_document(outcome: TrialOutcome, summary: Summary) -> VariablesDocument:
    """Return the variables of a summary's tuned point."""
    study = outcome.study
    values = zip(study.table.variable, outcome.gains(outcome.tuned).tolist(), strict=True)
    return VariablesDocument(
        format="gainproof-variables",
        version=1,
        study=study.path.name,
        title=study.title,
        digest=study.digest(),
        point=summary.shown,
        feasible=outcome.feasible,
        gains={variable.name: GainValue(value=value, unit=variable.unit) for variable, value in values},
    )
