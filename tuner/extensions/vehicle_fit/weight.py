"""The weight as a datum: mean lift at the commands that carry the vehicle.

A flight whose lift hardly follows its commands identifies no thrust curve, but its mean lift gives the thrust at the mean
command. Two numbers of each flight are observed, its mean lift and the change of its lift from begin to end, which is a
battery's. The prior is conditioned on them, and the thrusts are then held: turning alone would bend the curve.
"""

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.vehicle_fit.fit import Problem
from tuner.extensions.vehicle_fit.parameters import NODES, THRUSTS, ParameterSpace
from tuner.extensions.vehicle_fit.samples import OUTPUTS

Array = NDArray[np.float64]

MEAN_STD = 0.02
"""Standard deviation of mean lift, in weights: at 5 m/s a rotor lifts 3 to 10 % more than in hover; 0.2 m/s of climb take 1 %."""
CHANGE_STD = 0.03
"""Standard deviation of the change of lift over a flight, in weights."""
CURVE_LENGTH = 0.9
"""Length of the prior's correlation between thrusts, in logarithms of the command: with a standard deviation of 0.5 it leaves
0.55 to the exponent of thrust over command, which is 1.3 to 2 of known vehicles and 2 of most priors.
"""
N_UPDATES = 4
"""Number of linearizations: of thrusts that are off by a factor of two, the last moves 0.1 %."""
LIFT_COLUMN = OUTPUTS.index("lift")
LIFT_COORDINATES = ("mass", *THRUSTS, "lift_bias", "sag")
"""Beginnings of the names of coordinates that mean lift depends on."""


def condition_on_weight(problem: Problem, point: Array) -> ParameterSpace:
    """Return the space with its prior conditioned on the weight.

    Args:
        problem: Logs, and the prior before the weight.
        point: Coordinates (n,), of which those that mean lift hardly depends on are taken, as lags.
    """
    space = problem.space
    covariance = space.covariance if space.earlier is not None else one_curve(space)
    columns = [k for k, name in enumerate(space.names) if name.partition("(")[0] in LIFT_COORDINATES]
    reached = point.copy()
    reached[columns] = space.center[columns]
    mean, reduction = space.center, np.zeros_like(covariance)
    for _ in range(N_UPDATES):
        residuals, slopes = problem.sensitivities(reached, columns)
        jacobian = np.zeros((2 * space.logs, len(point)))
        jacobian[:, columns] = weigh(problem, slopes)
        gain = covariance @ jacobian.T @ np.linalg.inv(jacobian @ covariance @ jacobian.T + np.eye(len(jacobian)))
        off = weigh(problem, residuals) + jacobian @ (reached - space.center)
        mean, reduction = space.center + gain @ off, gain @ jacobian @ covariance
        reached[columns] = mean[columns]
    return space.conditioned(mean, covariance - reduction)


def one_curve(space: ParameterSpace) -> Array:
    """Return the prior's covariance (n, n) with thrusts correlated along the curve."""
    covariance, nodes = space.covariance.copy(), [space.names.index(name) for name in THRUSTS]
    distance = np.subtract.outer(np.log(NODES), np.log(NODES)) / CURVE_LENGTH
    std = space.prior_std[nodes]
    covariance[np.ix_(nodes, nodes)] = np.outer(std, std) * np.exp(-0.5 * distance**2)
    return covariance


def weigh(problem: Problem, series: list[Array]) -> Array:
    """Return mean and change of lift (2 flights, ...), in standard deviations.

    series: outputs, residuals or derivatives (m, 4, ...) of every segment.
    """
    rows = np.zeros((2 * problem.space.logs, *series[0].shape[2:]))
    for log in range(problem.space.logs):
        chosen = [k for k, part in enumerate(problem.samples) if part.log == log]
        masks = [problem.masks[k] > 0.0 for k in chosen]
        if sum(map(np.count_nonzero, masks)) > 1:
            age = np.concatenate([problem.samples[k].output_age[mask] for k, mask in zip(chosen, masks, strict=True)])
            lift = np.concatenate([series[k][mask, LIFT_COLUMN] for k, mask in zip(chosen, masks, strict=True)])
            rows[2 * log] = lift.mean(axis=0) / (MEAN_STD * problem.vehicle.gravity)
            rows[2 * log + 1] = _slope(age, lift) / (CHANGE_STD * problem.vehicle.gravity)
    return rows


def _slope(age: Array, lift: Array) -> Array:
    """Return the slopes (...) of straight lines through series (m, ...) over ages (m,)."""
    off = age - age.mean()
    return np.tensordot(off, lift, 1) / float(off @ off)
