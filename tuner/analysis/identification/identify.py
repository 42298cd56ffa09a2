"""Identification of a vehicle from logs: regression, a fit with held-out windows, identifiability, and a fit to all data."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from numpy.typing import NDArray

from plant.errors import InputError
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.airframes.rules import torque_ratios
from plant.quadrotor.vehicle import Vehicle
from tuner.analysis.identification.checks import SILENT
from tuner.analysis.identification.fit import Fit, Problem, fit_parameters
from tuner.analysis.identification.judging import FitValidation, validate_fit
from tuner.analysis.identification.parameters import ARM, MASS, EarlierPosterior, ParameterSpace, space_of
from tuner.analysis.identification.prediction import PredictionWindows, fit_masks, prediction_windows, settled_masks
from tuner.analysis.identification.regression import RegressionBounds, forward_and_inverse_regression, initial_estimate
from tuner.analysis.identification.samples import OUTPUTS, LogSegment, resample
from tuner.logs.flight_log import FlightLog
from tuner.text.sentences import counted, listing

Array = NDArray[np.float64]
ProgressCallback = Callable[[int, int], None]

WEIGHED = ("mass", "arm")
"""Numbers that people weigh and measure themselves."""
GIVEN = {
    **dict.fromkeys(WEIGHED, "given: no log tells it"),
    "rate_damping": "given, of the rotors' inflow: a log tells it badly from lags",
}
"""Parameters that are never fitted, with the reason; their errors go into the intervals of all others."""
EXPLAINED = 0.7
"""Share of an output's variance that the model must explain before its parameters count. Where air alone moves a vehicle, the
controller's answer explains up to 0.65 of simulated flights; excited axes of the same flights have 0.8 and more.
"""
NARROWED = 0.5
"""A number counts as excited where its standard deviation falls below this share of the prior's."""
OF_OUTPUT = {
    "roll": ("inertia.x", "centre.y"),
    "pitch": ("inertia.y", "centre.x"),
    "yaw": ("inertia_share", "torque_ratio", "rotor_inertia"),
    "lift": ("drag_linear.z", "thrust.30", "thrust.65", "thrust.100"),
}
"""Parameters that are identifiable from one output only."""
AIRBORNE, SMOOTHED, SETTLED, LEAST_FLIGHT = 0.5, 2.0, 2.0, 4.0
"""Commands above this share of hover, on average over so many seconds, count as flight, less so many at both ends; shortest
flight [s].
"""


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
        logs: of flights of one vehicle.
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
    vehicle, space = airframe.vehicle, space_of(airframe.vehicle, [str(i + 1) for i in range(len(flights))], mass, arm)
    space = space if earlier is None else space.with_prior(earlier)
    fitting, complete = (Problem(space, vehicle, samples, m) for m in (fit_masks(samples), settled_masks(samples)))
    free = np.array([name not in GIVEN for name in space.names])
    start = initial_estimate(space, samples, vehicle) if earlier is None else space.center
    early = fit_parameters(fitting, start, free, _share(on_progress, 0), scan=True)
    seen = prediction_windows(fitting, early.estimate, is_held_out=False)
    reasons = {**unidentifiable(early, seen), **impossible(early, airframe.vehicle)}
    fitting, complete = counted_outputs(fitting, reasons), counted_outputs(complete, reasons)
    if not any(fitting.outputs):
        raise InputError(SILENT, file=flights[0].name)
    free &= np.array([name not in reasons for name in space.names])
    start = np.where(free | np.array([name in GIVEN for name in space.names]), early.estimate, space.center)
    early = fit_parameters(fitting, start, free, _share(on_progress, 1))
    fit = fit_parameters(complete, early.estimate, free, _share(on_progress, 2))
    return Identified(
        airframe,
        tuple(flights),
        fit,
        early,
        fitting,
        validate_fit(early, fitting),
        forward_and_inverse_regression(space, fit.estimate, samples, vehicle),
        {name: why for name, why in reasons.items() if name in GIVEN or name not in previously_identified(space)},
        wider_than_prior(fit, free),
    )


def resample_segments(flights: Sequence[FlightLog]) -> tuple[LogSegment, ...]:
    """Return the segments of flights on uniform grids."""
    return tuple(
        resample(stretch, i, float(log.time[0]), log.duration)
        for i, log in enumerate(flights)
        for stretch in log.stretches()
    )


def counted_outputs(problem: Problem, reasons: Mapping[str, str]) -> Problem:
    """Return the problem without outputs whose parameters all stay at the prior: these would only bias the others."""
    return replace(problem, outputs=tuple(not set(OF_OUTPUT[name]) <= set(reasons) for name in OUTPUTS))


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


def flights_of(log: FlightLog, airframe: Airframe) -> list[FlightLog]:
    """Return the flights of a log that are long enough; InputError without one.

    A note of the first names the lengths of the others.
    """
    vehicle = airframe.vehicle
    hover = np.sqrt(vehicle.mass * vehicle.gravity / (4.0 * vehicle.thrust_coefficient)) / vehicle.speed_max
    width = max(ceil(SMOOTHED * log.rate), 1)
    weights = np.ones(min(width, len(log.time)))
    mean = np.convolve(log.command.mean(axis=1), weights, mode="same") / np.convolve(
        np.ones(len(log.time)), weights, mode="same"
    )
    up = np.concatenate([[False], mean > AIRBORNE * hover, [False]])
    edges = np.flatnonzero(np.diff(up.astype(int)))
    parts = [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    lengths = [float(log.time[b] - log.time[a]) for a, b in parts]
    settled = [_settled(log, begin, end, width) for begin, end in parts]
    enough = [last - first >= LEAST_FLIGHT for first, last in settled]
    if not any(enough):
        raise InputError(_no_flight(lengths), file=log.name)
    flights = [log.between(*span) for span, is_enough in zip(settled, enough, strict=True) if is_enough]
    # What was noted of a log is noted once.
    flights[1:] = [replace(flight, notes=()) for flight in flights[1:]]
    short = [f"{length:.1f}" for length, is_enough in zip(lengths, enough, strict=True) if not is_enough]
    if not short:
        return flights
    note = f"holds {counted(len(parts), 'flight')}; too short to use are those of {listing(short)} s"
    return [replace(flights[0], notes=(*flights[0].notes, note)), *flights[1:]]


def _settled(log: FlightLog, begin: int, end: int, width: int) -> tuple[float, float]:
    """Return begin and end [s] of a flight, without take-off and landing."""
    # What was cut out of a flight begins and ends in the air.
    first = log.time[begin] + (SETTLED if begin > width else 0.0)
    last = log.time[end] - (SETTLED if end < len(log.time) - 1 - width else 0.0)
    return float(first), float(last)


def longest_flight(log: FlightLog, airframe: Airframe) -> FlightLog:
    """Return the longest flight of a log; InputError where there is none.

    A note says so where there are others.
    """
    flights = flights_of(log, airframe)
    flight = max(flights, key=lambda entry: entry.duration)
    if len(flights) == 1:
        return flight
    note = (
        f"holds {len(flights)} flights; the longest is used, from {flight.time[0]:.1f} to {flight.time[-1]:.1f} s: "
        f"give others as {log.name}@BEGIN:END"
    )
    return replace(flight, notes=(*flight.notes, note))


def _no_flight(lengths: Sequence[float]) -> str:
    """Return the reason why flights of these lengths [s] are too short."""
    if not lengths:
        return (
            f"holds no flight of {LEAST_FLIGHT:g} s: commands stay below {100.0 * AIRBORNE:.0f} % of the airframe's hover; "
            "fly longer, or check the airframe and the scale of the commands"
        )
    return (
        f"holds no flight that is long enough: {counted(len(lengths), 'flight')}, of "
        f"{listing([f'{length:.1f}' for length in lengths])} s, of which {SETTLED:g} s at take-off and at landing are left out, "
        f"and {LEAST_FLIGHT:g} s must be left; fly {LEAST_FLIGHT + 2.0 * SETTLED + SMOOTHED:g} s or longer"
    )


def _share(on_progress: ProgressCallback | None, stage: int) -> ProgressCallback | None:
    return None if on_progress is None else lambda step, steps: on_progress(stage * steps + step, 3 * steps)
