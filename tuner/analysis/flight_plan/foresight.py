"""Foresight of a flight: the intervals that identification would give of a vehicle, from the information of its own model.

The flight is simulated; sensitivities, noise model and the rules by which a number is left at its prior are those of
`tuner.analysis.identification`.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plant.airframes import Airframe
from tuner.analysis.identification.fit import Fit, Problem, foreseen
from tuner.analysis.identification.identify import (
    GIVEN,
    airborne,
    counted_outputs,
    gridded_stretches,
    unexcited,
    wider_than_prior,
)
from tuner.analysis.identification.parameters import Space
from tuner.analysis.identification.prediction import windowed
from tuner.analysis.identification.samples import OUTPUTS
from tuner.logs.flight_log import FlightLog

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Foresight:
    """The fit to be expected of a flight, and name of a number -> why it would not be identified."""

    fit: Fit
    reasons: dict[str, str]

    @property
    def deviations(self) -> Array:
        """Standard deviations (n,) of the coordinates after the flight."""
        return np.sqrt(np.diag(self.fit.covariance))


def problem_of(log: FlightLog, airframe: Airframe, space: Space) -> Problem:
    """Return what identification would make of a log."""
    samples = gridded_stretches([airborne(log, airframe)])
    return Problem(space, airframe.vehicle, samples, tuple(np.ones(len(part.time)) for part in samples))


def information_of(log: FlightLog, airframe: Airframe, space: Space, truth: Array, axis: str) -> Array:
    """Return the information (n, n) in a simulated flight of the vehicle at a point that excites one axis.

    Only this output counts: identification believes no output that hardly moves.
    """
    problem = replace(problem_of(log, airframe, space), outputs=tuple(name == axis for name in OUTPUTS))
    return foreseen(problem, truth, told_by_flights(space)).information


def told_by_flights(space: Space) -> NDArray[np.bool_]:
    """Return which coordinates a flight may move (n,)."""
    return np.array([name not in GIVEN for name in space.names])


def foresee(log: FlightLog, airframe: Airframe, space: Space, truth: Array) -> Foresight:
    """Return what identification is to tell of a simulated flight of the vehicle at a point."""
    problem, free = problem_of(log, airframe, space), told_by_flights(space)
    first = foreseen(problem, truth, free)
    reasons = unexcited(first, windowed(problem, truth, held_out=False))
    free &= np.array([name not in reasons for name in space.names])
    fit = foreseen(counted_outputs(problem, reasons), truth, free)
    return Foresight(fit, reasons | wider_than_prior(fit, free))
