"""Identification of a vehicle from logs: regression, a fit with held-out windows, identifiability, and a fit to all data."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError
from plant.quadrotor.airframes import Airframe
from tuner.extensions.identification.checks import SILENT
from tuner.extensions.identification.flight_estimates import (
    earlier_estimate,
    estimate_of,
    flight_estimates,
    flight_name,
    pooled_fit,
)
from tuner.extensions.identification.judging import FitValidation, validate_fit
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.vehicle_fit.fit import Fit, Problem, fit_parameters
from tuner.extensions.vehicle_fit.flights import flights_of
from tuner.extensions.vehicle_fit.identifiability import (
    GIVEN,
    barely_weighed,
    counted_outputs,
    impossible,
    previously_identified,
    unidentifiable,
    wider_than_prior,
)
from tuner.extensions.vehicle_fit.parameters import ARM, MASS, THRUSTS, EarlierPosterior, ParameterSpace, space_of
from tuner.extensions.vehicle_fit.prediction import PredictionWindows, fit_masks, prediction_windows, settled_masks
from tuner.extensions.vehicle_fit.random_effects import (
    FlightEstimate,
    HomogeneityTest,
    adjusted,
    compare_estimates,
    compare_flights,
    predictive_variance,
)
from tuner.extensions.vehicle_fit.regression import RegressionBounds, forward_and_inverse_regression, initial_estimate
from tuner.extensions.vehicle_fit.samples import LogSegment, resample
from tuner.extensions.vehicle_fit.weight import LIFT_COLUMN, condition_on_weight

Array = NDArray[np.float64]
ProgressCallback = Callable[[int, int], None]


@dataclass(frozen=True, eq=False)
class Identified:
    """A vehicle identified from logs.

    Attributes:
        fit: Fit to all of the logs.
        early: Fit without the held-out windows.
        problem: Problem of the early fit.
        validation: Validation of the early fit on the held-out windows.
        regressions: Inertias about x, y, z.
        reasons: Name of a parameter -> why it stays at its prior.
        wider: Name of a parameter -> how much wider than its prior it came out; it stays in the fit, for others depend on it.
        flights: Estimates from each flight alone.
    """

    airframe: Airframe
    logs: tuple[FlightLog, ...]
    fit: Fit
    early: Fit
    problem: Problem
    validation: FitValidation
    regressions: tuple[RegressionBounds, ...]
    reasons: dict[str, str]
    wider: dict[str, str]
    flights: tuple[FlightEstimate, ...] = ()

    @cached_property
    def covariance(self) -> Array:
        """Covariance (n, n) of all coordinates with the scatter of the vehicle between flights."""
        scatter = predictive_variance(self.all_flights)
        return self.fit.covariance + np.diag([scatter.get(name, 0.0) for name in self.space.names])

    @property
    def all_flights(self) -> tuple[FlightEstimate, ...]:
        """Estimates from each flight alone, earlier ones first."""
        return (() if self.space.earlier is None else self.space.earlier.flights) + self.flights

    @cached_property
    def tests(self) -> list[HomogeneityTest]:
        """Test of each flight against earlier logs, or else the other flights."""
        if self.space.earlier is None:
            return compare_flights(self.flights)
        scatter = predictive_variance(self.space.earlier.flights)
        earlier = earlier_estimate(self.space)
        return adjusted([compare_estimates(flight, earlier, scatter) for flight in self.flights])

    @property
    def windows(self) -> PredictionWindows:
        """Predictions on windows that were kept from the fit."""
        return self.validation.windows

    @property
    def space(self) -> ParameterSpace:
        """The coordinates."""
        return self.fit.space


def identify_vehicle(
    logs: Sequence[FlightLog],
    airframe: Airframe,
    *,
    mass: float = MASS,
    arm: float = ARM,
    earlier: EarlierPosterior | None = None,
    on_progress: ProgressCallback | None = None,
) -> Identified:
    """Identify a vehicle; raises InputError where no log holds a flight, or all tell nothing.

    Args:
        logs: logs of flights of one vehicle.
        airframe: the prior.
        mass: relative standard deviation of its mass.
        arm: relative standard deviation of its lengths.
        earlier: posterior of earlier logs, which replaces the prior.
        on_progress: called with step and number of steps.
    """
    flights = [flight for log in logs for flight in flights_of(log, airframe)]
    samples = resample_segments(flights)
    if not samples:
        raise InputError(SILENT, file=flights[0].name)
    vehicle, wide = airframe.vehicle, space_of(airframe.vehicle, [str(i + 1) for i in range(len(flights))], mass, arm)
    space = wide if earlier is None else wide.with_prior(earlier)
    fitting, complete = (Problem(space, vehicle, samples, m) for m in (fit_masks(samples), settled_masks(samples)))
    free = np.array([name not in GIVEN for name in space.names])
    start = initial_estimate(space, samples, vehicle) if earlier is None else space.center
    early = fit_parameters(fitting, start, free, _share(on_progress, 0), scan=True)
    seen = prediction_windows(fitting, early.estimate, is_held_out=False)
    reasons = {**unidentifiable(early, seen), **impossible(early, airframe.vehicle)}
    fitting, complete = counted_outputs(fitting, reasons), counted_outputs(complete, reasons)
    if not any(fitting.outputs):
        raise InputError(SILENT, file=flights[0].name)
    weak: dict[str, str] = {}
    if not fitting.outputs[LIFT_COLUMN] and not set(THRUSTS) & previously_identified(space):
        space = condition_on_weight(complete, early.estimate)
        wide = space if earlier is None else condition_on_weight(replace(complete, space=wide), early.estimate)
        fitting, complete = replace(fitting, space=space), replace(complete, space=space)
        reasons, weak = {name: why for name, why in reasons.items() if name not in THRUSTS}, barely_weighed(space)
        free &= np.array([name not in THRUSTS for name in space.names])
    free &= np.array([name not in reasons for name in space.names])
    start = np.where(free | np.array([name in GIVEN for name in space.names]), early.estimate, space.center)
    early = fit_parameters(fitting, start, free, _share(on_progress, 1))
    fit = fit_parameters(complete, early.estimate, free, _share(on_progress, 2))
    if earlier is None and len(flights) == 1:
        alone: tuple[FlightEstimate, ...] = (estimate_of(fit, reasons, flight_name(flights[0])),)
    else:
        alone = flight_estimates(replace(complete, space=wide), fit, flights)
    if earlier is None and any(test.is_rejected for test in compare_flights(alone)):
        fit = pooled_fit(fit, alone)
    return Identified(
        airframe,
        tuple(flights),
        fit,
        early,
        fitting,
        validate_fit(early, fitting),
        forward_and_inverse_regression(space, fit.estimate, samples, vehicle),
        {name: why for name, why in reasons.items() if name in GIVEN or name not in previously_identified(space)},
        wider_than_prior(fit, free) | weak,
        alone,
    )


def resample_segments(flights: Sequence[FlightLog]) -> tuple[LogSegment, ...]:
    """Return the segments of flights on uniform grids."""
    return tuple(
        resample(stretch, i, float(log.time[0]), log.duration)
        for i, log in enumerate(flights)
        for stretch in log.stretches()
    )


def _share(on_progress: ProgressCallback | None, stage: int) -> ProgressCallback | None:
    return None if on_progress is None else lambda step, steps: on_progress(stage * steps + step, 3 * steps)
