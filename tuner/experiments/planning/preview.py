"""A study of any kind before anything flies: its content in numbers, and what is known to stand in its way."""

from collections.abc import Callable
from typing import Any

from tuner.experiments.planning.counts import comparison_flights, contest_search_flights
from tuner.experiments.planning.study_preview import PreviewPart, StudyPreview, plant_preview, study_preview
from tuner.extension import added, load
from tuner.study.contest import Contender, Contest
from tuner.study.kinds import AnyStudy
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study


class ContestPreview(PreviewPart):
    """A contest before anything flies; published, claims: how many it checks."""

    contenders: list[str]
    quantities: list[str]
    published: int
    claims: int
    search_flights: int
    comparison_flights_at_most: int
    halving: list[str] = []


Preview = StudyPreview | ContestPreview | PreviewPart


def preview(study: AnyStudy) -> Preview:
    """Return a study's preview, computed without flying."""
    made = PREVIEWS[study.kind] if study.kind in PREVIEWS else load(added("previews")[study.kind])
    return made(study)


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


PREVIEWS: dict[str, Callable[[Any], Preview]] = {
    Study.kind: study_preview,
    PlantStudy.kind: plant_preview,
    Contest.kind: contest_preview,
}
"""Previews by the kind of study of the core; those of extensions are in their records."""
