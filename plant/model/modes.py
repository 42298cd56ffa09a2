"""Modes of a plant where it rests, and the longest Runge-Kutta step that does not make them grow.

A step h of the classical method takes a mode with the pole s to R(z) = 1 + z + z^2/2 + z^3/6 + z^4/24 of itself, z = h s:
E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., Springer, 1996, section IV.2.
"""

from math import ceil
from typing import Any

import numpy as np

from plant.errors import InputError
from plant.loop import Timing
from plant.model.plant_model import PlantModel
from plant.records import flatten, pack, zeros

Array = np.ndarray
# Perturbation relative to 1 + |value|: near the cube root of the rounding error, which central differences like best.
NUDGE = 1e-5
# |z| within which the method is stable for every mode that decays: 2.785 on the real axis, 2.828 on the imaginary one.
STABLE = 2.6


def poles_at_rest(plant: PlantModel, parameters: Any) -> Array:
    """Return the poles (states,) [rad/s] of a plant at rest, inputs held; none where its equations have no slope there."""
    state, held, _ = plant.at_rest(parameters)
    quiet, at = zeros(plant.Disturbance), np.array(flatten(state), dtype=float)

    def rate(x: Array) -> Array:
        return np.array(flatten(plant.derivative(pack(plant.State, x.tolist()), held, quiet, parameters)), dtype=float)

    nudges = np.diag(NUDGE * (1.0 + np.abs(at)))
    try:
        slope = np.array([(rate(at + each) - rate(at - each)) / (2.0 * each.sum()) for each in nudges]).T
    except (ArithmeticError, ValueError):
        return np.array([])
    return np.linalg.eigvals(slope) if np.isfinite(slope).all() else np.array([])


def check_plant_step(plant: PlantModel, parameters: Any, timing: Timing) -> None:
    """Refuse a plant step under which a mode that decays would grow; InputError with the key and a step that is short enough."""
    z = timing.plant_step * poles_at_rest(plant, parameters)
    grown = np.abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))))
    wrong = z[(z.real < 0.0) & (grown > 1.0)]
    if len(wrong):
        fastest = np.abs(wrong).max() / timing.plant_step
        enough = timing.control_period / ceil(timing.control_period * fastest / STABLE)
        raise InputError(
            f"given {timing.plant_step:g} s; at rest the plant has a mode with a time constant of {1.0 / fastest:.3g} s, which "
            f"would grow at such steps: write plant_step = {enough:g} or less, a whole part of the control period",
            key="plant_step",
        )
