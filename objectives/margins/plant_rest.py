"""Where a plant rests, and its slope there over a control period: of its equations by CasADi, of an FMU by its worker process."""

from functools import singledispatch
from typing import Any

import casadi as ca
import numpy as np
from scipy.linalg import expm

from objectives.fmu.messages import Linearise
from objectives.fmu.system import FmuSystem
from objectives.margins.derivative import Derivative, column_of, record_of
from objectives.plant_system import PlantSystem
from plant.backends import symbolic
from plant.fmu.slope import Slope
from plant.model.closing import PlantLoop, resting
from plant.records import flatten, size, zeros

Array = np.ndarray


@singledispatch
def slope_of(system: Any, loop: PlantLoop, parameters: Any) -> Slope:
    """Return the body (b,) of a plant of these parameters at rest, and its derivative a period later by body and commands."""
    raise TypeError(f"nothing linearises {type(system).__name__}")


@slope_of.register
def _(system: FmuSystem, loop: PlantLoop, parameters: Any) -> Slope:
    dynamics, _ = resting(loop, parameters)
    return system.ask(Linearise(np.array(flatten(dynamics), dtype=float)))


@slope_of.register
def _(system: PlantSystem, loop: PlantLoop, parameters: Any) -> Slope:
    """Slope by the exponential of the equations' own, commands held over the period: exact however few steps fly it."""
    plant, poles = system.plant, np.array([1.0 / each.lag if each.lag > 0.0 else 0.0 for each in system.plan.actuators])
    body = np.array(flatten(resting(loop, parameters)[1]), dtype=float)
    n, m = size(plant.State), size(plant.Input)
    slope = _equations(plant, np.array(flatten(parameters), dtype=float), body[: n + m])
    lagging = np.diag((poles > 0.0).astype(float))
    # States, where actuators with a lag are, and commands; the last do not change.
    generator = np.zeros((n + 2 * m, n + 2 * m))
    generator[:n] = np.hstack([slope[:n, :n], slope[:n, n:] @ lagging, slope[:n, n:] @ (np.eye(m) - lagging)])
    generator[n : n + m, n:] = np.hstack([-np.diag(poles), np.diag(poles)])
    moved = expm(system.timing.control_period * generator)
    felt = lagging @ moved[n : n + m]
    felt[:, n + m :] += np.eye(m) - lagging
    shown = slope[n:, :n] @ moved[:n] + slope[n:, n:] @ felt
    after = np.concatenate([moved[:n], felt, shown], axis=0)
    kept = np.arange(n + 2 * m) < n + m
    by = np.zeros((len(body), len(body) + m))
    by[:, : n + m], by[:, len(body) :] = after[:, kept], after[:, ~kept]
    return Slope(body, by)


def _equations(plant: Any, parameters: Array, at: Array) -> Array:
    """Return the derivative of rates and outputs by states and inputs (n + outputs, n + m) where they are `at` (n + m,)."""
    n = size(plant.State)
    inputs, symbols = ca.SX.sym("a", len(at)), ca.SX.sym("p", len(parameters))
    bind = symbolic.rebinder()
    given = (
        record_of(plant.State, inputs[:n]), record_of(plant.Input, inputs[n:]), zeros(plant.Disturbance),
        record_of(plant.Parameters, symbols),
    )  # fmt: skip
    outputs = ca.vertcat(column_of(bind(plant.derivative)(*given)), column_of(bind(plant.output)(*given)))
    equations = Derivative("equations", inputs, [inputs, symbols], outputs, ca.SX(0, 1))
    return equations.full(equations(at, parameters)[1])[0]


def flown_slope_of(system: PlantSystem, loop: PlantLoop, parameters: Any) -> Slope:
    """Return the slope as the Runge-Kutta steps of flights have it, of equations."""
    constants, body = (np.array(flatten(part), dtype=float) for part in resting(loop, parameters))
    b, m, shown = len(body), size(system.plant.Input), size(system.plant.Output)
    inputs, symbols = ca.SX.sym("a", b + m), ca.SX.sym("f", len(constants))
    moved = symbolic.rebinder()(loop.advance)(
        record_of(loop.Body, inputs[:b]), record_of(system.plant.Input, inputs[b:]), zeros(system.plant.Disturbance),
        record_of(loop.records.Dynamics, symbols), system.timing.plant_step,
    )  # fmt: skip
    step = Derivative("advance", inputs, [inputs, symbols], column_of(moved), ca.SX(0, 1))
    held = body[-shown - m : -shown]
    at, unit = body[None], np.eye(b + m)
    slope = unit[:b]
    for _ in range(system.timing.steps):
        at, entries, _ = step(np.concatenate([at, held[None]], axis=1), constants)
        slope = step.full(entries)[0] @ np.concatenate([slope, unit[b:]], axis=0)
    return Slope(body, slope)
