"""From logs and an airframe to a vehicle: regression, a fit that keeps windows back, what is excited, and a fit to all of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from numpy.typing import NDArray

from plant.airframes import Airframe
from plant.airframes.rules import torque_ratios
from plant.errors import InputError
from plant.vehicle import Vehicle
from tuner.analysis.identification.fit import Fit, Problem, fitted
from tuner.analysis.identification.judging import Judged, judged
from tuner.analysis.identification.parameters import ARM, MASS, Known, Space, space_of
from tuner.analysis.identification.prediction import Windows, fit_masks, windowed
from tuner.analysis.identification.regression import TwoWays, both_ways, start_of
from tuner.analysis.identification.samples import OUTPUTS, Samples, gridded
from tuner.logs.flight_log import FlightLog
from tuner.text.sentences import counted, listing

Array = NDArray[np.float64]
Told = Callable[[int, int], None]

WEIGHED = ("mass", "arm")
"""Numbers that people weigh and measure themselves."""
GIVEN = {
    **dict.fromkeys(WEIGHED, "given: no log tells it"),
    "rate_damping": "given, of the rotors' inflow: a log tells it badly from lags",
}
"""What is not asked of a log, with the reason; errors of these go into the intervals of all others."""
EXPLAINED = 0.7
"""Share of an output's variance that the model must explain before its numbers are believed. Where air alone moves a
vehicle, what the controller answers explains up to 0.65 of made flights; shaken axes of the same flights have 0.8 and more.
"""
NARROWED = 0.5
"""A number counts as excited where its standard deviation falls below this share of the prior's."""
OF_OUTPUT = {
    "roll": ("inertia.x", "centre.y"),
    "pitch": ("inertia.y", "centre.x"),
    "yaw": ("inertia_share", "torque_ratio", "rotor_inertia"),
    "lift": ("drag_linear.z", "thrust.30", "thrust.65", "thrust.100"),
}
"""Numbers that only one output tells of."""
AIRBORNE, SMOOTHED, SETTLED, LEAST_FLIGHT = 0.5, 2.0, 2.0, 4.0
"""Commands above this share of hover, on average over so many seconds, count as flight, less so many at both ends; shortest
flight [s].
"""


@dataclass(frozen=True, eq=False)
class Identified:
    """A vehicle out of logs.

    fit: to all of the logs. early: to what was not kept back; judging: of early on what was. problem: behind early.
    regressions: inertias about x, y, z, both ways. reasons: name of a number -> why it stays at its prior.
    wider: name of a number -> how much wider than its prior it came out; it stays in the fit, for others hang on it.
    """

    airframe: Airframe
    logs: tuple[FlightLog, ...]
    fit: Fit
    early: Fit
    problem: Problem
    judging: Judged
    regressions: tuple[TwoWays, ...]
    reasons: dict[str, str]
    wider: dict[str, str]

    @property
    def windows(self) -> Windows:
        """Predictions on windows that were kept from the fit."""
        return self.judging.windows

    @property
    def space(self) -> Space:
        """The coordinates."""
        return self.fit.space


def identify_vehicle(
    logs: Sequence[FlightLog],
    airframe: Airframe,
    *,
    mass: float = MASS,
    arm: float = ARM,
    known: Known | None = None,
    told: Told | None = None,
) -> Identified:
    """Identify a vehicle.

    logs: of flights of one vehicle. airframe: the prior. mass, arm: relative standard deviations of its mass and its lengths.
    known: what earlier logs tell, which takes the place of the prior.
    told(step, steps) hears of progress. Raises InputError where no log holds a flight.
    """
    flights = [airborne(log, airframe) for log in logs]
    samples = gridded_stretches(flights)
    vehicle, space = airframe.vehicle, space_of(airframe.vehicle, [str(i + 1) for i in range(len(logs))], mass, arm)
    space = space if known is None else space.after(known)
    masks = fit_masks(samples)
    part, whole = (Problem(space, vehicle, samples, m) for m in (masks, tuple(np.ones(len(s.time)) for s in samples)))
    free = np.array([name not in GIVEN for name in space.names])
    start = start_of(space, samples, vehicle) if known is None else space.centre
    early = fitted(part, start, free, _share(told, 0))
    seen = windowed(part, early.point, held_out=False)
    reasons = {**unexcited(early, seen), **impossible(early, airframe.vehicle)}
    part, whole = counted_outputs(part, reasons), counted_outputs(whole, reasons)
    free &= np.array([name not in reasons for name in space.names])
    start = np.where(free | np.array([name in GIVEN for name in space.names]), early.point, space.centre)
    early = fitted(part, start, free, _share(told, 1))
    fit = fitted(whole, early.point, free, _share(told, 2))
    return Identified(
        airframe,
        tuple(flights),
        fit,
        early,
        part,
        judged(early, part),
        both_ways(space, fit.point, samples, vehicle),
        {name: why for name, why in reasons.items() if name in GIVEN or name not in told_before(space)},
        wider_than_prior(fit, free),
    )


def gridded_stretches(flights: Sequence[FlightLog]) -> tuple[Samples, ...]:
    """Return the stretches of flights on their grids."""
    return tuple(
        gridded(part, i, float(log.time[0]), log.duration) for i, log in enumerate(flights) for part in log.stretches()
    )


def counted_outputs(problem: Problem, reasons: Mapping[str, str]) -> Problem:
    """Return the problem without outputs whose numbers all stay at the prior: these would only push the others."""
    return replace(problem, outputs=tuple(not set(OF_OUTPUT[name]) <= set(reasons) for name in OUTPUTS))


def told_before(space: Space) -> set[str]:
    """Return the numbers that earlier logs told."""
    narrow = space.deviations <= NARROWED * space.wide
    return {name for name, is_narrow in zip(space.names, narrow.tolist(), strict=True) if is_narrow}


def unexcited(fit: Fit, seen: Windows) -> dict[str, str]:
    """Return the numbers that the data do not tell, each with the reason.

    Outputs that the model does not explain go first; then, one by one, numbers hardly narrower than their prior, each judged with
    those before it held. A ratio that the data tell, as of yaw torque to inertia, is left to the better known of the two.
    """
    space = fit.space
    reasons = dict(GIVEN)
    for output, share in zip(OUTPUTS, seen.explained.tolist(), strict=True):
        if share < EXPLAINED:
            said = f"{output} hardly moves as commanded: {100.0 * max(share, 0.0):.0f} % of it explained"
            reasons |= dict.fromkeys(OF_OUTPUT[output], said)
    while True:
        free = np.array(
            [name not in reasons for name in space.names[: space.physical]]
            + [True] * (len(space.names) - space.physical)
        )
        inverse = np.linalg.inv((fit.information + space.precision)[np.ix_(free, free)])
        ratio = np.sqrt(np.diag(inverse)) / space.wide[free]
        names = [name for name, is_free in zip(space.names, free, strict=True) if is_free]
        count = int(np.count_nonzero(free[: space.physical]))
        if count == 0:
            return reasons
        worst = int(np.argmax(ratio[:count]))
        if ratio[worst] <= NARROWED:
            return reasons
        reasons[names[worst]] = f"its interval shrinks to {100.0 * ratio[worst]:.0f} % of the prior's only"


def wider_than_prior(fit: Fit, free: NDArray[np.bool_]) -> dict[str, str]:
    """Return the fitted numbers whose interval is wider than their prior's, with the reason: they are not identified."""
    space = fit.space
    ratio = np.sqrt(np.diag(fit.covariance)) / space.wide
    return {
        name: f"its interval is {100.0 * ratio[k]:.0f} % of the prior's: no better known than before"
        for k, name in enumerate(space.names[: space.physical])
        if free[k] and ratio[k] > 1.0
    }


def impossible(fit: Fit, vehicle: Vehicle) -> dict[str, str]:
    """Return the numbers of yaw with the reason where no vehicle can have them: something else than the rotors turns this one."""
    numbers = fit.space.numbers(fit.point)
    x, y, z = numbers.inertia
    low, high = torque_ratios(vehicle)
    if z <= x + y and low <= numbers.torque_ratio <= high:
        return {}
    said = f"yaw would take {z / (x + y):.2f} of x + y, at most 1, and {numbers.torque_ratio:.2g} m, {low:.2g} to {high:.2g}"
    return dict.fromkeys(OF_OUTPUT["yaw"], said)


def airborne(log: FlightLog, airframe: Airframe) -> FlightLog:
    """Return the longest flight of a log, in which all rotors carry; says which one where there are others.

    Raises InputError where there is none, or none that is long enough.
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
    begin, end = max(parts, key=lambda entry: log.time[entry[1]] - log.time[entry[0]], default=(0, 0))
    # What was cut out of a flight begins and ends in the air.
    first = log.time[begin] + (SETTLED if begin > width else 0.0)
    last = log.time[end] - (SETTLED if end < len(log.time) - 1 - width else 0.0)
    lengths = [float(log.time[b] - log.time[a]) for a, b in parts]
    if last - first < LEAST_FLIGHT:
        raise InputError(_no_flight(lengths), file=log.name)
    flight = log.between(first, last)
    if len(parts) == 1:
        return flight
    texts = listing([f"{length:.1f}" for length in lengths])
    note = (
        f"holds {len(parts)} flights, of {texts} s; the longest is used, from {first:.1f} to {last:.1f} s, for a log counts "
        f"as one flight: give others as {log.name}@BEGIN:END"
    )
    return replace(flight, said=(*flight.said, note))


def _no_flight(lengths: Sequence[float]) -> str:
    """Return the reason why flights of these lengths [s] are of no use."""
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


def _share(told: Told | None, stage: int) -> Told | None:
    return None if told is None else lambda step, steps: told(stage * steps + step, 3 * steps)
