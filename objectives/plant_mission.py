"""The mission floor of a plant of the user's own, see `objectives.mission`.

Every channel with a reference has one in every scenario. If the reference leaves the rest of the plant, the median flight
comes closer to it than a plant that stays there. If it rests and an objective or a limit of the study judges the channel,
the median flight keeps to within half of the error at which a flight is lost. If it rests and nothing judges it, it is no
worse than `REGULATED` times the error of the default gains. Only for that flights are made.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import isfinite
from typing import Any, cast

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.metrics import parse
from objectives.mission import FOLLOWED_KEY, HELD_KEY, OFF_KEY, Mission, MissionLimit, remaining_limits
from objectives.problem import Constraint, FlightBatch, Objective, Problem
from plant.errors import InputError
from plant.model.plan import Channel
from plant.model.scenario import PlantScenario
from plant.model.signals import Constant

# Twice the standard error of the median of 32 flights whose errors differ by a quarter: 1.25 * 0.25 / sqrt(32) is 5.5 %.
REGULATED, FLIGHTS = 1.1, 32
STREAM = "mission"
"""Stream of the flights of the default, which are neither those of a search nor those of a check."""
# Share of a channel's limit below which its error is rounding: nothing moves it.
SILENT = 1e-9


def quantities_of(system: Any) -> tuple[str, ...]:
    """Return the quantities of a plant that can have an automatic limit."""
    return tuple(f"rms.{channel.name}" for channel in system.plan.outer)


def is_judged(channel: str, scenario: str, judged: Iterable[Objective]) -> bool:
    """Return True if objectives or limits judge a channel in a scenario."""
    return any(channel in each.metric.axes and each.scenario in (None, scenario) for each in judged)


def with_plant_floor(
    constraints: tuple[Constraint, ...],
    objectives: Sequence[Objective],
    flights: Sequence[FlightBatch],
    system: Any,
    space: DecisionSpace,
    root: int,
    mission: Mission,
) -> tuple[Constraint, ...]:
    """Return the constraints of a study and the floor of its plant; a limit of its own on the same quantity stands.

    Args:
        constraints: Constraints that the study writes.
        objectives: Objectives of the study.
        flights: Scenarios, each with the most flights of the default that may be made through it.
        system: The `PlantSystem`.
        space: Decision space, whose base is the default.
        root: Root seed.
        mission: Table [mission] of the study.
    """
    judged = [*objectives, *[constraint.objective for constraint in constraints]]
    limits = [limit for batch in flights for limit in _limits(cast(PlantScenario, batch.spec), system, judged, mission)]
    limits = remaining_limits(limits, constraints, mission)
    for limit in limits:
        _check_limit(system.plan.channel(limit.metric.axes[0]), limit)
    return (*constraints, *[each.constraint for each in _with_default(limits, flights, system, space, root)])


def _limits(spec: PlantScenario, system: Any, judged: Sequence[Objective], mission: Mission) -> Iterator[MissionLimit]:
    """Yield the limits of a scenario; those that the flights of the default decide are the ones of a channel at rest."""
    times = system.timing.control_period * np.arange(spec.steps(system.timing))
    for channel in system.plan.outer:
        metric, held = parse(f"rms.{channel.name}", system.axes), mission.held * channel.limit
        error = error_at_rest(spec, channel.name, times)
        if error > 0.0:
            yield MissionLimit(metric, spec.name, mission.followed * error, FOLLOWED_KEY)
        else:
            key = HELD_KEY if is_judged(channel.name, spec.name, judged) else OFF_KEY
            yield MissionLimit(metric, spec.name, held, key)


def error_at_rest(spec: PlantScenario, channel: str, times: np.ndarray) -> float:
    """Return the RMS error of a channel at equilibrium over times (K,) [s]."""
    signal = spec.references.get(channel, Constant()).values(times, np.random.default_rng(0))[0]
    return float(np.sqrt(np.square(signal).mean(axis=0)))


def _check_limit(channel: Channel, limit: MissionLimit) -> None:
    if not isfinite(channel.limit):
        raise InputError(
            f"an automatic limit judges '{limit.metric}' in scenario \"{limit.scenario}\", and {channel.name} has no "
            "lost_beyond; write lost_beyond = ..., the |error| from which on a flight has failed, or "
            f'mission.off = ["{limit.metric}"]',
            key=f"channel.{channel.name}.lost_beyond",
        )


def _with_default(
    limits: Sequence[MissionLimit], flights: Sequence[FlightBatch], system: Any, space: DecisionSpace, root: int
) -> list[MissionLimit]:
    """Return limits, those of unjudged channels set by flights of the default."""
    regulated = [limit for limit in limits if limit.key == OFF_KEY]
    if not regulated:
        return list(limits)
    named = {limit.scenario for limit in regulated}
    batches = tuple(
        replace(batch, stream=STREAM, start=0, count=min(batch.count, FLIGHTS))
        for batch in flights
        if batch.spec.name in named
    )
    problem = Problem(system, space, tuple(limit.objective for limit in regulated), (), root)
    errors = problem.evaluate_gains(np.array([space.base]), batches, fly_all=True).values[0].tolist()
    of_default = dict(zip(regulated, errors, strict=True))
    floor = [
        limit._replace(most=min(REGULATED * of_default[limit], limit.most)) if limit in of_default else limit
        for limit in limits
    ]
    return [
        limit
        for limit in floor
        if limit.key != OFF_KEY or limit.most > SILENT * system.plan.channel(limit.metric.axes[0]).limit
    ]


def unjudged_places(
    channels: Iterable[str], scenarios: Sequence[str], judged: Sequence[Objective]
) -> list[tuple[str, str]]:
    """Return the pairs of channel and scenario without objective or limit."""
    return [(channel, name) for channel in channels for name in scenarios if not is_judged(channel, name, judged)]
