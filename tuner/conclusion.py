"""What a search found, held against flights that it never saw: finalists, the recommended point, warnings."""

from dataclasses import dataclass
from functools import cached_property
from time import perf_counter

import numpy as np

from objectives.problem import Fleet, Problem
from objectives.risk import minimum_samples
from plant.scenarios import HELD_OUT, SEARCH
from tuner.held_out import Comparison, Finalists, KnownComparison, compare, compare_known, judge
from tuner.search.front import pick
from tuner.search.infeasible import nothing_feasible
from tuner.search.loop import Archive, Generation, archive
from tuner.study.study import Study
from tuner.watcher import Watcher

# Finalists re-flown at most; a longer front is thinned evenly along its first objective.
MOST_FINALISTS = 48


@dataclass(frozen=True)
class Outcome:
    """What a run found. candidates: archive indices of the finalists behind the default; tuned: row in the finalists."""

    study: Study
    problem: Problem
    generations: list[Generation]
    candidates: np.ndarray
    finalists: Finalists
    tuned: int
    why: str
    table: list[Comparison]
    known: list[KnownComparison]
    warnings: list[str]
    seconds: float

    @property
    def flights(self) -> int:
        """Number of flights of the search and of the held-out check."""
        return self.generations[-1].flights + self.finalists.evaluation.flights

    @cached_property
    def archive(self) -> Archive:
        """All candidates of the search."""
        return archive(self.generations)

    @cached_property
    def finalist_rows(self) -> np.ndarray:
        """Gains rows (finalists, gains); row 0 is the default."""
        return finalist_gains(self.problem, self.study, self.archive, self.candidates)

    def gains(self, row: int) -> np.ndarray:
        """Return the gains row (gains,) of a finalist; row 0 is the default."""
        return self.finalist_rows[row]


def fleets(study: Study, stream: str) -> tuple[Fleet, ...]:
    """Return the flights of a study in the search or in the held-out stream."""
    return tuple(
        Fleet(entry.spec, stream, entry.search if stream == SEARCH else entry.held_out) for entry in study.scenarios
    )


def conclude(
    problem: Problem, study: Study, generations: list[Generation], watcher: Watcher, begin: float, said: list[str]
) -> Outcome:
    """Re-fly the default and the front on held-out scenarios and pick the recommended point; said: warnings so far."""
    found = archive(generations)
    candidates, warnings = finalists_of(found, study)
    warnings = [*said, *warnings]
    flown = fleets(study, HELD_OUT)
    gains = finalist_gains(problem, study, found, candidates)
    watcher.verifying(len(gains) * sum(fleet.count for fleet in flown))
    finalists = judge(problem, problem.evaluate_gains(gains, flown, watcher.landed, fly_all=True), study.seed)
    tuned, why = recommend(study, finalists)
    table = compare(problem, finalists, tuned, study.seed)
    known = compare_known(problem, finalists, tuned)
    if not finalists.feasible[tuned]:
        warnings.append(f"The recommended point breaks {broken_by(finalists, tuned, study)}; see the table.")
    seconds = perf_counter() - begin
    return Outcome(study, problem, generations, candidates, finalists, tuned, why, table, known, warnings, seconds)


def broken_by(finalists: Finalists, row: int, study: Study) -> str:
    """Return what kind of limit an infeasible finalist breaks."""
    broken = finalists.evaluation.violations[row] > 0.0
    split = len(study.constraints)
    kinds = [(broken[:split], "a constraint on the held-out scenarios"), (broken[split:], "a requirement")]
    return " and ".join(kind for part, kind in kinds if part.any())


def finalist_gains(problem: Problem, study: Study, found: Archive, candidates: np.ndarray) -> np.ndarray:
    """Return the gains rows of the default and of the finalists."""
    return np.concatenate([study.default_row[None], problem.space.gains(found.points[candidates])], axis=0)


def finalists_of(found: Archive, study: Study) -> tuple[np.ndarray, list[str]]:
    """Return the archive indices to re-fly and what to warn of."""
    warnings = few_scenarios(study)
    front = found.front()
    if len(front) == 0:
        least, why = nothing_feasible(found, study.requirements)
        return np.array([least]), [*warnings, why]
    front = front[np.argsort(found.values[front, 0], kind="stable")]
    if len(front) > MOST_FINALISTS:
        keep = np.unique(np.linspace(0, len(front) - 1, MOST_FINALISTS).round().astype(int))
        front = front[keep]
    return front, warnings


def few_scenarios(study: Study) -> list[str]:
    """Return warnings for risks that ask more of the scenarios than there are."""
    warnings = []
    for objective in study.objectives:
        for stream in (SEARCH, HELD_OUT):
            seen = [fleet for fleet in fleets(study, stream) if objective.scenario in (None, fleet.spec.name)]
            have, need = sum(fleet.count for fleet in seen), minimum_samples(objective.risk)
            if have < need:
                warnings.append(
                    f"{objective.label} rests on {have} {stream} scenarios; {need} would put five into its tail, so expect "
                    f"its {stream} value to be optimistic."
                )
    return warnings


def recommend(study: Study, finalists: Finalists) -> tuple[int, str]:
    """Return the row of the recommended finalist and why: the pick rule, among those that beat the default everywhere."""
    values = finalists.evaluation.values
    rows = np.flatnonzero(finalists.non_dominated)
    if len(rows) == 0:
        least = int(np.argmin(finalists.evaluation.violations[1:].sum(axis=1))) + 1
        return least, "no finalist keeps every constraint on the held-out scenarios; this one breaks them least"
    beating = rows[np.all(values[rows] < values[0], axis=1)]
    among = beating if len(beating) else rows
    chosen, why = pick(study.pick, values[among], [objective.label for objective in study.objectives])
    where = (
        "among the points of the held-out front that beat the default in every objective"
        if len(beating)
        else "on the held-out front, where no point beats the default in every objective"
    )
    return int(among[chosen]), f"{why}, {where}"
