"""The [observer] table of a plant's study, designed for its nominal plant."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from plant.errors import InputError, check_name
from plant.model.observer import Observer
from plant.model.plan import LoopPlan
from plant.model.plant_model import PlantRecords
from plant.records import flatten, paths
from tuner.study.plant_schema import ObserverTable

Array = np.ndarray
# Largest distance of a placed pole from its place.
MAX_POLE_ERROR = 1e-6
HIDDEN = "no observer exists: a state does not show in what is measured; measure another output"
# Digits of the numbers of an observer, because the last ones of linear algebra differ between machines.
DIGITS = 12


def with_observer(table: ObserverTable, plant: PlantRecords, plan: LoopPlan, parameters: Any, h: float) -> LoopPlan:
    """Return a plan with the observer of a study.

    Args:
        table: The table.
        plant: The plant.
        plan: Its loops.
        parameters: Nominal parameters.
        h: Control period [s].
    """
    if not hasattr(plant, "derivative"):
        raise InputError(
            "given with an FMU, which has no equations; allowed: plants in Python and linear ones: remove it"
        )
    late = [each.name for each in plan.actuators if each.lag > 0.0]
    if late:
        raise InputError(f"given with a lag of {late[0]}; allowed: delays; make the lag a state of the plant")
    for i, name in enumerate(table.measured):
        check_name("output", name, paths(plant.Output), key=f"measured[{i}]")
    outputs = tuple(name for name in paths(plant.Output) if name in {*table.measured, *plan.sensed})
    rest, (a, b) = plant.at_rest(parameters), _sampled(plant, parameters, outputs, h)
    picked = np.eye(len(outputs))[[outputs.index(name) for name in table.measured]]
    correction = _correction(table, paths(plant.Input), a, b, picked, h)
    shown = [getattr(rest[2], name) for name in outputs]
    numbers = [*shown, *flatten(rest[1]), *np.concatenate([part.ravel() for part in (a, b, correction)]).tolist()]
    title = "; ".join(f"{key} {value}" for key, value in table.model_dump(exclude_defaults=True).items())
    rounded = tuple(float(f"{number:.{DIGITS}g}") for number in numbers)
    observer = Observer(outputs, paths(plant.Input), tuple(table.measured), table.filtered, title, rounded)
    return replace(plan, observer=observer)


def _sampled(plant: PlantRecords, parameters: Any, outputs: tuple[str, ...], h: float) -> tuple[Array, Array]:
    """Return the matrices of one control period between outputs; commands are held."""
    from plant.model.slope import linear_equations
    from tuner.extensions.design_rules.sampling import sampled_outputs

    equations, inputs = linear_equations(plant, parameters), range(len(paths(plant.Input)))
    rows = [paths(plant.Output).index(name) for name in outputs]
    if equations.d[rows][:, inputs].any():
        raise InputError(
            "an output follows an input at once; an observer needs outputs of states alone", key="measured"
        )
    sampled = sampled_outputs(equations, rows, inputs, h)
    if sampled is None:
        raise InputError(
            f"given {len(equations.a)} states and the outputs {', '.join(outputs)}; allowed: as many independent outputs, "
            "measured or read by channels, as states: give each state an output",
            key="measured",
        )
    return sampled


def _correction(table: ObserverTable, inputs: Iterable[str], a: Array, b: Array, picked: Array, h: float) -> Array:
    """Return the correction M (n, p) by what is measured: by poles or as a Kalman filter."""
    if table.time is None:
        r = np.diag(_variances("noise", table.noise, table.measured))
        q = b @ np.diag(_variances("input_noise", table.input_noise, inputs)) @ b.T
        return _kalman(a, picked, q, r)
    if table.noise or table.input_noise:
        raise InputError("given with noise; allowed: time, or noise and input_noise", key="time")
    if not (isfinite(table.time) and table.time > 0.0):
        raise InputError(f"given {table.time:g} s; allowed: a finite number above 0", key="time")
    return _placed(a, picked, table.time, h)


def _variances(key: str, given: Mapping[str, float], names: Iterable[str]) -> list[float]:
    names = list(names)
    for name in given:
        check_name("signal", name, names, key=f"{key}.{name}")
    for name in names:
        value = given.get(name)
        if value is None:
            raise InputError(f"given no number for {name}; write one for each of {', '.join(names)}, or time", key=key)
        if not (isfinite(value) and value > 0.0):
            raise InputError(f"given {value:g}; allowed: a finite number above 0", key=f"{key}.{name}")
    return [given[name] ** 2 for name in names]


def _kalman(a: Array, picked: Array, q: Array, r: Array) -> Array:
    from scipy.linalg import solve_discrete_are

    try:
        p = solve_discrete_are(a.T, picked.T, q, r)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise InputError(HIDDEN, key="measured") from error
    return np.linalg.solve(picked @ p @ picked.T + r, picked @ p).T


def _placed(a: Array, picked: Array, time: float, h: float) -> Array:
    from scipy.signal import place_poles

    from tuner.extensions.design_rules.sampling import spaced_poles

    poles = spaced_poles(time, h, len(a))
    try:
        correction = np.asarray(vars(place_poles(a.T, (picked @ a).T, poles))["gain_matrix"]).T
    except ValueError as error:
        raise InputError(f"the poles cannot be placed: {error}", key="time") from error
    reached = np.sort_complex(np.linalg.eigvals(a - correction @ picked @ a))
    if not np.abs(reached - np.sort(poles)).max() < MAX_POLE_ERROR:
        raise InputError(HIDDEN, key="measured")
    return correction
