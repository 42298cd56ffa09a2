"""Contenders flown through the same scenarios and compared; a comparison of given gains: of results folders and gains files."""

from abc import abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from tuner.documents.comparison_document import ComparisonDocument
from tuner.experiments.compare.document import difference_row, shared_keys
from tuner.experiments.compare.entrants import Entrant
from tuner.experiments.compare.flying import PreparedContender, fly_groups
from tuner.experiments.compare.plan import MAX_POINTS, ComparisonPlan, base_study, plan_comparison
from tuner.experiments.compare.result import Result, groups_of
from tuner.experiments.compare.tables import fronts_table, listed_table, response_tables, scores_table, wind_table
from tuner.experiments.compare.words import sentences
from tuner.experiments.experiment import Experiment
from tuner.experiments.tuning.problem import warm_up
from tuner.report.comparison import write_comparison_figures, write_comparison_report
from tuner.search.watcher import Watcher
from tuner.store.columns import Columns
from tuner.store.document import Document
from tuner.store.folder import Folder
from tuner.study.comparison import ComparisonStudy
from tuner.study.study import TuningStudy

S = TypeVar("S", bound=ComparisonStudy)
R = TypeVar("R", bound=Result)


class ComparedRun(Experiment[S, R]):
    """Contenders compared on the same scenarios; a results folder is optional."""

    document_name: ClassVar[str]
    """Name of the document that holds the answer."""
    stage: ClassVar[str]
    """Name of the stage in which contenders fly."""
    result_type: ClassVar[type[Result]] = Result

    @abstractmethod
    def contenders(self, study: S) -> Sequence[PreparedContender]:
        """Return the contenders at their gains."""

    @abstractmethod
    def document(self, result: R) -> Document:
        """Return the content of the document."""

    def fly(self) -> R:
        """Fly all through the same scenarios and work out what follows; the number of threads changes nothing."""
        return self.compared(self.study, self.contenders(self.study))

    def compared(self, study: S, prepared: Sequence[PreparedContender]) -> R:
        """Return the comparison of contenders at their gains."""
        for entrant in prepared:
            warm_up(entrant.entry.problem, entrant.contender.study, self.watcher)
        groups = groups_of(prepared)
        self.watcher.on_stage(self.stage, study.flights_each * sum(map(len, groups)))
        flown = fly_groups(study, groups, self.threads, self.watcher.on_flights_done)
        result: Any = self.result_type.of(study, list(prepared), flown, self.seconds)
        return result

    @staticmethod
    def is_feasible(result: R) -> bool:
        """Whether every contender's run has a candidate within all limits."""
        return all(entrant.feasible for entrant in result.prepared)

    def tables(self, result: R) -> dict[str, Columns]:
        """Return the tables of numbers by file name."""
        differences = [difference_row(result, entry) for entry in result.comparison.differences]
        fronts = {"fronts.csv": fronts_table(result)} if result.fronts else {}
        return {"scores.npz": scores_table(result), "differences.csv": listed_table(differences), **fronts}

    def write_documents(self, result: R) -> None:
        """Write numbers, tables and responses."""
        folder, document = self.folder, self.document(result)
        for name, table in self.tables(result).items():
            folder.write_table(name, table)
        self.watcher.on_writing("responses")
        fans, traces = response_tables(result)
        folder.write_table("responses.npz", fans)
        folder.write_table("traces.npz", traces)
        wind = wind_table(result)
        if wind is not None:
            folder.write_table("wind.npz", wind)
        folder.write_json(self.document_name, document)


class ComparisonRun(ComparedRun[ComparisonStudy, Result]):
    """A comparison of given gains."""

    kind = "comparison"
    inside = "figures"
    document_name = "comparison.json"
    stage = "Comparing"
    resumable = False
    draw_figures = staticmethod(write_comparison_figures)
    draw_page = staticmethod(write_comparison_report)

    def __init__(
        self,
        plan: ComparisonPlan,
        folder: Folder | None = None,
        watcher: Watcher | None = None,
        threads: int | None = None,
    ) -> None:
        super().__init__(plan.study, folder, watcher, threads=threads)
        self.plan = plan

    def contenders(self, study: ComparisonStudy) -> list[PreparedContender]:  # noqa: ARG002
        """Return the entrants at their gains."""
        return self.plan.contenders

    def resolved(self) -> None:
        """Return nothing: study.toml holds what is flown, and the document every gain."""

    def document(self, result: Result) -> ComparisonDocument:
        """Return the content of comparison.json."""
        return comparison_document(self.plan, result)


def compare(
    entrants: list[Entrant],
    study: TuningStudy | None = None,
    seeds: int | None = None,
    out: Path | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> ComparisonDocument:
    """Fly results folders and gains files through the same scenarios.

    Returns the content of comparison.json. Raises InputError where they cannot be compared.

    Args:
        entrants: Controllers of results folders and gains files.
        study: Study of the scenarios, by default that of the first results folder.
        seeds: Flights of each scenario, by default the study's held_out.
        out: A new folder to write the comparison to, or None.
        watcher: Callbacks that hear of progress.
        threads: Threads, by default one for each core.
    """
    plan = plan_comparison(entrants, base_study(entrants, study, seeds))
    folder = None if out is None else Folder.create(out, inside=ComparisonRun.inside)
    return comparison_document(plan, ComparisonRun(plan, folder, watcher, threads).carry_out())


def comparison_document(plan: ComparisonPlan, result: Result) -> ComparisonDocument:
    """Return the content of comparison.json; each contender's row names its source."""
    keys = shared_keys(result, sentences(result), plan.warnings)
    contenders = [
        row.model_copy(
            update={
                "source": str(entrant.source),
                "kind": "gains" if entrant.study is None else "results",
                "budget": None,
            }
        )
        for row, entrant in zip(keys.pop("contenders"), plan.entrants, strict=True)
    ]
    return ComparisonDocument(
        **keys,
        published=[],
        claims=[],
        contenders=contenders,
        kind="comparison",
        first=result.names[0],
        study_file=str(plan.study.path),
        front_points_at_most=MAX_POINTS,
    )
