"""Warnings before a run, some of them from the vehicle alone."""

from collections.abc import Sequence
from math import degrees, pi, radians, tau

import numpy as np

from objectives.problem import Objective
from objectives.risk import clopper_pearson, flights_to_show, minimum_samples
from objectives.risk.measures import TAIL_SCENARIOS
from plant.model.modes import poles_at_rest
from plant.quadrotor.scenarios import HELD_OUT, SEARCH
from tuner.gains import read_gains
from tuner.search.names import ALGORITHMS
from tuner.study.plant_study import PlantStudy
from tuner.study.study import SearchedStudy, Study, differences

MIN_ANGLE = 0.5 * pi
"""Limit on a margin [deg] below which it looks like one in radians: a right angle is 1.57."""


def few_scenarios(study: SearchedStudy) -> list[str]:
    """Warn of risks that ask more of the scenarios than there are.

    A search that flies few scenarios does so on purpose, be it a model's or one that flies few first: its values only say what
    goes on to the held-out check.
    """
    few = study.search.first is not None or ALGORITHMS[study.search.algorithm].usual.first is not None
    streams = (HELD_OUT,) if few else (SEARCH, HELD_OUT)
    return [
        f"{objective.label} rests on {have} {stream} scenarios; {need} would put {TAIL_SCENARIOS} into its tail, so expect "
        f"its {stream} value to be optimistic."
        for objective in study.objectives
        for stream in streams
        if (have := _count(study, objective, stream)) < (need := minimum_samples(objective.risk))
    ]


def unprovable_shares(study: SearchedStudy) -> list[str]:
    """Warn of share limits that held-out flights cannot prove; not even without a single event."""
    return [
        f"{entry.objective.label} at most {entry.most:g} cannot be shown by {have} held-out flights, not even if none is lost: "
        f"their {100.0 * entry.confidence:g} % interval ends at {high:.2g}. It takes {need:,} flights: raise held_out, or ask "
        "max = 0 (none of those flown), or confidence = 0 (the value alone)."
        for entry in study.constraints
        if entry.objective.is_binary
        and entry.objective.risk.name == "mean"
        and not entry.rests_on_value
        and (have := _count(study, entry.objective, HELD_OUT)) < (need := flights_to_show(entry.most, entry.confidence))
        and (high := float(clopper_pearson(0, have, entry.confidence).high))
    ]


def wrong_units(study: SearchedStudy) -> list[str]:
    """Warn of limits that look like numbers of another unit."""
    metrics = [
        f"{entry.objective.label} at most {entry.most:g}: {text}."
        for entry in study.constraints
        if not entry.floor and (text := _unit_fault(entry.objective.metric.unit, entry.most))
    ]
    margins = [
        f"{entry.label} at least {entry.limit:g} deg: the limit is in deg; {entry.limit:g} rad is {degrees(entry.limit):.3g}."
        for entry in study.requirements
        if entry.unit == "deg" and entry.limit < MIN_ANGLE
    ]
    return metrics + margins


def _unit_fault(unit: str, most: float) -> str:
    """Return the fault of a limit in its unit, "" without one."""
    if unit == "rad" and most > pi:
        return f"no flight has so large an angle; limits are in rad, {most:g} deg is {radians(most):.4g}"
    if unit == "%" and 0.0 < most < 1.0:
        return f"the limit is in per cent; a share of {most:g} is {100.0 * most:g}"
    return ""


def _count(study: SearchedStudy, objective: Objective, stream: str) -> int:
    seen = [entry for entry in study.scenarios if objective.scenario in (None, entry.spec.name)]
    return sum(entry.search if stream == SEARCH else entry.held_out for entry in seen)


def default_elsewhere(study: Study) -> list[str]:
    """Warn of `controller.default` gains flown otherwise or merged into one searched value."""
    given = study.table.controller.default
    if given is None:
        return []
    texts = []
    others = differences(read_gains(study.path.parent / given), study)
    if others:
        texts.append(
            f"{given} differs from what this study flies: {'; '.join(others)}. So the Default column is not what that vehicle "
            "does: write the file's values into [controller] and [airframe] of the study, or import the file with the study's."
        )
    return [*texts, *_merged(study)]


def _merged(study: Study) -> list[str]:
    row = study.default_row
    split = [
        f"{variable.name} ({', '.join(f'{row[column]:.4g}' for column in columns)})"
        for variable, columns in zip(study.space.variables, study.space.columns, strict=True)
        if len({float(row[column]) for column in columns}) > 1
    ]
    if not split:
        return []
    example = next(
        variable.addresses[place]
        for variable, columns in zip(study.space.variables, study.space.columns, strict=True)
        for place, column in enumerate(columns)
        if row[column] != row[columns[0]]
    )
    return [
        f"One value is searched where the default has several: {', '.join(split)}; tables show the first. Give axes keys of "
        f'their own in [gains], for instance "{example}" = {{}}, to search them apart.'
    ]


def unjudged_channels(held: Sequence[tuple[str, str]], free: Sequence[tuple[str, str]]) -> list[str]:
    """Warn of channels that no objective or limit of a study judges; each with its scenario.

    Args:
        held: Those that an automatic limit holds.
        free: Those whose automatic limit the study switches off.
    """
    texts = []
    for places, what in (
        (held, "an automatic limit alone holds it"),
        (free, "mission.off leaves it without any limit"),
    ):
        if places:
            channel, scenario = places[0]
            named = ", ".join(f'{name} in scenario "{at}"' for name, at in places)
            texts.append(
                f"No objective and no limit of the study judges {named}: {what}, and the search looks for nothing better. "
                f'Add for instance [[objective]] metric = "rms.{channel}", scenario = "{scenario}".'
            )
    return texts


def signals_after_end(study: PlantStudy) -> list[str]:
    """Warn of references and disturbances that begin once the flight is over."""
    return [
        f'Scenario "{entry.spec.name}": {key}.{name} {"steps" if signal.kind == "step" else "begins"} at {signal.begin:g} s, '
        f"after the end at {entry.spec.duration:g} s, so nothing of it is flown: begin it earlier, or raise duration."
        for entry in study.scenarios
        for key, signals in (("reference", entry.spec.references), ("disturbance", entry.spec.disturbances))
        for name, signal in signals.items()
        if signal.begin >= entry.spec.duration
    ]


def unsampled_modes(study: PlantStudy) -> list[str]:
    """Warn of modes that swing above half the sampling rate."""
    system = study.system
    if not system.has_equations:
        return []
    poles = poles_at_rest(system.equations, system.parameters, system.plan.actuators)
    swings, half = np.abs(np.imag(poles)) / tau, 0.5 / system.timing.control_period
    if not swings.max(initial=0.0) > half:
        return []
    return [
        f"At rest a mode swings at {swings.max():.3g} Hz, above half the sampling rate, {half:.4g} Hz, so samples show it at a "
        f"lower frequency: write a control_period up to {0.5 / swings.max():.3g} s."
    ]


def rates_without_damping(study: Study) -> list[str]:
    """Warn of gust rates that act on nothing."""
    named = [entry.spec.name for entry in study.scenarios if entry.spec.air.angular_rates]
    if not named or any(study.system.vehicle.rate_damping):
        return []
    return [
        f"angular_rates = true in {', '.join(named)} changes no number: gust rates act through rate_damping, which is 0 for "
        f"{study.airframe.name}. Give the airframe a rate_damping with its source, or leave angular_rates out."
    ]
