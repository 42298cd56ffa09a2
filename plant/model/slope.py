"""A plant linearized where it rests: its equations, and its body over a control period by the exponential or by flown steps."""

from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from scipy.linalg import expm

from plant.backends import symbolic
from plant.loop import Timing
from plant.model.closing import PlantLoop, resting
from plant.model.plant_model import PlantModel, PlantRecords
from plant.records import flatten, pack, size, zeros

Array = np.ndarray


class Slope(NamedTuple):
    """body: (b,) where the plant rests. by: (b, b + inputs), derivative of the body a period later by body and commands."""

    body: Array
    by: Array


class LinearEquations(NamedTuple):
    """x' = a x + b u, y = c x + d u about rest; u: inputs, then disturbances."""

    a: Array
    b: Array
    c: Array
    d: Array


def linear_equations(plant: PlantRecords, parameters: Any) -> LinearEquations:
    """Return the equations of a plant of these parameters linearized where it rests, by exact derivatives."""
    assert isinstance(plant, PlantModel), plant.name
    at = np.array(flatten(plant.at_rest(parameters)[:2]), dtype=float)
    sizes = [size(kind) for kind in (plant.State, plant.Input, plant.Disturbance, plant.Parameters)]
    columns = [ca.SX.sym(name, rows) for name, rows in zip("xuwp", sizes, strict=True)]
    kinds = (plant.State, plant.Input, plant.Disturbance, plant.Parameters)
    given = [
        pack(kind, ca.vertsplit(column) if rows else [])
        for kind, column, rows in zip(kinds, columns, sizes, strict=True)
    ]
    bind, signals = symbolic.rebinder(), ca.vertcat(*columns[:3])
    outputs = ca.vertcat(*flatten(bind(plant.derivative)(*given)), *flatten(bind(plant.output)(*given)))
    slope = ca.Function("equations", columns, [ca.densify(ca.jacobian(outputs, signals))])
    n, held = sizes[0], np.zeros(sizes[2])
    jacobian = np.array(slope(at[:n], at[n:], held, np.array(flatten(parameters), dtype=float)), dtype=float)
    return LinearEquations(jacobian[:n, :n], jacobian[:n, n:], jacobian[n:, :n], jacobian[n:, n:])


def exact_slope(loop: PlantLoop, timing: Timing, parameters: Any) -> Slope:
    """Return the slope by the exponential of the equations' own, commands held over the period, however few steps fly it."""
    plant, poles = loop.plant, np.array([1.0 / each.lag if each.lag > 0.0 else 0.0 for each in loop.plan.actuators])
    body = np.array(flatten(resting(loop, parameters)[1]), dtype=float)
    n, m = size(plant.State), size(plant.Input)
    equations = linear_equations(plant, parameters)
    b, d = equations.b[:, :m], equations.d[:, :m]
    lagging = np.diag((poles > 0.0).astype(float))
    # States, where actuators with a lag are, and commands; the last do not change.
    generator = np.zeros((n + 2 * m, n + 2 * m))
    generator[:n] = np.hstack([equations.a, b @ lagging, b @ (np.eye(m) - lagging)])
    generator[n : n + m, n:] = np.hstack([-np.diag(poles), np.diag(poles)])
    moved = expm(timing.control_period * generator)
    felt = lagging @ moved[n : n + m]
    felt[:, n + m :] += np.eye(m) - lagging
    shown = equations.c @ moved[:n] + d @ felt
    after = np.concatenate([moved[:n], felt, shown], axis=0)
    state = np.arange(n + 2 * m) < n + m
    by = np.zeros((len(body), len(body) + m))
    by[:, : n + m], by[:, len(body) :] = after[:, state], after[:, ~state]
    return Slope(body, by)


def flown_slope(loop: PlantLoop, timing: Timing, parameters: Any) -> Slope:
    """Return the slope as the Runge-Kutta steps of flights have it."""
    constants, body = (np.array(flatten(part), dtype=float) for part in resting(loop, parameters))
    b, m, shown = len(body), size(loop.plant.Input), size(loop.plant.Output)
    inputs, symbols = ca.SX.sym("a", b + m), ca.SX.sym("f", len(constants))
    moved = symbolic.rebinder()(loop.advance)(
        pack(loop.Body, ca.vertsplit(inputs[:b])),
        pack(loop.plant.Input, ca.vertsplit(inputs[b:])),
        zeros(loop.plant.Disturbance),
        pack(loop.records.Dynamics, ca.vertsplit(symbols)),
        timing.plant_step,
    )
    outputs = ca.vertcat(*flatten(moved))
    step = ca.Function("advance", [inputs, symbols], [outputs, ca.densify(ca.jacobian(outputs, inputs))])
    held = body[-shown - m : -shown]
    at, unit = body, np.eye(b + m)
    slope = unit[:b]
    for _ in range(timing.steps):
        after, by = step(np.concatenate([at, held]), constants)
        at, slope = np.array(after).ravel(), np.array(by) @ np.concatenate([slope, unit[b:]], axis=0)
    return Slope(body, slope)
