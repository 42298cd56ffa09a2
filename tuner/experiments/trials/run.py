"""The run of a study whose trials another program makes: a tuning run that is replayed whenever it is asked what it lacks.

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
from tuner.experiments.trials.answers import Answers
from tuner.experiments.trials.problem import TrialProblem
from tuner.experiments.tuning.conclusion import conclude
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.search import algorithm_of, first_points, search
from tuner.experiments.tuning.summary import summary_document
from tuner.experiments.tuning.tables import constraint_table, front_table
from tuner.search import covariance, gaussian_process
from tuner.search.names import ALGORITHMS
from tuner.search.watcher import compilation
from tuner.store.advice import RECORD, TRIALS
from tuner.store.clock import Clock
from tuner.store.folder import Folder
from tuner.store.trials import ASKED, TOLD, Trial, TrialRecord
from tuner.study.trials import TrialStudy

TrialOutcome: TypeAlias = Outcome[TrialStudy, TrialProblem]
Make: TypeAlias = Callable[[Trial, Answers], object]
"""Makes a trial and has what it found taken."""
FIRST = ("study.toml", "resolved.json", "environment.json")
"""Files that a run writes once, before its first line is asked for."""


class Unhurried(Clock):
    """A clock that stands: when trials were made is not known, and a run that is asked again writes the same bytes."""

    def now(self) -> float:
        """Return 0."""
        return 0.0


class TrialRun(Experiment[TrialStudy, TrialOutcome]):
    """A study of trials in a results folder. make: has each trial made that is lacking; without it the run stops there."""

    kind = TRIALS
    draw_figures = staticmethod(report.write_figures)
    draw_page = staticmethod(report.write_report)
    make: Make | None = None

    @classmethod
    def check(cls, study: TrialStudy) -> None:
        """Refuse to run it alone: who makes the trials has to be asked."""
        raise InputError(
            f"another program makes the trials of this study; `tuner ask {study.path}` prints those that are to be made, and "
            "`tuner tell` takes what they gave",
            file=study.path, key="trials",
        )  # fmt: skip

    def prepare(self) -> None:
        """Read what was asked and told."""
        self.record = TrialRecord(self.folder.path)
        self.problem = TrialProblem(self.study, self.record, self.answer if self.make else None)

    def warm_up(self) -> None:
        """Have the model of the search compiled where it has one."""
        if not ALGORITHMS[self.study.search.algorithm].screens:
            return
        if not covariance.is_compiled():
            with compilation(self.watcher):
                gaussian_process.warm_up()

    def answer(self, trials: list[Trial]) -> None:
        """Have trials made, one after the other."""
        assert self.make is not None, "called only where something makes trials"
        answers = Answers(self.record, [metric.text for metric in self.study.metrics])
        for trial in trials:
            self.make(trial, answers)
            self.watcher.on_flights_done(1)

    def fly(self) -> TrialOutcome:
        """Replay the search and its conclusion as far as trials are told; UnansweredError has those that are lacking."""
        first, warnings = first_points(self.problem, self.study, self.folder)
        algorithm = algorithm_of(self.problem, self.study, first)
        generations = search(
            self.problem, self.study, self.folder, self.watcher, algorithm, self.study.search.budget, Unhurried()
        )
        return conclude(self.problem, self.study, generations, self.watcher, self.begin, warnings)

    @staticmethod
    def is_feasible(found: TrialOutcome) -> bool:
        """Whether the run recommends a point."""
        return found.feasible

    def write_documents(self, found: TrialOutcome) -> None:
        """Write the front, the recommended values and what was found."""
        folder = self.folder
        summary = trial_summary(found)
        folder.write_table("front.csv", front_table(found))
        folder.remove(gains_name(not found.feasible))
        folder.write_json(gains_name(found.feasible), variables_document(found, summary))
        folder.write_json("summary.json", summary)
        if found.study.constraints:
            folder.write_table("constraints.csv", constraint_table(found))
        folder.written(ASKED, TOLD)

    def _write_inputs(self, folder: Folder) -> None:
        """Write what the run starts from, once: every later look at the run finds it there."""
        if (folder.path / RECORD).exists():
            for name in (*FIRST, RECORD):
                folder.keep(name)
            folder.written("inputs/*")
            return
        super()._write_inputs(folder)


def trial_summary(found: TrialOutcome) -> Summary:
    """Return summary.json, without times: nobody here knows how long the trials took."""
    return summary_document(found).model_copy(update={"wall_seconds": None, "search_seconds": None})


def variables_document(found: TrialOutcome, summary: Summary) -> VariablesDocument:
    """Return the values of the point that a summary shows beside the default."""
    study = found.study
    values = zip(study.table.variable, found.gains(found.tuned).tolist(), strict=True)
    return VariablesDocument(
        format="holdfast-variables",
        version=1,
        study=study.path.name,
        title=study.title,
        digest=study.digest(),
        point=summary.shown,
        feasible=found.feasible,
        gains={entry.name: GainValue(value=value, unit=entry.unit) for entry, value in values},
    )
