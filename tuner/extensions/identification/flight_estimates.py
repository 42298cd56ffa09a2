"""Estimates from single flights, and the pooled fit of contradictory ones."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import PurePath

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.vehicle_fit.fit import Fit, Problem, fit_with_noise
from tuner.extensions.vehicle_fit.identifiability import GIVEN, previously_identified, unidentifiable
from tuner.extensions.vehicle_fit.parameters import ParameterSpace
from tuner.extensions.vehicle_fit.prediction import prediction_windows
from tuner.extensions.vehicle_fit.random_effects import FlightEstimate, between_flight_std, pooled_estimate

Array = NDArray[np.float64]


def flight_estimates(problem: Problem, fit: Fit, flights: Sequence[FlightLog]) -> tuple[FlightEstimate, ...]:
    """Return estimates from each flight alone, near the fit to all.

    Args:
        problem: Problem of all flights, with the prior before any of them.
        fit: Fit to all flights.
        flights: The flights.
    """
    estimates = []
    for i, flight in enumerate(flights):
        chosen = [k for k, part in enumerate(problem.samples) if part.log == i]
        if chosen:
            samples, masks = (tuple(parts[k] for k in chosen) for parts in (problem.samples, problem.masks))
            alone = replace(problem, samples=samples, masks=masks)
            single = fit_with_noise(alone, fit.estimate, fit.free, fit.noise)
            reasons = unidentifiable(single, prediction_windows(alone, single.estimate, is_held_out=False))
            estimates.append(estimate_of(single, reasons, flight_name(flight)))
    return tuple(estimates)


def flight_name(flight: FlightLog) -> str:
    """Return the name of a flight: its file and span [s]."""
    return f"{PurePath(flight.name).name}@{flight.time[0]:.0f}:{flight.time[-1]:.0f}"


def estimate_of(fit: Fit, reasons: Mapping[str, str], flight: str) -> FlightEstimate:
    """Return the identified parameters of a flight, given mass, arms and damping."""
    space = fit.space
    names = [
        name
        for name, is_free in zip(space.names[: space.physical], fit.free, strict=False)
        if is_free and name not in reasons
    ]
    return conditional_estimate(flight, names, space.names, fit.estimate, fit.covariance)


def earlier_estimate(space: ParameterSpace) -> FlightEstimate:
    """Return the parameters identified from earlier logs, given mass and arms."""
    identified = previously_identified(space)
    names = [name for name in space.names if name in identified]
    return conditional_estimate("earlier logs", names, space.names, space.center, space.covariance)


def conditional_estimate(
    flight: str, names: Sequence[str], coordinates: Sequence[str], point: Array, covariance: Array
) -> FlightEstimate:
    """Return the estimate of some coordinates, given those that no flight shows.

    Args:
        flight: Name of the flight.
        names: Names of the chosen coordinates.
        coordinates: Names (n,) of all coordinates.
        point: All coordinates (n,).
        covariance: Their covariance (n, n).
    """
    chosen, (spread, _) = [coordinates.index(name) for name in names], _split_by_given(coordinates, covariance)
    return FlightEstimate(flight, tuple(names), point[chosen], spread[np.ix_(chosen, chosen)])


def pooled_fit(fit: Fit, flights: Sequence[FlightEstimate]) -> Fit:
    """Return the fit with the means over flights whose parameters differ.

    A fit to all of them at once takes one flight's difference in a lag for another's in an inertia.
    """
    pooled = pooled_estimate(flights, between_flight_std(flights))
    chosen = [fit.space.names.index(name) for name in pooled.names]
    spread, lean = _split_by_given(fit.space.names, fit.covariance)
    spread[chosen], spread[:, chosen] = 0.0, 0.0
    spread[np.ix_(chosen, chosen)] = pooled.covariance
    point = fit.estimate.copy()
    point[chosen] = pooled.point
    return replace(fit, estimate=point, covariance=spread + lean)


def _split_by_given(names: Sequence[str], covariance: Array) -> tuple[Array, Array]:
    """Return a covariance (n, n) without, and from, errors of given parameters."""
    given = [names.index(name) for name in GIVEN]
    lean = covariance[:, given] @ np.linalg.solve(covariance[np.ix_(given, given)], covariance[given])
    return covariance - lean, lean
