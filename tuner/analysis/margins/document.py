"""Margins of one controller as a document, what `tuner margins --json` prints: values, limits of a study, certificates."""

from collections.abc import Sequence
from math import inf, isfinite
from typing import Any

import numpy as np

from objectives.margins.disk import disk_range
from objectives.margins.limit_cycle import LimitCycle, limit_cycles
from objectives.margins.quantities import QUANTITIES, REPORTED, MarginQuantity
from objectives.margins.requirement import MarginRequirement
from objectives.margins.results import Worst
from objectives.margins.steady_state import HOVER, SteadyState
from objectives.margins.trim import Trim
from objectives.requirements import known_values, requirements_of, worst_place
from objectives.scales import units_of
from plant.errors import InputError
from plant.quadrotor.nominal import nominal
from tuner.analysis.margins.limits import LIMITS, LoopLimit
from tuner.analysis.margins.readings import Loops, PlantSubject, Subject, subject_of
from tuner.documents.margins import (
    MARGINS_FORMAT,
    MARGINS_VERSION,
    ChannelMargins,
    GuaranteedRange,
    LimitCycleRow,
    LimitRow,
    MarginsDocument,
    Measure,
    MultiloopMargins,
    NotedValue,
    Reading,
    SignalAmplitude,
    StateValue,
    TrimPart,
    Vector,
)
from tuner.documents.parts import LawNames
from tuner.gains import Controller
from tuner.study.margins import MarginAnalysis, margin_requirement
from tuner.study.plant_margins import margin_values, margins_asked
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study

UNSTABLE, WITHOUT_END = "the loop is not stable", "no bound"


def margins_document(subject: Subject, requirements: list[LimitRow]) -> MarginsDocument:
    """Return the document of a quadrotor without mismatch and certificates."""
    controller, trim = subject.controller, subject.trim
    return _document(
        subject,
        requirements,
        airframe=controller.airframe.name,
        laws=LawNames(position=controller.cascade.position.name, attitude=controller.cascade.attitude.name),
        control_period=Measure(value=controller.control_period, unit="s"),
        trim=TrimPart(
            yaw=Measure(value=trim.yaw, unit="rad"),
            velocity=Vector(value=list(trim.velocity), unit="m/s"),
            wind=Vector(value=list(trim.wind), unit="m/s"),
            position_held=trim.hold,
        ),
    )


def plant_margins_document(subject: PlantSubject, requirements: list[LimitRow]) -> MarginsDocument:
    """Return the document of a plant of the user's own without certificates."""
    system = subject.system
    return _document(
        subject,
        requirements,
        plant=system.plant.name,
        channel_laws={channel.name: channel.law.name for channel in system.plan.channels},
        control_period=Measure(value=system.timing.control_period, unit="s"),
        limit_cycles=[_cycle_row(subject, cycle) for cycle in limit_cycles(subject.model, subject.row)],
    )


def _cycle_row(subject: PlantSubject, cycle: LimitCycle) -> LimitCycleRow:
    system = subject.system
    units = {
        (term.axis, term.nonlinearity.name): term.nonlinearity.unit.replace("{y}", system.axes.units[term.axis])
        for term in subject.model.terms
    }
    amplitudes = [
        SignalAmplitude(channel=channel, term=term, value=value, unit=units[channel, term])
        for (channel, term), value in cycle.amplitudes.items()
    ]
    frequency = Measure(value=cycle.frequency, unit="rad/s")
    return LimitCycleRow(
        channels=list(cycle.channels), frequency=frequency, amplitudes=amplitudes, attracts=cycle.stable
    )


def _document(subject: Loops, requirements: list[LimitRow], **of_its_kind: Any) -> MarginsDocument:
    """Return the document of any controller, with what only its kind has."""
    return MarginsDocument(
        format=MARGINS_FORMAT,
        version=MARGINS_VERSION,
        channels=[_channel(subject, channel) for channel in subject.looped],
        multiloop=_multiloop(subject),
        requirements=requirements,
        passed=all(row.is_satisfied for row in requirements if row.hard),
        **of_its_kind,
    )


def default_requirements(subject: Loops) -> list[LimitRow]:
    """Return a row for each limit of every loop: stability, hard limits, targets as soft ones."""
    rows = []
    for channel in subject.looped:
        stable = float(subject.margins.stable[0, subject.place(channel)])
        rows.append(
            requirement_row(
                f"stable({channel})", "stable", {"unit": "1"}, stable, 1.0, stable == 1.0, "min", channel=channel
            )
        )
        for limit in LIMITS:
            entry = QUANTITIES[limit.quantity]
            value, label = subject.value(entry, channel), f"{entry.name}({channel})"
            rows.append(limited_row(label, entry, value, limit, True, channel))
            if limit.target is not None:
                target = LoopLimit(entry.name, limit.sense, limit.target)
                rows.append(limited_row(f"{label} target", entry, value, target, False, channel))
    return rows


def requirements_in(subject: Subject) -> list[LimitRow]:
    """Return the rows of the usual limits: in a trim, or at hover and in the gains' own steady states.

    Raises InputError where there is no steady flight.
    """
    controller, vehicle = subject.controller, subject.controller.airframe.vehicle
    assumed = nominal(vehicle, controller.options, controller.control_period)
    judged = [state for state in controller.states if subject.trim == Trim() and state.can_hold(vehicle, assumed)]
    subjects = {HOVER: subject} | {state.name: subject_of(controller, state.trim) for state in judged}
    return worst_rows({name: default_requirements(each) for name, each in subjects.items()})


def worst_rows(by_state: dict[str, list[LimitRow]]) -> list[LimitRow]:
    """Return the rows of all steady states, each in its worst state.

    by_state: rows that differ between states in their values alone.
    """
    if len(by_state) == 1:
        return next(iter(by_state.values()))
    return [_worst_of(dict(zip(by_state, rows, strict=True))) for rows in zip(*by_state.values(), strict=True)]


def _worst_of(rows: dict[str, LimitRow]) -> LimitRow:
    sizes = np.array([inf if row.value is None else row.value for row in rows.values()])
    worst = list(rows)[worst_place(sizes, next(iter(rows.values())).sense)]
    each = [StateValue(state=state, value=row.value) for state, row in rows.items()]
    return rows[worst].model_copy(update={"state": worst, "states": each})


def limited_row(
    label: str, entry: MarginQuantity, value: float, limit: LoopLimit, hard: bool, channel: str | None = None
) -> LimitRow:
    """Return the row of a limit and a value in SI units."""
    is_satisfied, in_si = limit.is_satisfied(float(entry.to_limit(value))), float(entry.from_limit(limit.limit))
    units = units_of(entry.limit_unit, entry.limited)
    return requirement_row(label, entry.name, units, value, in_si, is_satisfied, limit.sense, hard, channel)


def requirement_row(
    label: str,
    quantity: str | None,
    units: dict[str, str],
    value: float,
    limit: float,
    is_satisfied: bool,
    sense: str,
    hard: bool = True,
    channel: str | None = None,
) -> LimitRow:
    """Return one requirement in SI units; channel: the column of the table that it is about, None for several loops at once."""
    row = LimitRow(
        label=label,
        channel=channel,
        quantity=quantity,
        value=finite(value),
        unit=units["unit"],
        limit=limit,
        sense=sense,
        hard=hard,
        kept=is_satisfied,
        note=None if isfinite(value) else WITHOUT_END,
    )
    return row.model_copy(update=units)


def _channel(subject: Loops, channel: str) -> ChannelMargins:
    margins, i = subject.margins, subject.place(channel)
    growth = float(margins.growth[0, i])
    return ChannelMargins(
        channel=channel,
        stable=bool(margins.stable[0, i]),
        growth=_noted(growth, "1/s", "no steady flight was found"),
        amplitude_dependent=subject.swept(channel),
        quantities={name: _reading(subject, QUANTITIES[name], channel) for name in REPORTED},
        disk_range=_range(float(margins.disk.value[0, i]), margins.skew),
    )


def _reading(subject: Loops, quantity: MarginQuantity, channel: str) -> Reading:
    i, margins = subject.place(channel), subject.margins
    worst: Worst = getattr(margins, quantity.field)
    value, case = subject.value(quantity, channel), int(worst.case[0, i])
    note = None if isfinite(value) else quantity.unlimited if margins.stable[0, i] else UNSTABLE
    label = margins.cases[case].label if case >= 0 else None
    return _entry(value, quantity.unit, float(worst.frequency[0, i]), label, note)


def _multiloop(subject: Loops) -> MultiloopMargins:
    worst, margins = subject.margins.multiloop, subject.margins
    value, case = float(worst.value[0]), int(worst.case[0])
    label = margins.cases[case].label if case >= 0 else None
    note = None if isfinite(value) else "no loop is closed at a plant input"
    disk = _entry(value, "1", float(worst.frequency[0]), label, note)
    return MultiloopMargins(disk=disk, disk_range=_range(value, margins.skew))


def _entry(value: float, unit: str, frequency: float, case: str | None, note: str | None) -> Reading:
    where = Measure(value=frequency, unit="rad/s") if frequency > 0.0 else None
    return Reading(value=finite(value), unit=unit, frequency=where, case=case, note=note)


def _range(alpha: float, skew: float) -> GuaranteedRange:
    """Return the gain factors and the phase that a disk guarantees; an infinite disk counts as 1e9."""
    low, high, phase = (float(part) for part in disk_range(min(alpha, 1e9), skew))
    return GuaranteedRange(low=_noted(low, "1"), high=_noted(high, "1"), phase=_noted(phase, "rad"))


def _noted(value: float, unit: str, note: str = WITHOUT_END) -> NotedValue:
    return NotedValue(value=finite(value), unit=unit, note=None if isfinite(value) else note)


def finite(value: float) -> float | None:
    """Return a number, None where it is infinite."""
    return value if isfinite(value) else None


def study_requirements(study: Study, controller: Controller, trim: Trim | None = None) -> list[LimitRow] | None:
    """Return the rows of a study's [[margin]] tables: gains on the study's vehicle; None where it has none.

    trim: where they are judged; by default in every steady state of the study.

    Raises InputError where the study is about other laws.
    """
    for loop in ("position", "attitude"):
        mine, its = (getattr(cascade, loop).name for cascade in (controller.cascade, study.system.cascade))
        if mine != its:
            raise InputError(
                f"the gains are for the {loop} law '{mine}', the study flies '{its}'", file=study.path, key="controller"
            )
    if not study.table.margin:
        return None
    specs = tuple(entry.spec for entry in study.scenarios)
    requirements = tuple(margin_requirement(table, study.system.timing, specs) for table in study.table.margin)
    state = None if trim is None else SteadyState(HOVER, trim.yaw, trim.velocity, trim.wind, trim.hold)
    analysis = MarginAnalysis(requirements, study.system, specs, study.path, state and (state,))
    values = analysis.by_state(np.array([controller.gains]))[:, 0]
    return limited_rows(requirements, values, tuple(state.name for state in analysis.states))


def plant_requirements(study: PlantStudy, row: np.ndarray) -> list[LimitRow] | None:
    """Return the rows of a plant study's margins for a gains row (g,).

    None where the study has no [[margin]] tables.
    """
    specs = [entry.spec for entry in study.scenarios]
    requirements = margins_asked(study.table.margin, study.path, study.system, specs)
    if not requirements:
        return None
    return limited_rows(
        requirements, margin_values(requirements, study.path, study.system, study.space, specs).values(row[None])
    )


def rows_without_loop(study: PlantStudy, row: np.ndarray) -> list[LimitRow]:
    """Return the rows of a plant study's requirements of no loop: gains from a disturbance."""
    screens = study.screens[1:] if study.table.margin else study.screens
    values = known_values(screens, row[None], complete=True)[0]
    return [
        requirement_row(
            each.label,
            None,
            each.units(),
            float(each.in_file(value)),
            float(each.in_file(each.limit)),
            bool(each.is_satisfied(value)),
            each.sense,
            each.hard,
        )
        for each, value in zip(requirements_of(screens), values, strict=True)
    ]


def limited_rows(
    requirements: Sequence[MarginRequirement], values: np.ndarray, states: tuple[str, ...] = ("",)
) -> list[LimitRow]:
    """Return the rows of requirements for values (states, requirements) in the units of limits."""
    return [_worst_row(entry, values[:, i], states) for i, entry in enumerate(requirements)]


def _worst_row(entry: MarginRequirement, values: np.ndarray, states: tuple[str, ...]) -> LimitRow:
    """Return the row of a requirement with values (states,) in its worst state."""
    quantity, si = entry.quantity, [float(entry.quantity.from_limit(value)) for value in values]
    worst = worst_place(values, quantity.sense)
    limit = LoopLimit(quantity.name, quantity.sense, entry.limit)
    row = limited_row(entry.label, quantity, si[worst], limit, entry.hard)
    if len(states) == 1:
        return row
    each = [StateValue(state=state, value=finite(value)) for state, value in zip(states, si, strict=True)]
    return row.model_copy(update={"state": states[worst], "states": each})
