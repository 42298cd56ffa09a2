"""An FMU over one control period, linearised where it starts: by directional derivatives where it gives them, else differences.

Differences are central, each from an initialisation of its own: states are perturbed by their start values, commands over the
period. Either is then held against the FMU over many periods, for states that nothing tells of would make margins wrong.
"""

from typing import Any

import numpy as np
from scipy.linalg import expm

from plant.errors import InputError
from plant.loop import Timing
from plant.model.closing import PlantLoop
from plant.model.plant_model import STILL
from plant.model.slope import Slope
from plant.records import flatten, paths, size
from tuner.extensions.fmu.flying import FmuPlant
from tuner.extensions.fmu.instance import FmuError, Instance

Array = np.ndarray
# Perturbation relative to 1 + |value|: near the cube root of the rounding error, which central differences like best.
NUDGE = 1e-5
# Rest: drift in a period that is rounding, relative to 1 + |state|.
ROUNDED = 1e-9
# The comparison with the FMU: periods, the step of a command relative to 1 + |value|, and the largest error as a share of the
# largest change.
PERIODS, PROBE, CLOSE = 64, 1e-3, 1e-2


def slope_at_start(loop: PlantLoop, instance: Instance, timing: Timing, dynamics: Array, directional: bool) -> Slope:
    """Return the slope of an FMU with these constants; InputError where it does not rest, or hides states."""
    fmu = _Period(loop, FmuPlant(loop, instance, timing), dynamics.tolist())
    _check_rest(fmu, timing.control_period)
    jacobian = _directional_derivatives(fmu, instance) if directional else None
    by = _differences(fmu) if jacobian is None else _sampled(fmu, jacobian, timing)
    _check_states(fmu, by)
    return Slope(fmu.body, by)


class _Period:
    """Control periods as a function of initial state and commands."""

    def __init__(self, loop: PlantLoop, fmu_plant: FmuPlant, dynamics: list[float]) -> None:
        self.loop, self.dynamics, self._fmu_plant = loop, dynamics, fmu_plant
        plant = loop.plant
        self.states, self.inputs = size(plant.State), size(plant.Input)
        self.body = np.array(flatten(self.begin()))
        self.held = self.body[self.states : self.states + self.inputs]
        self.quiet = [0.0] * size(plant.Disturbance)
        self.poles = np.array(dynamics[size(plant.Parameters) :])

    def begin(self, states: list[float] | None = None) -> Any:
        """Initialise the FMU and return its body."""
        return self._fmu_plant.begin(self.dynamics, states)

    def after(self, states: Array, actuators: Array, command: Array, periods: int = 1) -> Array:
        """Return the bodies (periods, b) after each period under one command."""
        fmu_plant, h = self._fmu_plant, self._fmu_plant.period
        moved = np.any(states != self.body[: self.states])
        body = self.begin(states.tolist() if moved else None)
        body = body._replace(actuators=type(body.actuators)(*actuators.tolist()))
        bodies = []
        for k in range(periods):
            body = fmu_plant.advance(body, command.tolist(), self.quiet, k * h)
            bodies.append(flatten(body))
        if fmu_plant.failed:
            raise FmuError(fmu_plant.failed)
        return np.array(bodies)


def _check_rest(fmu: _Period, h: float) -> None:
    rest = fmu.body[: fmu.states]
    after = fmu.after(rest, fmu.held, fmu.held)[0, : fmu.states]
    drift = np.abs(after - rest) / (1.0 + np.abs(rest))
    if not np.all(drift <= STILL * h + ROUNDED):
        worst = int(np.argmax(drift))
        raise InputError(
            f"the FMU does not rest where it starts: {paths(fmu.loop.plant.State)[worst]} goes from {rest[worst]:.6g} to "
            f"{after[worst]:.6g} in the first period; give it start values that hold it, or leave the margins out",
            key="margin",
        )


def _differences(fmu: _Period) -> Array:
    x, m = fmu.states, fmu.inputs
    at = np.concatenate([fmu.body[: x + m], fmu.held])
    by = np.zeros((len(fmu.body), len(fmu.body) + m))
    shown = len(fmu.body) - x - m
    for column, value in enumerate(at):
        nudge = np.zeros(len(at))
        nudge[column] = NUDGE * (1.0 + abs(value))
        above, below = (_one_period(fmu, at + sign * nudge) for sign in (1.0, -1.0))
        by[:, column if column < x + m else column + shown] = (above - below) / (2.0 * nudge[column])
    return by


def _one_period(fmu: _Period, at: Array) -> Array:
    """Return the body (b,) a period later; at: states, actuators and commands."""
    x, m = fmu.states, fmu.inputs
    return fmu.after(at[:x], at[x : x + m], at[x + m :])[0]


def _directional_derivatives(fmu: _Period, instance: Instance) -> Array | None:
    """Return the derivatives of state rates and outputs by states and inputs; None where the FMU does not keep its promise."""
    fmu.begin()
    try:
        slope = np.array(instance.slopes()).T
    except FmuError:
        return None
    return slope if np.isfinite(slope).all() else None


def _sampled(fmu: _Period, slope: Array, timing: Timing) -> Array:
    """Return the slope of the loop from that of the equations.

    These are x' = A x + B u, y = C x + D u, with u held over each plant step as it is in flights.
    """
    x, m, b = fmu.states, fmu.inputs, len(fmu.body)
    generator = np.zeros((x + m, x + m))
    generator[:x] = slope[:x]
    moved = expm(generator * timing.plant_step)[:x]
    left, mean = _lags(fmu.poles, timing.plant_step)
    to_states, to_there = np.eye(x, b + m), np.eye(m, b + m, x)
    command = np.eye(m, b + m, b)
    felt = command
    for _ in range(timing.steps):
        felt = mean[:, None] * to_there + (1.0 - mean)[:, None] * command
        to_states = moved[:, :x] @ to_states + moved[:, x:] @ felt
        to_there = left[:, None] * to_there + (1.0 - left)[:, None] * command
    return np.concatenate([to_states, to_there, slope[x:, :x] @ to_states + slope[x:, x:] @ felt], axis=0)


def _lags(poles: Array, step: float) -> tuple[Array, Array]:
    """Return the shares left of actuators' positions after and over a step [s].

    The second is the mean over the step; both are 0 without a lag.
    """
    lagging = poles > 0.0
    left = np.where(lagging, np.exp(-poles * step), 0.0)
    return left, np.where(lagging, (1.0 - left) / np.where(lagging, poles * step, 1.0), 0.0)


def _check_states(fmu: _Period, by: Array) -> None:
    """Raise InputError for a slope that contradicts the FMU's step responses."""
    x, m, b = fmu.states, fmu.inputs, len(fmu.body)
    still = fmu.after(fmu.body[:x], fmu.held, fmu.held, PERIODS)[:, x + m :]
    for i in range(m):
        command = fmu.held.copy()
        command[i] += PROBE * (1.0 + abs(command[i]))
        seen = fmu.after(fmu.body[:x], fmu.held, command, PERIODS)[:, x + m :] - still
        state, modeled = np.zeros(b), []
        for _ in range(PERIODS):
            state = by @ np.concatenate([state, command - fmu.held])
            modeled.append(state[x + m :])
        wrong = np.abs(np.array(modeled) - seen).max(axis=0)
        if not np.all(wrong <= CLOSE * np.abs(seen).max(axis=0) + ROUNDED):
            worst = int(np.argmax(wrong))
            raise InputError(
                f"linearised in {', '.join(paths(fmu.loop.plant.State))}, {paths(fmu.loop.plant.Output)[worst]} answers a step "
                f"of {paths(fmu.loop.plant.Input)[i]} otherwise than the FMU does; name all of its states in [plant] states, or "
                "leave the margins out",
                key="margin",
            )
