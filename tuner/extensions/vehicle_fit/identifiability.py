"""Identifiability: which parameters flights determine, and the reasons why others stay at their prior."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.airframes.rules import torque_ratios
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.vehicle_fit.fit import Fit, Problem
from tuner.extensions.vehicle_fit.parameters import THRUSTS, ParameterSpace
from tuner.extensions.vehicle_fit.prediction import PredictionWindows
from tuner.extensions.vehicle_fit.samples import OUTPUTS

WEIGHED = ("mass", "arm")
"""Numbers that people weigh and measure themselves."""
GIVEN = {
    **dict.fromkeys(WEIGHED, "given: no log identifies it"),
    "rate_damping": "given, of the rotors' inflow: a log hardly distinguishes it from lags",
}
"""Parameters that are never fitted, with the reason; their errors go into the intervals of all others."""
EXPLAINED = 0.7
"""Share of an output's variance that the model must explain before its parameters count. If air alone moves a vehicle, the
controller's answer explains up to 0.65 of simulated flights; excited axes of the same flights have 0.8 and more.
"""
NARROWED = 0.5
"""A number counts as excited where its standard deviation falls below this share of the prior's."""
OF_OUTPUT = {
    "roll": ("inertia.x", "centre.y"),
    "pitch": ("inertia.y", "centre.x"),
    "yaw": ("inertia_share", "torque_ratio", "rotor_inertia"),
    "lift": ("drag_linear.z", *THRUSTS),
}
"""Parameters that are identifiable from one output only."""


def counted_outputs(problem: Problem, reasons: Mapping[str, str]) -> Problem:
    """Return the problem without outputs whose parameters all stay at the prior: these would only bias the others."""
    return replace(problem, outputs=tuple(not set(OF_OUTPUT[name]) <= set(reasons) for name in OUTPUTS))


def barely_weighed(space: ParameterSpace) -> dict[str, str]:
    """Return thrusts that the weight hardly narrows, with the reason."""
    ratio = space.prior_std / space.initial_std
    return {
        name: f"from the weight at the mean command alone: its interval shrinks to {100.0 * share:.0f} % of the prior's only"
        for name, share in zip(space.names, ratio.tolist(), strict=True)
        if name in THRUSTS and share > NARROWED
    }


def previously_identified(space: ParameterSpace) -> set[str]:
    """Return the parameters identified from earlier logs."""
    narrow = space.prior_std <= NARROWED * space.initial_std
    return {name for name, is_narrow in zip(space.names, narrow.tolist(), strict=True) if is_narrow}


def unidentifiable(fit: Fit, seen: PredictionWindows) -> dict[str, str]:
    """Return the parameters that are not identifiable, each with the reason.

    Outputs that the model does not explain go first; then, one by one, parameters hardly narrower than their prior, each with
    those before it fixed. An identifiable ratio, as of yaw torque to inertia, is attributed to the better known of the two.
    """
    space = fit.space
    reasons = dict(GIVEN)
    for output, share in zip(OUTPUTS, seen.explained.tolist(), strict=True):
        if share < EXPLAINED:
            reason = f"{output} hardly moves as commanded: {100.0 * max(share, 0.0):.0f} % of it explained"
            reasons |= dict.fromkeys(OF_OUTPUT[output], reason)
    while True:
        free = np.array(
            [name not in reasons for name in space.names[: space.physical]]
            + [True] * (len(space.names) - space.physical)
        )
        inverse = np.linalg.inv((fit.information + space.precision)[np.ix_(free, free)])
        ratio = np.sqrt(np.diag(inverse)) / space.initial_std[free]
        names = [name for name, is_free in zip(space.names, free, strict=True) if is_free]
        count = int(np.count_nonzero(free[: space.physical]))
        if count == 0:
            return reasons
        worst = int(np.argmax(ratio[:count]))
        if ratio[worst] <= NARROWED:
            return reasons
        reasons[names[worst]] = f"its interval shrinks to {100.0 * ratio[worst]:.0f} % of the prior's only"


def wider_than_prior(fit: Fit, free: NDArray[np.bool_]) -> dict[str, str]:
    """Return the fitted parameters with intervals wider than their prior's: they are not identified; with the reason."""
    space = fit.space
    ratio = np.sqrt(np.diag(fit.covariance)) / space.initial_std
    return {
        name: f"its interval is {100.0 * ratio[k]:.0f} % of the prior's: no better known than before"
        for k, name in enumerate(space.names[: space.physical])
        if free[k] and ratio[k] > 1.0
    }


def impossible(fit: Fit, vehicle: Vehicle) -> dict[str, str]:
    """Return physically impossible parameters of yaw, with the reason: something else than the rotors turns the vehicle."""
    numbers = fit.space.numbers(fit.estimate)
    x, y, z = numbers.inertia
    low, high = torque_ratios(vehicle)
    if z <= x + y and low <= numbers.torque_ratio <= high:
        return {}
    reason = f"yaw would take {z / (x + y):.2f} of x + y, at most 1, and {numbers.torque_ratio:.2g} m, {low:.2g} to {high:.2g}"
    return dict.fromkeys(OF_OUTPUT["yaw"], reason)
