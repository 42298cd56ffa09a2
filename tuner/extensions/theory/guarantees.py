"""The [[guarantee]] tables: theorems that gains must satisfy before they are worth a flight.

A bound on an error (`max`) is worked out for the disturbance rate of each axis, and the worst axis must keep the limit. A
disturbance rate that is borne (`min`) must reach a given number on the worst axis, or else, on every axis, the
disturbance rate of that axis: a requirement for each.
"""

from math import isfinite

from objectives.requirements import Requirement, Screen
from objectives.system import System
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.cascade import Cascade
from plant.quadrotor.gains import GROUPS
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.scenarios import ScenarioSpec
from tuner.extensions.theory.theorems import THEOREMS, Setting, Theorem
from tuner.extensions.theory.theorems.disturbance_rate import worst_rates
from tuner.extensions.theory.theorems.guarantee import Guarantee, law_of, loop_of
from tuner.study.requirement_kinds import RequirementKind
from tuner.study.schema import GuaranteeTable

MEASURED = "measured"


def guarantee_screen(table: GuaranteeTable, system: System, scenarios: tuple[ScenarioSpec, ...], root: int) -> Screen:
    """Return the requirements of a [[guarantee]] table; raises InputError with the key inside the table.

    root: the study's seed; measured rates are those of the search's own scenarios.
    """
    if table.theorem not in THEOREMS:
        raise UnknownNameError("theorem", table.theorem, THEOREMS, key="theorem")
    theorem = THEOREMS[table.theorem]
    if table.axis not in GROUPS:
        raise UnknownNameError("axis or group", table.axis, GROUPS, key="axis")
    axes = GROUPS[table.axis]
    _check_law(theorem, axes[0], system)
    limit = _limit(table, theorem)
    rates, origin = _rates(table, axes, system, scenarios, root)
    settings = {axis: Setting(system.timing.control_period, rates[axis]) for axis in axes}
    guarantee = Guarantee(theorem, system.cascade, settings)
    unit = theorem.unit_in(loop_of(axes[0]))
    if limit is None:
        each = [
            Requirement(
                _label(table, axis),
                f"{theorem.quantity}; the disturbance: {origin}",
                unit,
                rates[axis],
                theorem.sense,
                table.hard,
            )
            for axis in axes
        ]
        return Screen(tuple(each), guarantee.values)
    quantity = _quantity(theorem, axes, [rates[axis] for axis in axes], origin)
    worst = Requirement(_label(table, table.axis), quantity, unit, limit, theorem.sense, table.hard)
    return Screen((worst,), guarantee.worst)


def applicable(law: str, rate_from_observer: bool) -> tuple[str, ...]:
    """Return the names of the theorems that speak of a law."""
    return tuple(name for name, theorem in THEOREMS.items() if theorem.speaks_of(law, rate_from_observer))


def rate_from_observer(nominal: Nominal, axis: str) -> bool:
    """Return True if an axis uses the observed, not the measured rate."""
    chosen = nominal.position_observer if loop_of(axis) == "position" else nominal.attitude_observer
    return chosen > 0.5


def _check_law(theorem: Theorem, axis: str, system: System) -> None:
    cascade: Cascade = system.cascade
    law, observed = law_of(cascade, axis).name, rate_from_observer(system.nominal, axis)
    if theorem.speaks_of(law, observed):
        return
    others = ", ".join(applicable(law, observed)) or "none"
    if law in theorem.laws:
        why = f"'{theorem.name}' holds for '{law}' with measured rates only; set {loop_of(axis)}_rate = \"measured\""
    else:
        why = f"'{theorem.name}' says nothing about '{law}', the law of {axis}, but about {', '.join(theorem.laws)}"
    raise InputError(f"{why}; theorems for it: {others}", key="theorem")


def _limit(table: GuaranteeTable, theorem: Theorem) -> float | None:
    """Return the given limit, None where the axes' disturbance rates are it."""
    given, other = ("max", "min") if theorem.sense == "max" else ("min", "max")
    if getattr(table, other) is not None:
        better = "smaller" if given == "max" else "larger"
        raise InputError(
            f"of '{theorem.name}' ({theorem.quantity}) {better} values are better; give {given} instead", key=other
        )
    limit = getattr(table, given)
    if limit is None and given == "max":
        unit = theorem.unit.replace("{y}", "rad or m")
        raise InputError(f"'{theorem.name}' needs a limit; write max = ... in {unit}", key="max")
    return limit


def _rates(
    table: GuaranteeTable, axes: tuple[str, ...], system: System, scenarios: tuple[ScenarioSpec, ...], root: int
) -> tuple[dict[str, float], str]:
    """Return the disturbance rate of each axis and its origin, in words."""
    given = table.disturbance_rate
    if not isinstance(given, str):
        if not (isfinite(given) and given >= 0.0):
            raise InputError(f"given {given}; a rate must be finite and not negative", key="disturbance_rate")
        return dict.fromkeys(axes, float(given)), "as given"
    if given != MEASURED:
        raise InputError(f"given '{given}'; write \"{MEASURED}\" or a number", key="disturbance_rate")
    chosen = _chosen(table, scenarios)
    _check_quantile(table, chosen, system.timing.control_period)
    rates = worst_rates(chosen, system.vehicle, system.timing, root, table.level, table.window)
    window = system.timing.control_period if table.window is None else table.window
    where = f"scenario {chosen[0].name}" if len(chosen) == 1 else "the worst scenario"
    return rates, f"{100.0 * table.level:g} % quantile of its change over {window:g} s in {where}"


def _chosen(table: GuaranteeTable, scenarios: tuple[ScenarioSpec, ...]) -> tuple[ScenarioSpec, ...]:
    if table.scenario is None:
        return scenarios
    chosen = tuple(spec for spec in scenarios if spec.name == table.scenario)
    if not chosen:
        raise UnknownNameError("scenario", table.scenario, [spec.name for spec in scenarios], key="scenario")
    return chosen


def _check_quantile(table: GuaranteeTable, scenarios: tuple[ScenarioSpec, ...], period: float) -> None:
    if not 0.0 < table.level < 1.0:
        raise InputError(f"given {table.level}; a level lies between 0 and 1, for instance 0.99", key="level")
    shortest = min(spec.duration for spec in scenarios)
    if table.window is not None and not period <= table.window < shortest:
        raise InputError(
            f"given {table.window:g} s; allowed: the control period of {period:g} s to below {shortest:g} s, the "
            "duration of the shortest scenario",
            key="window",
        )


def _label(table: GuaranteeTable, axis: str) -> str:
    where = "" if table.scenario is None else f"@{table.scenario}"
    return f"{table.theorem}({axis}){where}"


def _quantity(theorem: Theorem, axes: tuple[str, ...], rates: list[float], origin: str) -> str:
    worst = theorem.quantity if len(axes) == 1 else f"{theorem.quantity}, worst of {', '.join(axes)}"
    if not theorem.needs_rate:
        return worst
    unit = "m/s^3" if loop_of(axes[0]) == "position" else "rad/s^3"
    shown = " / ".join(f"{rate:.3g}" for rate in dict.fromkeys(rates))
    return f"{worst}; the disturbance changes by {shown} {unit}: {origin}"


KIND = RequirementKind(guarantee_screen, {"theorem": THEOREMS})
