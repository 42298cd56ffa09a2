"""Flights of a log: parts in which the rotors carry the vehicle."""

from collections.abc import Sequence
from dataclasses import replace
from math import ceil

import numpy as np

from plant.errors import InputError
from plant.quadrotor.airframes import Airframe
from tuner.extensions.logs.flight_log import FlightLog
from tuner.text.sentences import counted, listing

AIRBORNE, SMOOTHED, SETTLED, MIN_FLIGHT_TIME = 0.5, 2.0, 2.0, 4.0
"""Commands above this share of hover, on average over so many seconds, count as flight, less so many at both ends; shortest
flight [s].
"""


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
    enough = [last - first >= MIN_FLIGHT_TIME for first, last in settled]
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
            f"holds no flight of {MIN_FLIGHT_TIME:g} s: commands stay below {100.0 * AIRBORNE:.0f} % of the airframe's hover; "
            "fly longer, or check the airframe and the scale of the commands"
        )
    return (
        f"holds no flight that is long enough: {counted(len(lengths), 'flight')}, of "
        f"{listing([f'{length:.1f}' for length in lengths])} s, of which {SETTLED:g} s at take-off and at landing are left out, "
        f"and {MIN_FLIGHT_TIME:g} s must be left; fly {MIN_FLIGHT_TIME + 2.0 * SETTLED + SMOOTHED:g} s or longer"
    )
