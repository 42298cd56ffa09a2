"""A study of any kind before anything flies: its content in numbers, and what is known to stand in its way."""

from collections.abc import Callable
from typing import Any, Literal

from tuner.experiments.planning.counts import comparison_flights, contest_search_flights, flights_of
from tuner.experiments.planning.study_preview import PreviewPart, StudyPreview, plant_preview, study_preview
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.study.contest import Contender, Contest
from tuner.study.kinds import AnyStudy
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study
from tuner.study.trials import TrialStudy


class ContestPreview(PreviewPart):
    """A contest before anything flies; published, claims: how many it checks."""

    kind: Literal["contest"]
    title: str
    contenders: list[str]
    quantities: list[str]
    published: int
    claims: int
    search_flights: int
    comparison_flights_at_most: int
    halving: list[str] = []


class TrialsPreview(PreviewPart):
    """A study whose trials another program makes; the numbers of trials are the most that may be asked for."""

    kind: Literal["trials"]
    title: str
    variables: list[str]
    metrics: list[str]
    objectives: list[str]
    constraints: list[str]
    search_trials_at_most: int
    trials_at_most: int
    search: str
    digest: str
    warnings: list[str]


Preview = StudyPreview | ContestPreview | TrialsPreview


def preview(study: AnyStudy) -> Preview:
    """Return a study's preview, computed without flying."""
    return PREVIEWS[study.kind](study)


def contest_preview(contest: Contest) -> ContestPreview:
    """Return a contest's preview."""
    return ContestPreview(
        kind="contest",
        title=contest.title,
        contenders=[_described(contender) for contender in contest.contenders],
        quantities=[quantity.label for quantity in contest.quantities],
        published=len(contest.published),
        claims=len(contest.claims),
        search_flights=contest_search_flights(contest),
        comparison_flights_at_most=comparison_flights(contest),
        **({"halving": contest.halving_texts} if contest.halving else {}),
    )


def _described(contender: Contender) -> str:
    searched = len(contender.study.space.variables)
    return f"{contender.name} ({f'{searched} searched' if searched else 'as given'})"


def trials_preview(study: TrialStudy) -> TrialsPreview:
    """Return the preview of a study whose trials another program runs."""
    flights = flights_of(study)
    return TrialsPreview(
        kind="trials",
        title=study.title,
        variables=study.names,
        metrics=[f"{metric.text} [{metric.unit}]" for metric in study.metrics],
        objectives=[objective.label for objective in study.objectives],
        constraints=[f"{entry.objective.label} at most {entry.most:g}" for entry in study.constraints],
        search_trials_at_most=flights.search_at_most,
        trials_at_most=flights.total_at_most,
        search=" ".join([study.search.text, *study.start_texts]),
        digest=study.digest(),
        warnings=warnings_before_run(study),
    )


PREVIEWS: dict[str, Callable[[Any], Preview]] = {
    Study.kind: study_preview,
    PlantStudy.kind: plant_preview,
    Contest.kind: contest_preview,
    TrialStudy.kind: trials_preview,
}
"""Previews by the kind of study."""
