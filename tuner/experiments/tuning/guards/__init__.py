"""Guards: what could make a run's numbers mean less than they seem to, each a small function, in one registry.

A guard before looks at the study, one after at the outcome; both return sentences that say what to change.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from objectives.evaluator import Objective
from objectives.margins.quantities import QUANTITIES
from objectives.mission import is_of_mission
from objectives.plant_mission import unjudged_places
from objectives.risk import classify_difference
from plant.errors import InputError
from tuner.analysis.held_out import differences_to
from tuner.analysis.margins.limits import LIMITS
from tuner.experiments.tuning.bounds import on_bounds
from tuner.experiments.tuning.guards import after
from tuner.experiments.tuning.guards.before import (
    default_elsewhere,
    few_scenarios,
    rates_without_damping,
    signals_after_end,
    unjudged_channels,
    unprovable_shares,
    unsampled_modes,
    wrong_units,
)
from tuner.experiments.tuning.guards.leading_yaw import leading_yaw
from tuner.experiments.tuning.outcome import FlightOutcome, Outcome
from tuner.search.names import CONVERGED
from tuner.study.plant_study import PlantStudy
from tuner.study.searched import SearchedStudy
from tuner.text.numbers import significant
from tuner.text.units import after_number

__all__ = ["GUARDS", "Guard", "warnings_after_run", "warnings_before_run"]

BEFORE, AFTER = "before", "after"


@dataclass(frozen=True)
class Guard:
    """A check that warns before or after a run.

    Attributes:
        when: `BEFORE` a run or `AFTER` it.
        what: Subject of the check, one line.
        message: Return the warnings on a study (before) or on an outcome (after).
        everywhere: Whether it checks every study, else those that name it.
    """

    when: str
    what: str
    message: Callable[[Any], list[str]]
    everywhere: bool = True


def _labels(outcome: Outcome) -> list[str]:
    return [objective.label for objective in outcome.study.objectives]


def _flown_values(outcome: Outcome) -> np.ndarray:
    return outcome.archive.values[outcome.archive.flown]


def _lenient(outcome: Outcome) -> list[str]:
    rows = np.flatnonzero(outcome.finalists.non_dominated)
    held_out = outcome.finalists.evaluation.values[rows]
    flights = [entry.search for entry in outcome.study.scenarios]
    return after.lenient_flights(
        _labels(outcome), outcome.finalists.search[rows], held_out, flights, outcome.study.is_resumable
    )


def _still_rising(outcome: Outcome) -> list[str]:
    search, done = outcome.study.search, outcome.generations
    # Such a search has converged, by the front behind its back-off from limits; the front without it counts for nothing.
    if search.stop == CONVERGED and len(done) < search.generations:
        return []
    return after.still_rising(
        [entry.hypervolume for entry in done], [entry.flights for entry in done], outcome.study.is_resumable
    )


def _duplicate_knees(outcome: Outcome) -> list[str]:
    # Where the default stays there is no other point to take.
    rows = np.flatnonzero(outcome.finalists.non_dominated).tolist() if outcome.tuned else []
    gaps = differences_to(outcome.finalists.flown, outcome.tuned)
    reference = outcome.finalists.evaluation.values[outcome.tuned]
    words = {
        row: [
            classify_difference(value, *ends, relevant=outcome.study.table.relevant)
            for value, *ends in zip(reference, gaps.difference[row], gaps.low[row], gaps.high[row], strict=True)
        ]
        for row in rows
    }
    return after.duplicate_knees(outcome.names, outcome.tuned, words)


def _lost(outcome: Outcome) -> list[str]:
    limited = any(entry.objective.metric.metric.name == "failure" for entry in outcome.study.constraints)
    return after.lost_flights(int(outcome.confirmation.lost[1]), int(outcome.confirmation.flights_each[1]), limited)


def _on_bounds(outcome: Outcome) -> list[str]:
    if not outcome.feasible:
        return []
    front = outcome.finalist_rows[outcome.finalists.non_dominated]
    return after.gains_on_bounds(on_bounds(outcome.study, outcome.gains(outcome.tuned), front))


def _idle(outcome: Outcome) -> list[str]:
    study = outcome.study
    columns = [i for i, entry in enumerate(study.constraints) if is_of_mission(entry)]
    broken = outcome.archive.violations > 0.0
    others = np.delete(broken, columns, axis=1).any(axis=1)
    idle = np.sum(broken[:, columns].any(axis=1) & ~others & outcome.archive.flown, axis=0)
    return after.idle_candidates(int(idle), len(outcome.archive.points))


def _unjudged(study: PlantStudy) -> list[str]:
    judged = [*study.objectives, *[entry.objective for entry in study.constraints if not entry.floor]]
    names = [entry.spec.name for entry in study.scenarios]
    channels = [channel.name for channel in study.system.plan.outer]
    held = {(entry.objective.metric.axes[0], entry.objective.scenario) for entry in study.automatic_limits}
    places = unjudged_places(channels, names, judged)
    # A place that has no limit although none is switched off is one where nothing moves the channel.
    free = [(channel, name) for channel, name in places if not study.mission.asks(f"rms.{channel}", name)]
    return unjudged_channels([place for place in places if place in held], free)


def _worse_unjudged(outcome: Outcome) -> list[str]:
    study, count = outcome.study, len(outcome.study.objectives)
    if not outcome.feasible or not outcome.tuned:
        return []
    judged = [*study.objectives, *[entry.objective for entry in study.constraints if not entry.floor]]
    rows = outcome.table[count : count + len(study.constraints)]
    return after.worse_unjudged(
        [
            row
            for row, entry in zip(rows, study.constraints, strict=True)
            if is_of_mission(entry) and not any(_judges(other, entry.objective) for other in judged)
        ]
    )


def _seldom_reached(outcome: Outcome) -> list[str]:
    labels, flown = _labels(outcome), _flown_values(outcome)
    values = [row.tuned.value for row in outcome.table[: len(labels)]]
    # An objective that is the same for all candidates has a warning of its own.
    varies = np.ptp(flown, axis=0) > after.SAME * np.abs(flown).max(axis=0)
    never = [times if vary else [] for times, vary in zip(outcome.study.censored_times(), varies, strict=True)]
    return after.seldom_reached(labels, values, never)


def _judges(judging: Objective, quantity: Objective) -> bool:
    """Return True for an objective on an axis of a quantity."""
    is_seen = judging.scenario in (None, quantity.scenario)
    return is_seen and bool(set(judging.metric.axes) & set(quantity.metric.axes))


def _unlimited_margins(outcome: FlightOutcome) -> list[str]:
    study = outcome.study
    if not outcome.feasible or not outcome.tuned or study.requirements:
        return []
    try:
        model = study.margin_model()
    except InputError:
        return []
    margins = model.evaluate(outcome.gains(outcome.tuned)[None])
    looped = list(dict.fromkeys(channel for block in model.blocks for channel in block))
    broken = []
    for limit in LIMITS:
        quantity = QUANTITIES[limit.quantity]
        value = float(quantity.worst(quantity.to_limit(quantity.values(margins)), looped, margins.channels)[0])
        if not limit.is_satisfied(value):
            unit = after_number(quantity.limit_unit)
            broken.append(f"{quantity.label} {significant(value, 3)}{unit} (usual {limit.sense} {limit.limit:g})")
    return after.unlimited_margins(broken)


GUARDS = {
    "few_scenarios": Guard(BEFORE, "too few scenarios for the level of a risk", few_scenarios),
    "unprovable_shares": Guard(BEFORE, "limits on shares that the held-out flights cannot show", unprovable_shares),
    "wrong_units": Guard(BEFORE, "limits that look like numbers of another unit", wrong_units),
    "default_elsewhere": Guard(BEFORE, "default gains of a file that were flown otherwise", default_elsewhere, False),
    "rates_without_damping": Guard(
        BEFORE, "gust rates on a vehicle that they do not touch", rates_without_damping, False
    ),
    "leading_yaw": Guard(
        BEFORE,
        "a yaw loop that the inertia of the rotors speeds up",
        lambda study: leading_yaw(study, study.default_row, "the default's yaw loop"),
        False,
    ),
    "unjudged": Guard(BEFORE, "channels and scenarios that no objective and no limit judges", _unjudged, False),
    "signals_after_end": Guard(
        BEFORE, "references and disturbances that begin after the end of a flight", signals_after_end, False
    ),
    "unsampled_modes": Guard(BEFORE, "modes of a plant above half the sampling rate", unsampled_modes, False),
    "mission_floor": Guard(AFTER, "candidates that satisfy all limits but do not fly the mission", _idle),
    "constant_objective": Guard(
        AFTER,
        "an objective that nothing searched moves",
        lambda outcome: after.constant_objectives(
            _labels(outcome), _flown_values(outcome), outcome.study.censored_times()
        ),
    ),
    "seldom_reached": Guard(AFTER, "an objective that waits for what most flights do not come to", _seldom_reached),
    "correlated_objectives": Guard(
        AFTER,
        "two objectives that rank all candidates alike",
        lambda outcome: after.correlated_objectives(_labels(outcome), _flown_values(outcome)),
    ),
    "duplicate_knee": Guard(AFTER, "points that cannot be distinguished from the recommended one", _duplicate_knees),
    "lost_flights": Guard(AFTER, "a recommended point that loses flights which nothing limits", _lost),
    "worse_unjudged": Guard(AFTER, "quantities that nothing judges and that became much worse", _worse_unjudged),
    "unlimited_margins": Guard(
        AFTER, "usual margins that are broken where nothing limits margins", _unlimited_margins, False
    ),
    "on_bound": Guard(AFTER, "recommended gains at an end of their range", _on_bounds),
    "lenient_flights": Guard(AFTER, "a search whose flights were more lenient than held-out ones", _lenient),
    "still_rising": Guard(
        AFTER,
        "a search that ended before its front had come to rest",
        _still_rising,
    ),
}


def warnings_before_run(study: SearchedStudy) -> list[str]:
    """Return the checks' warnings about a study before it runs."""
    return [text for guard in guards_of(study, BEFORE) for text in guard.message(study)]


def warnings_after_run(outcome: Outcome) -> list[str]:
    """Return the checks' warnings about an outcome."""
    return [text for guard in guards_of(outcome.study, AFTER) for text in guard.message(outcome)]


def guards_of(study: SearchedStudy, when: str) -> list[Guard]:
    """Return the guards that look at a study, or at its outcome."""
    return [
        guard for name, guard in GUARDS.items() if guard.when == when and (guard.everywhere or name in study.guards)
    ]
