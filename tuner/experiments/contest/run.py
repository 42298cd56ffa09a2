"""A contest: tune the contenders that search, fly all of them through the same air, compare, write everything down."""

from collections.abc import Sequence
from dataclasses import replace

from plant.quadrotor.scenarios import HELD_OUT
from plant.texts import PlainTable
from tuner.documents.contest_document import ComparisonDocument, ContestDocument, RungRow
from tuner.documents.resolved import Resolved
from tuner.experiments.contest.document import contest_document
from tuner.experiments.contest.flying import fly_groups
from tuner.experiments.contest.halving import keep_feasible, raced
from tuner.experiments.contest.result import Result, groups_of, judge_contest
from tuner.experiments.contest.tables import fronts_table, listed_table, response_tables, scores_table, wind_table
from tuner.experiments.contest.tuning import TunedContender, prepare
from tuner.experiments.experiment import Experiment
from tuner.experiments.tuning.conflicts import automatic_limit_texts
from tuner.experiments.tuning.guards.before import few_scenarios
from tuner.experiments.tuning.problem import warm_up
from tuner.report.contest import write_contest_figures, write_contest_report
from tuner.search.watcher import COMPARING
from tuner.store.advice import CONTEST
from tuner.study.contest import Contest


class ContestRun(Experiment[Contest, Result]):
    """A contest in a results folder; what a finished contender left there is kept whatever happens later."""

    kind = CONTEST
    inside = "contenders"
    document_name = "contest.json"
    stage = COMPARING
    draw_figures = staticmethod(write_contest_figures)
    draw_page = staticmethod(write_contest_report)

    @classmethod
    def notes(cls, study: Contest) -> list[str]:
        """Say how searches race, and which limits the study does not write."""
        return [*study.halving_texts, *automatic_limit_texts(study.base.automatic_limits)]

    def race(self) -> tuple[Contest, list[RungRow]]:
        """Return the contest of the finalists, and the rungs before it."""
        return raced(self.study, self.folder, self.watcher, self.threads) if self.study.halving else (self.study, [])

    def contenders(self, contest: Contest) -> Sequence[TunedContender]:
        """Tune every contender that has something to tune, one after the other."""
        prepared = []
        for number, contender in enumerate(contest.contenders):
            if contender.tuned:
                self.watcher.on_contender(contender.name, number + 1, len(contest.contenders))
            prepared.append(prepare(contest, contender, self.folder, self.watcher, self.threads))
        return prepared

    def fly(self) -> Result:
        """Tune, fly all through the same scenarios and work out what follows; the number of threads changes nothing."""
        contest, rungs = self.race()
        watcher, tuned = self.watcher, list(self.contenders(contest))
        prepared, last = keep_feasible(contest, tuned, rungs[-1].rung + 1 if rungs else 1)
        contest = replace(contest, contenders=tuple(entrant.contender for entrant in prepared))
        names = {contender.name for contender in contest.contenders}
        left_out = sum(each.flights - each.search_flights for each in tuned if each.contender.name not in names)
        for entrant in prepared:
            warm_up(entrant.entry.problem, entrant.contender.study, watcher)
        groups = groups_of(prepared)
        watcher.on_stage(self.stage, contest.flights_each * sum(map(len, groups)))
        flown = fly_groups(contest, groups, self.threads, watcher.on_flights_done)
        result = judge_contest(contest, prepared, flown, self.seconds, [*rungs, *last])
        return replace(result, flights=result.flights + left_out)

    @staticmethod
    def is_feasible(result: Result) -> bool:
        """Whether every contender's run has a candidate within all limits."""
        return all(entrant.feasible for entrant in result.prepared)

    def resolved(self) -> PlainTable | None:
        """Return every value of every contender's study, by the contender's name."""
        return {name: Resolved.of(values).content() for name, values in self.study.resolved().items()}

    def document(self, result: Result) -> ContestDocument | ComparisonDocument:
        """Return the content of the document."""
        return contest_document(result, warnings_of(result))

    def write_documents(self, result: Result) -> None:
        """Write numbers, tables and responses."""
        folder, document = self.folder, self.document(result)
        folder.write_table("scores.npz", scores_table(result))
        folder.write_table("differences.csv", listed_table(document.differences))
        if result.published:
            folder.write_table("published.csv", listed_table(result.published))
        if result.fronts:
            folder.write_table("fronts.csv", fronts_table(result))
        self.watcher.on_writing("responses")
        fans, traces = response_tables(result)
        folder.write_table("responses.npz", fans)
        folder.write_table("traces.npz", traces)
        wind = wind_table(result)
        if wind is not None:
            folder.write_table("wind.npz", wind)
        folder.write_json(self.document_name, document)


def warnings_of(result: Result) -> list[str]:
    """Return the warnings about a contest's numbers."""
    common = few_scenarios(result.contest.base)
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


def broken_again(result: Result) -> list[str]:
    """Report held-out front points that break a constraint on the comparison's flights; they count no longer."""
    return [
        f"{entrant.contender.name}: on the confirmation flights {front.broken} of the {len(entrant.offered)} points of its "
        "held-out front violate a constraint and count no longer; raise held_out, or ask for a reserve."
        for entrant, front in zip(result.prepared, result.fronts, strict=False)
        if entrant.offered is not None and front.broken
    ]
