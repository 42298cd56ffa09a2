"""A comparison from beginning to end: fly every entrant and every front through the same scenarios and judge them in pairs."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np

from tuner.experiments.compare.entrants import Entrant
from tuner.experiments.compare.fronts import MOST_POINTS, entries_of, thinned
from tuner.experiments.compare.shared import contest_of, same_flights, same_objectives, sources, what_differs
from tuner.experiments.contest.document import contest_document
from tuner.experiments.contest.flying import Entry, comparison_problem, fly_groups
from tuner.experiments.contest.result import Result, groups_of, judge_contest
from tuner.experiments.contest.tuning import Prepared
from tuner.experiments.tuning.ending import contender_ending
from tuner.study.contest import Contest
from tuner.study.study import Study


@dataclass(frozen=True)
class Prospect:
    """What will be flown. entries: of the entrants, in order; fronts: of each entrant's front, none where it has none here."""

    contest: Contest
    entrants: list[Entrant]
    entries: list[Entry]
    fronts: list[list[Entry]]
    warnings: list[str]

    @property
    def flights(self) -> int:
        """Number of flights."""
        return self.contest.flights_each * (len(self.entries) + sum(len(front) for front in self.fronts))


def prospect(entrants: list[Entrant], base: Study) -> Prospect:
    """Check entrants against the scenarios of a study and say what will be flown."""
    contest = contest_of(entrants, base)
    warnings = what_differs(entrants, base)
    entries, fronts = [], []
    for entrant, contender in zip(entrants, contest.contenders, strict=True):
        row = np.array(entrant.controller.gains)
        entry = Entry(contender, entrant.point, row, comparison_problem(contest, contender))
        entries.append(entry)
        shown = thinned(entrant, np.arange(len(entrant.points))) if same_objectives(entrant, base) else None
        if shown is not None and len(shown.points) < len(entrant.points):
            warnings.append(f"Of the {len(entrant.points)} points of {entrant.name} {len(shown.points)} were flown.")
        fronts.append([] if shown is None else entries_of(shown, entry, same_flights(entrant, base)))
    return Prospect(contest, entrants, entries, fronts, warnings)


def fly_comparison(asked: Prospect, threads: int | None, on_flights_done: Callable[[int], None]) -> Result:
    """Fly everything and work out all that follows; the result does not depend on the number of threads."""
    begin = perf_counter()
    prepared = []
    for entrant, entry, front in zip(asked.entrants, asked.entries, asked.fronts, strict=True):
        ending = () if entrant.feasible else tuple(contender_ending(entrant.name, entrant.point))
        run = "recommended by its run" if entrant.feasible else "nearest to feasible in its run"
        why = "its gains are given" if entrant.study is None else run
        # Who has no front of its own in these objectives is one point among the fronts of the others.
        prepared.append(Prepared(entry, why, front or None, None, 0, [], ending))
    flown = fly_groups(asked.contest, groups_of(prepared), threads, on_flights_done)
    return judge_contest(asked.contest, prepared, flown, perf_counter() - begin)


def comparison_document(asked: Prospect, result: Result) -> dict[str, Any]:
    """Return the content of comparison.json: that of a contest.json, and where every contender came from."""
    document = contest_document(result, asked.warnings)
    for row, (source, kind) in zip(document["contenders"], sources(asked.entrants), strict=True):
        row |= {"source": str(source), "kind": kind, "budget": None}
    return {
        **{key: document.pop(key) for key in ("feasible", "ending")},
        "kind": "comparison",
        "first": result.names[0],
        "study_file": str(asked.contest.path),
        "front_points_at_most": MOST_POINTS,
        **document,
    }
