"""A comparison: a contest of given gains, of results folders and gains files."""

from pathlib import Path

from tuner.documents.contest_document import ComparisonDocument
from tuner.experiments.compare.entrants import read_entrants
from tuner.experiments.compare.plan import MAX_POINTS, ComparisonPlan, base_study, plan_comparison
from tuner.experiments.contest.document import contest_document
from tuner.experiments.contest.result import Result
from tuner.experiments.contest.run import ContestRun
from tuner.experiments.contest.tuning import TunedContender
from tuner.report.contest import write_comparison_figures
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.contest import Contest
from tuner.study.study import TuningStudy


class ComparisonRun(ContestRun):
    """A comparison, in a results folder or in none; the form of the folder is that of a contest's."""

    kind = "comparison"
    inside = "figures"
    document_name = "comparison.json"
    stage = "Comparing"
    resumable = False
    draw_figures = staticmethod(write_comparison_figures)

    def __init__(
        self,
        plan: ComparisonPlan,
        folder: Folder | None = None,
        watcher: Watcher | None = None,
        threads: int | None = None,
    ) -> None:
        super().__init__(plan.contest, folder, watcher, threads=threads)
        self.plan = plan

    def contenders(self, contest: Contest) -> list[TunedContender]:  # noqa: ARG002
        """Return the entrants at their gains."""
        return self.plan.contenders

    def resolved(self) -> None:
        """Return nothing: study.toml holds what is flown, and the document every gain."""

    def document(self, result: Result) -> ComparisonDocument:
        """Return the content of comparison.json."""
        return comparison_document(self.plan, result)


def compare(
    paths: list[Path],
    study: TuningStudy | None = None,
    seeds: int | None = None,
    out: Path | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> ComparisonDocument:
    """Fly results folders and gains files through the same scenarios.

    Returns the content of comparison.json. Raises InputError where they cannot be compared.

    Args:
        paths: Results folders and gains files.
        study: Study of the scenarios, by default that of the first results folder.
        seeds: Flights of each scenario, by default the study's held_out.
        out: A new folder to write the comparison to, or None.
        watcher: Callbacks that hear of progress.
        threads: Threads, by default one for each core.
    """
    entrants = read_entrants(paths)
    plan = plan_comparison(entrants, base_study(entrants, study, seeds))
    folder = None if out is None else Folder.create(out, inside=ComparisonRun.inside)
    return comparison_document(plan, ComparisonRun(plan, folder, watcher, threads).carry_out())


def comparison_document(plan: ComparisonPlan, result: Result) -> ComparisonDocument:
    """Return the content of comparison.json: that of a contest.json, and where every contender came from."""
    contest = contest_document(result, plan.warnings)
    contenders = [
        row.model_copy(
            update={
                "source": str(entrant.source),
                "kind": "gains" if entrant.study is None else "results",
                "budget": None,
            }
        )
        for row, entrant in zip(contest.contenders, plan.entrants, strict=True)
    ]
    return ComparisonDocument(
        **{key: value for key, value in vars(contest).items() if key not in ("contenders", "rungs")},
        contenders=contenders,
        kind="comparison",
        first=result.names[0],
        study_file=str(plan.contest.path),
        front_points_at_most=MAX_POINTS,
    )
