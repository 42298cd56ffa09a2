"""Reading of objectives, constraints and choice, for studies of every kind."""

from dataclasses import replace
from math import inf, isfinite
from typing import Any

from objectives.metrics import MetricAddress, parse
from objectives.mission import QUANTITIES, Mission
from objectives.own_meters import check_on_flights
from objectives.problem import Constraint, Objective
from objectives.risk import PROBABILITY, Risk
from plant.errors import InputError, UnknownNameError
from tuner.extension import added
from tuner.search.front import resolved_rule
from tuner.study.schema import ConstraintTable, ObjectiveTable, PickTable
from tuner.study.study import StudyScenario
from tuner.text.input_errors import located
from tuner.text.units import after_number

MIN_TAIL, LARGEST_TAIL = 1e-6, 0.05
"""Limits on a probability."""


def unique(name: str, labels: list[str], leaf: str = "") -> None:
    """Refuse a label that stands twice in a list of tables."""
    for i, label in enumerate(labels):
        if label in labels[:i]:
            first = labels.index(label)
            message = f"'{label}' occurs twice, first as {name}[{first}]; change one of the two, or leave one out"
            raise InputError(message, key=f"{name}[{i}]{leaf}")


def constraint_of(table: ConstraintTable, scenarios: tuple[StudyScenario, ...], system: Any) -> Constraint:
    """Return the constraint of a table, on flights of a system; InputError with the key inside the table."""
    objective, limit = objective_of(table, scenarios, system), _finite(table.max, "max")
    metric = objective.metric.metric
    if limit > metric.highest or limit < 0.0 or (limit == 0.0 and not metric.reaches_zero):
        low = "0" if metric.reaches_zero else "above 0"
        high = "" if metric.highest == inf else f" to {metric.highest:g}"
        unit = after_number(objective.metric.unit)
        message = f"given {limit:g}; '{objective.metric}' is {metric.definition}: allowed: {low}{high}{unit}"
        raise InputError(message, key="max")
    constraint = Constraint(objective, limit)
    if constraint.is_tail:
        _check_tail(constraint)
    return constraint


def _check_tail(constraint: Constraint) -> None:
    """Refuse a limit on a probability of anything but a rare loss.

    It is refused without an extension that estimates it too.
    """
    if not added("finalists"):
        raise InputError(
            "a limit on a probability needs an extension that estimates it, such as tails of gainproof, and none is "
            'installed; install it, or write risk = "mean"',
            key="risk",
        )
    metric = constraint.objective.metric.text
    if metric != "failure":
        raise InputError(
            f"given 'probability' of '{metric}'; allowed: of 'failure'. `tuner tail` estimates that of other events",
            key="risk",
        )
    if not MIN_TAIL <= constraint.most <= LARGEST_TAIL:
        raise InputError(
            f"given {constraint.most:g}; allowed for a probability: {MIN_TAIL:g} to {LARGEST_TAIL:g}; for more, write "
            'risk = "mean"',
            key="max",
        )


def held_with(confidence: float, constraints: tuple[Constraint, ...]) -> tuple[Constraint, ...]:
    """Return constraints that hold with a confidence, that of a study."""
    return tuple(replace(entry, confidence=confidence) for entry in constraints)


def searched_objective_of(table: ObjectiveTable, scenarios: tuple[StudyScenario, ...], system: Any) -> Objective:
    """Return the objective of a table, as `objective_of`; one that a search cannot follow is refused."""
    objective = objective_of(table, scenarios, system)
    refuse_probability(
        table.risk,
        "takes 10,000 to 100,000 flights of each candidate; limit it in a [[constraint]], for which the recommended point alone "
        'makes them, and let the objective weigh the worst flights by risk = "cvar", or all by',
    )
    return objective


def refuse_probability(risk: str, reason: str) -> None:
    """Refuse a risk that flights of its own decide; reason: goes on with 'risk = "mean"'."""
    if risk == PROBABILITY:
        raise InputError(f'given "{PROBABILITY}", which {reason} risk = "mean"', key="risk")


def objective_of(table: ObjectiveTable, scenarios: tuple[StudyScenario, ...], system: Any) -> Objective:
    """Return the objective of a table, on flights of a system; InputError with the key inside the table."""
    names = [entry.spec.name for entry in scenarios]
    if table.scenario is not None and table.scenario not in names:
        raise UnknownNameError("scenario", table.scenario, names, key="scenario")
    with located(None, "metric"):
        metric = parse(table.metric, system.axes)
        for entry in scenarios:
            if table.scenario in (None, entry.spec.name):
                _check_metric(metric, entry.spec, system)
    return Objective(metric, risk_of(table.risk, table.level), table.scenario)


def risk_of(name: str, level: float | None) -> Risk:
    """Return a risk measure; InputError with the key inside the table that names it."""
    try:
        return Risk(name, level)
    except UnknownNameError as error:
        raise error.located(key="risk") from None
    except InputError as error:
        raise error.located(key="level") from None


def _check_metric(metric: MetricAddress, spec: Any, system: Any) -> None:
    try:
        check_on_flights(metric, system, spec)
    except InputError as error:
        raise InputError(f'{error.message} (scenario "{spec.name}")') from None


def _finite(value: float, key: str) -> float:
    if not isfinite(value):
        raise InputError(f"given {value}; this must be a finite number", key=key)
    return value


def mission_of(table: Any, scenarios: list[str], quantities: tuple[str, ...] = QUANTITIES) -> Mission:
    """Return the mission of a table; InputError where it names no quantity or no scenario."""
    mission = Mission(table.followed, table.held, tuple(table.off))
    mission.check_names(scenarios, quantities)
    return mission


def pick_rule(table: PickTable, objectives: tuple[Objective, ...]) -> str:
    """Return the rule that picks a point of the front."""
    labels = [objective.label for objective in objectives]
    return resolved_rule(table.rule, table.weights, labels, [objective.metric.text for objective in objectives])
