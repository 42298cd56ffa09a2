"""Foresight of a flight: the intervals that identification would give of a vehicle, from the information of its own model.

The flight is simulated; sensitivities, noise model and the rules by which a number is left at its prior are those of
`tuner.extensions.identification`.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.airframes import Airframe
from tuner.extensions.flight_plans.excitation import LEAD, Excitation
from tuner.extensions.identification.identify import resample_segments
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.vehicle_fit.fit import Fit, Problem, expected_fit
from tuner.extensions.vehicle_fit.flights import longest_flight
from tuner.extensions.vehicle_fit.identifiability import (
    GIVEN,
    NARROWED,
    counted_outputs,
    impossible,
    unidentifiable,
    wider_than_prior,
)
from tuner.extensions.vehicle_fit.parameters import ParameterSpace
from tuner.extensions.vehicle_fit.prediction import prediction_windows
from tuner.extensions.vehicle_fit.samples import OUTPUTS

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ExpectedAccuracy:
    """Expected fit to a flight; reasons: name of a parameter -> why it would not be identified."""

    fit: Fit
    reasons: dict[str, str]

    @property
    def deviations(self) -> Array:
        """Standard deviations (n,) of the coordinates after the flight."""
        return np.sqrt(np.diag(self.fit.covariance))


class OutputPower(NamedTuple):
    """Mean squares of an output and its residual: excited, and in hover."""

    excited: float = 1.0
    residual: float = 0.0
    still: float = 0.0
    still_residual: float = 0.0

    def explained(self, length: float, rest: float) -> float:
        """Return the explained share of the variance; excitation and rest [s]."""
        residual = length * self.residual + rest * self.still_residual
        return 1.0 - residual / max(length * self.excited + rest * self.still, 1e-300)


def output_power(problem: Problem, truth: Array, excitation: Excitation) -> OutputPower:
    """Return the power of an output in a flight of its excitation."""
    windows, k = prediction_windows(problem, truth, is_held_out=False), OUTPUTS.index(excitation.axis)
    middle, measured = windows.time.mean(axis=1), windows.measured[..., k]
    residual = measured - windows.modeled[..., k]
    inside = (middle >= LEAD) & (middle <= LEAD + excitation.duration)
    powers = [float(np.mean(series[part] ** 2)) for part in (inside, ~inside) for series in (measured, residual)]
    return OutputPower(*powers)


def problem_of(log: FlightLog, airframe: Airframe, space: ParameterSpace) -> Problem:
    """Return the identification problem of a log."""
    samples = resample_segments([longest_flight(log, airframe)])
    return Problem(space, airframe.vehicle, samples, tuple(np.ones(len(part.time)) for part in samples))


def information_of(problem: Problem, truth: Array, axis: str) -> Array:
    """Return the Fisher information (n, n) of a simulated flight that excites one axis.

    Only this output counts: identification believes no output that hardly moves.
    """
    problem = replace(problem, outputs=tuple(name == axis for name in OUTPUTS))
    return expected_fit(problem, truth, identifiable_parameters(problem.space)).information


def identifiable_parameters(space: ParameterSpace) -> NDArray[np.bool_]:
    """Return a mask (n,) of the coordinates that a flight may identify."""
    return np.array([name not in GIVEN for name in space.names])


def expected_accuracy(log: FlightLog, airframe: Airframe, space: ParameterSpace, truth: Array) -> ExpectedAccuracy:
    """Return the expected accuracy of identification from a simulated flight."""
    problem, is_free = problem_of(log, airframe, space), identifiable_parameters(space)
    first = expected_fit(problem, truth, is_free)
    windows = prediction_windows(problem, truth, is_held_out=False)
    reasons = unidentifiable(first, windows) | impossible(first, airframe.vehicle)
    is_free &= np.array([name not in reasons for name in space.names])
    fit = expected_fit(counted_outputs(problem, reasons), truth, is_free)
    return ExpectedAccuracy(fit, reasons | _untold(fit, is_free))


def _untold(fit: Fit, is_free: NDArray[np.bool_]) -> dict[str, str]:
    """Return the fitted parameters with wide intervals, and the reason."""
    space = fit.space
    ratio = np.sqrt(np.diag(fit.covariance)) / space.initial_std
    wide = {
        name: f"its interval shrinks to {100.0 * ratio[k]:.0f} % of the prior's only"
        for k, name in enumerate(space.names[: space.physical])
        if is_free[k] and ratio[k] > NARROWED
    }
    return wide | wider_than_prior(fit, is_free)
