"""Modes of a plant with its actuators at rest, and the Runge-Kutta steps that fly them accurately.

A step h of the classical method takes a mode with the pole s to R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24 of itself, z = h s, and N
steps in a control period T = N h to R(z)^N, where the exact mode has e^(T s): E. Hairer, G. Wanner, Solving Ordinary Differential
Equations II, 2nd ed., Springer, 1996, section IV.2. Inputs are held over the period, so the map from one control instant to the
next is exact as far as R(z)^N is. That judges slow and fast modes alike: of slow ones the error adds up over many periods and
shifts frequency and damping by |z|^4/120 of |s|; a fast one only has to be settled by the end of the period.
"""

from collections.abc import Sequence
from math import ceil, tau
from typing import Any

import numpy as np

from plant.errors import InputError
from plant.loop import Timing
from plant.model.plan import Actuator
from plant.model.plant_model import PlantModel
from plant.records import flatten, pack, zeros

Array = np.ndarray
# Perturbation relative to 1 + |value|: near the cube root of the rounding error, which central differences like best.
NUDGE = 1e-5
# Largest error of a mode in a control period, as a share of what the mode decays or grows by in it, at most all.
MAX_ERROR = 1e-3
# Damping ratio below which a mode counts as one of that damping: controllers damp modes that have none.
MIN_DAMPING = 1e-3
# Least of what a mode does in a period that counts, above the rounding error of a pole at 0.
ROUNDING = 1e-9
# Largest |z|: the modes of drawn plants may be 1.85 times as fast before the method diverges, at 2.785.
MAX_STRIDE = 1.5
# Most steps in a control period that a study takes of itself.
MAX_STEPS = 128


def poles_at_rest(plant: PlantModel, parameters: Any, actuators: Sequence[Actuator] = ()) -> Array:
    """Return the poles [rad/s] of a plant at rest, inputs held, and of its actuators.

    Those of the plant are missing where its equations have no slope at rest.
    """
    lags = np.array([-1.0 / actuator.lag for actuator in actuators if actuator.lag > 0.0])
    state, held, _ = plant.at_rest(parameters)
    quiet, at = zeros(plant.Disturbance), np.array(flatten(state), dtype=float)

    def rate(x: Array) -> Array:
        return np.array(flatten(plant.derivative(pack(plant.State, x.tolist()), held, quiet, parameters)), dtype=float)

    nudges = np.diag(NUDGE * (1.0 + np.abs(at)))
    try:
        slope = np.array([(rate(at + each) - rate(at - each)) / (2.0 * each.sum()) for each in nudges]).T
    except (ArithmeticError, ValueError):
        return lags
    return np.concatenate([np.linalg.eigvals(slope), lags]) if np.isfinite(slope).all() else lags


def accurate_steps(z: Array) -> int:
    """Return the fewest steps that take modes (n,) accurately over a period in which they do z = T s; above 100 within 1 %."""
    grown = np.maximum(np.real(z), 0.0)
    exact = np.exp(z - grown)
    allowed = MAX_ERROR * np.clip(np.abs(np.real(z)), np.maximum(MIN_DAMPING * np.abs(z), ROUNDING), 1.0)
    steps = max(1, ceil(np.abs(z).max(initial=0.0) / MAX_STRIDE - 1e-9))
    while np.any(np.abs((_factor(z / steps) * np.exp(-grown / steps)) ** steps - exact) > allowed):
        steps += 1 + steps // 100
    return steps


def accurate_timing(poles: Array, control_period: float) -> Timing:
    """Return a control period [s] in the fewest equal plant steps that fly modes with poles [rad/s] accurately.

    Raises InputError with the key where these are more than MAX_STEPS.
    """
    steps = accurate_steps(control_period * poles)
    if steps > MAX_STEPS:
        _refuse_unsampled(poles, control_period)
        raise InputError(
            f"not given; {_fastest(poles)}, which takes {steps} steps in a control period, and up to {MAX_STEPS} are taken by "
            f"default: leave out what settles so fast, or write plant_step = {control_period / steps:.12g} and wait",
            key="plant_step",
        )
    return Timing(control_period, control_period / steps)


def check_plant_step(poles: Array, timing: Timing) -> None:
    """Refuse a plant step under which a mode that decays would grow; InputError with the key and a step that is short enough."""
    z = timing.plant_step * poles
    wrong = poles[(z.real < 0.0) & (np.abs(_factor(z)) > 1.0)]
    if len(wrong):
        enough = timing.control_period / accurate_steps(timing.control_period * poles)
        raise InputError(
            f"given {timing.plant_step:g} s; {_fastest(wrong)}, which would grow at such steps: leave plant_step out, or write "
            f"plant_step = {enough:.12g}",
            key="plant_step",
        )


def _refuse_unsampled(poles: Array, control_period: float) -> None:
    """Refuse a control period [s] below two samples in each swing."""
    fastest, sampled = poles[np.argmax(np.abs(poles))], 0.5 / control_period
    swing = abs(fastest.imag) / tau
    if swing > sampled:
        raise InputError(
            f"given {control_period:g} s; at rest a mode swings at {swing:.4g} Hz, above half the sampling rate, "
            f"{sampled:.4g} Hz: write a control period up to {0.5 / swing:.3g} s",
            key="control_period",
        )


def _factor(z: Array) -> Array:
    """R(z) of the classical method."""
    return 1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))


def _fastest(poles: Array) -> str:
    return f"at rest plant and actuators have a mode with a time constant of {1.0 / np.abs(poles).max():.3g} s"
