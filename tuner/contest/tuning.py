"""What a contender brings into the comparison: the gains it is flown at and the front behind them."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tuner.contest.contest import Contender, Contest
from tuner.contest.fronts import Front
from tuner.search.front import pick
from tuner.store.folder import Folder
from tuner.store.tables import point_name
from tuner.study.paths import with_paths
from tuner.study.toml_text import toml_text
from tuner.watcher import Watcher

if TYPE_CHECKING:
    from tuner.conclusion import Outcome

GIVEN = "given"
"""Name of the point of a contender that is flown as given."""


@dataclass(frozen=True)
class Prepared:
    """A contender at its gains. point, row (gains,): what is compared, and why; front: None where nothing was searched.

    folder: of its own results, relative to that of the contest; flights: of its search and held-out check.
    """

    contender: Contender
    point: str
    row: np.ndarray
    why: str
    front: Front | None
    folder: str | None
    flights: int
    warnings: list[str]


def prepare(contest: Contest, contender: Contender, folder: Folder, watcher: Watcher, threads: int | None) -> Prepared:
    """Tune a contender into a results folder of its own, or take its gains as given."""
    if not contender.tuned:
        return Prepared(contender, GIVEN, contender.study.default_row, "its gains are given", None, None, 0, [])
    from tuner.run import run_study

    own = f"contenders/{contender.slug}"
    folder.write_text(f"{own}.toml", study_text(contest, contender))
    study = replace(contender.study, path=folder.path / f"{own}.toml")
    outcome = run_study(study, Folder.open_or_create(folder.path / own), watcher, threads)
    front = front_of(outcome)
    point, row, why = compared_at(outcome, front)
    return Prepared(contender, point, row, why, front, own, outcome.flights, outcome.warnings)


def compared_at(outcome: "Outcome", front: Front) -> tuple[str, np.ndarray, str]:
    """Return the point a contender is compared at, its gains row and why: what the pick rule picks from its front.

    A study on its own prefers points that beat its default everywhere. Contenders have different defaults, and one whose
    default is poor must not be held to it.
    """
    if not front.points:
        return point_name(int(outcome.candidates[outcome.tuned - 1])), outcome.gains(outcome.tuned), outcome.why
    labels = [objective.label for objective in outcome.study.objectives]
    chosen, why = pick(outcome.study.pick, front.values, labels)
    return front.points[chosen], front.gains[chosen], f"{why}, on its held-out front"


def study_text(contest: Contest, contender: Contender) -> str:
    """Return a contender as a study file that gives the same results when it is run alone."""
    home = contest.path.parent.resolve()
    return toml_text(with_paths(contender.raw, lambda name: str(home / name)))


def front_of(outcome: "Outcome") -> Front:
    """Return the feasible, non-dominated finalists of a run."""
    finalists = outcome.finalists
    rows = np.flatnonzero(finalists.non_dominated)
    candidates = outcome.candidates[rows - 1]
    return Front(
        points=[point_name(int(candidate)) for candidate in candidates],
        candidates=candidates,
        gains=outcome.finalist_rows[rows],
        values=finalists.evaluation.values[rows],
        low=finalists.low[rows],
        high=finalists.high[rows],
        samples=[
            finalists.evaluation.samples(i, objective.scenario)[rows]
            for i, objective in enumerate(outcome.study.objectives)
        ],
    )
