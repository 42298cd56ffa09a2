"""A contest: tune the contenders that search, fly all of them through the same air, compare, write everything down."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from plant.quadrotor.scenarios import HELD_OUT
from plant.texts import PlainTable
from tuner.documents.comparison_document import RungRow
from tuner.documents.resolved import Resolved
from tuner.experiments.compare.document import shared_keys
from tuner.experiments.compare.flying import PreparedContender
from tuner.experiments.compare.run import ComparedRun
from tuner.experiments.compare.tables import listed_table
from tuner.experiments.tuning.conflicts import automatic_limit_texts
from tuner.experiments.tuning.guards.before import few_scenarios
from tuner.extensions.contests.documents import ContestDocument, ContestFolder
from tuner.extensions.contests.judging import ContestResult
from tuner.extensions.contests.race import keep_feasible, raced
from tuner.extensions.contests.study import Contest
from tuner.extensions.contests.tuning import prepare
from tuner.extensions.contests.words import contest_sentences
from tuner.search.watcher import COMPARING
from tuner.store.advice import CONTEST
from tuner.store.columns import Columns


def write_contest_report(folder: Path) -> Path:
    """Write report.html into a contest folder and return its path; StoreError names a missing or damaged file."""
    from tuner.extensions.contests.page import contest_page
    from tuner.report.page import put_page

    return put_page(folder, contest_page(ContestFolder(folder)))


def write_contest_figures(folder: Path) -> list[Path]:
    """Write figures/*.png and *.pdf into a contest folder and return their paths; StoreError as in the report."""
    from tuner.extensions.contests.figures import FIGURES
    from tuner.report.comparison.figures import write_all

    return write_all(ContestFolder(folder), FIGURES)


class ContestRun(ComparedRun[Contest, ContestResult]):
    """A contest in a results folder; what a finished contender left there is kept whatever happens later."""

    kind = CONTEST
    inside = "contenders"
    document_name = "contest.json"
    stage = COMPARING
    result_type = ContestResult
    draw_figures = staticmethod(write_contest_figures)
    draw_page = staticmethod(write_contest_report)

    @classmethod
    def notes(cls, study: Contest) -> list[str]:
        """Say how searches race, and which limits the study does not write."""
        return [*study.halving_texts, *automatic_limit_texts(study.base.automatic_limits)]

    def race(self) -> tuple[Contest, list[RungRow]]:
        """Return the contest of the finalists, and the rungs before it."""
        return raced(self.study, self.folder, self.watcher, self.threads) if self.study.halving else (self.study, [])

    def contenders(self, study: Contest) -> Sequence[PreparedContender]:
        """Tune every contender that has something to tune, one after the other."""
        prepared = []
        for number, contender in enumerate(study.contenders):
            if contender.tuned:
                self.watcher.on_contender(contender.name, number + 1, len(study.contenders))
            prepared.append(prepare(study, contender, self.folder, self.watcher, self.threads))
        return prepared

    def fly(self) -> ContestResult:
        """Tune, fly all through the same scenarios and work out what follows; the number of threads changes nothing."""
        contest, rungs = self.race()
        tuned = list(self.contenders(contest))
        prepared, last = keep_feasible(contest, tuned, rungs[-1].rung + 1 if rungs else 1)
        contest = replace(contest, contenders=tuple(entrant.contender for entrant in prepared))
        names = {contender.name for contender in contest.contenders}
        left_out = sum(each.flights - each.search_flights for each in tuned if each.contender.name not in names)
        result = self.compared(contest, prepared)
        rungs = [*rungs, *last]
        stopped = sum(row.flights for row in rungs if not row.goes_on)
        return replace(result, rungs=rungs, flights=result.flights + stopped + left_out)

    def resolved(self) -> PlainTable | None:
        """Return every value of every contender's study, by the contender's name."""
        return {name: Resolved.of(values).content() for name, values in self.study.resolved().items()}

    def document(self, result: ContestResult) -> ContestDocument:
        """Return the content of contest.json."""
        rungs: dict[str, Any] = {"rungs": result.rungs} if result.rungs else {}
        keys = shared_keys(result, contest_sentences(result), warnings_of(result))
        return ContestDocument(**keys, published=result.published, claims=result.claims, **rungs)

    def tables(self, result: ContestResult) -> dict[str, Columns]:
        """Return the tables of the folder, printed numbers among them."""
        published = {"published.csv": listed_table(result.published)} if result.published else {}
        return {**super().tables(result), **published}


def warnings_of(result: ContestResult) -> list[str]:
    """Return the warnings about a contest's numbers."""
    common = few_scenarios(result.study.base)
    tuned = [entrant for entrant in result.prepared if entrant.contender.tuned]
    warnings = [text for text in common if tuned or HELD_OUT in text]
    warnings += [
        f"{entrant.contender.name}: {text}" for entrant in tuned for text in entrant.warnings if text not in common
    ]
    warnings += broken_again(result)
    if len({replace(entrant.contender.study.search, starts=()) for entrant in tuned}) > 1:
        warnings.append("The contenders were not tuned with the same budget; see budget in contest.json.")
    given = [entrant.contender.name for entrant in result.prepared if not entrant.contender.tuned]
    if tuned and given:
        warnings.append(f"Flown as given, against contenders that were tuned: {', '.join(given)}.")
    return warnings


def broken_again(result: ContestResult) -> list[str]:
    """Report held-out front points that break a constraint on the comparison's flights; they count no longer."""
    return [
        f"{entrant.contender.name}: on the confirmation flights {front.broken} of the {len(entrant.offered)} points of its "
        "held-out front violate a constraint and count no longer; raise held_out, or ask for a reserve."
        for entrant, front in zip(result.prepared, result.fronts, strict=False)
        if entrant.offered is not None and front.broken
    ]
