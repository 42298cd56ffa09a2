"""Steady flight of a study's vehicle in the mean wind of a scenario: what it takes, and a refusal where it cannot be held."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan, degrees, radians

import numpy as np

from objectives.system import System
from plant.errors import InputError
from plant.records import flatten
from plant.references.spec import HOLD
from plant.rigid_body import dynamics
from plant.scenarios import ScenarioSpec
from plant.trim import SteadyFlight, steady_flight, within_limits

# Directions [deg] that a wind without one of its own is tried in: drag differs between the body axes at most.
DIRECTIONS = (0.0, 45.0, 90.0)
# Shares of the wind among which the largest that can be held is looked for.
SHARES = np.linspace(0.0, 1.0, 201)


@dataclass(frozen=True)
class MeanWindTrim:
    """wind: mean wind [m/s]; tilt [rad] and thrust over the weight [1] that holding against it takes, in the direction that takes
    the most tilt, nan where nothing balances; tilt_limit [rad]; held: whether the controller's limits allow it.
    """

    wind: float
    tilt: float
    thrust: float
    tilt_limit: float
    held: bool


def mean_wind_trim(spec: ScenarioSpec, system: System) -> MeanWindTrim | None:
    """Return the steady flight of the nominal vehicle in the mean wind, None where none blows or flights do not hold a place."""
    if not (spec.air.mean_wind and spec.air.wind_speed > 0.0 and spec.track(system.timing).samples[0, HOLD] > 0.5):
        return None
    flight = _flown(spec, system, np.ones(1))
    limit = atan(system.nominal.tilt_tangent)
    if not flight.balanced.all():
        return MeanWindTrim(spec.air.wind_speed, float("nan"), float("nan"), limit, False)
    worst = int(np.argmax(flight.tilt))
    held = bool(within_limits(flight, system.nominal).all())
    return MeanWindTrim(spec.air.wind_speed, float(flight.tilt[worst]), float(flight.thrust[worst]), limit, held)


def check_trim(spec: ScenarioSpec, system: System) -> None:
    """Refuse a mean wind that the nominal vehicle cannot hold against; raises InputError with the largest that it can."""
    trim = mean_wind_trim(spec, system)
    if trim is None or trim.held:
        return
    held = within_limits(_flown(spec, system, SHARES), system.nominal).reshape(len(SHARES), -1).all(axis=1)
    most = float(SHARES[held].max(axis=0)) * trim.wind if held.any() else 0.0
    takes = (
        f"takes {degrees(trim.tilt):.1f} deg of tilt and {trim.thrust:.2f} times the weight in thrust"
        if trim.tilt == trim.tilt
        else "cannot be balanced at all"
    )
    raise InputError(
        f"given {spec.air.intensity!r}, a mean wind of {trim.wind:.1f} m/s at {spec.air.altitude:g} m, which {takes}; the tilt "
        f"limit is {degrees(trim.tilt_limit):.3g} deg and flights start trimmed. Allowed for this vehicle: a mean wind up to "
        f"{most:.1f} m/s; give a milder intensity, mean_wind = false (turbulence alone), or a larger controller.tilt_limit_deg",
        key="air.intensity",
    )


def trim_texts(specs: Sequence[ScenarioSpec], system: System) -> list[str]:
    """Return a sentence for each scenario whose flights start trimmed against a mean wind."""
    found = [(spec.name, mean_wind_trim(spec, system)) for spec in specs]
    return [
        f"Trim in {name}: mean wind {trim.wind:.3g} m/s, tilt {degrees(trim.tilt):.1f} of {degrees(trim.tilt_limit):.3g} deg, "
        f"thrust {trim.thrust:.2f} times the weight."
        for name, trim in found
        if trim is not None
    ]


def trim_entry(spec: ScenarioSpec, system: System) -> dict[str, float]:
    """Return what a summary holds of a trim: tilt [rad] and thrust over the weight; empty where no mean wind is held."""
    trim = mean_wind_trim(spec, system)
    return {} if trim is None else {"trim_tilt": trim.tilt, "trim_thrust": trim.thrust}


def _flown(spec: ScenarioSpec, system: System, shares: np.ndarray) -> SteadyFlight:
    """Return steady flight in shares of the mean wind, from every direction in turn: rows (shares x directions)."""
    given = spec.air.wind_direction_deg
    angles = [radians(angle) for angle in (DIRECTIONS if given is None else (given,))]
    ways = np.array([[np.cos(angle), np.sin(angle), 0.0] for angle in angles])
    winds = (spec.air.wind_speed * shares[:, None, None] * ways).reshape(-1, 3)
    return steady_flight(np.repeat([flatten(dynamics(system.vehicle))], len(winds), axis=0), winds)
