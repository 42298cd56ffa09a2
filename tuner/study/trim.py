"""Steady states of a study's vehicle: hover, and the trims of its scenarios in their mean wind and at their reference's speed."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import atan, degrees, radians

import numpy as np

from objectives.margins.steady_state import HOVER, SteadyState
from objectives.system import System
from plant.errors import InputError
from plant.loop import Timing
from plant.quadrotor.rigid_body import dynamics
from plant.quadrotor.scenarios import ScenarioSpec
from plant.quadrotor.trim import SteadyFlight, steady_flight, within_limits
from plant.records import flatten
from plant.references.spec import HOLD, VELOCITY, YAW

# Directions [deg] that a wind without one of its own is tried in: drag differs between the body axes at most.
DIRECTIONS = (0.0, 45.0, 90.0)
# Of these, the one between the axes of the body, which a search leaves to its end: all six loops are coupled there, which takes
# three times as long, and its margins lay between those of the two others to 0.1 dB and 0.7 deg (200 candidates, quickstart).
DIAGONAL = 45.0
# Speed [m/s] from which on air or reference count as moving.
MOVES = 1e-3
# Share of the tilt limit from which on a trim leaves a gust little to act with.
NEAR_LIMIT = 0.9
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
    """Return the steady flight of the nominal vehicle in the mean wind.

    None where no wind blows or flights do not hold a place.
    """
    if not (spec.air.mean_wind and spec.air.wind_speed > 0.0 and spec.track(system.timing).samples[0, HOLD] > 0.5):
        return None
    flight = trimmed_flights(spec, system, np.ones(1))
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
    held = within_limits(trimmed_flights(spec, system, SHARES), system.nominal).reshape(len(SHARES), -1).all(axis=1)
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
    """Return a sentence on each scenario trimmed against a mean wind."""
    trims = [(spec.name, mean_wind_trim(spec, system)) for spec in specs]
    return [
        f"Trim in {name}: mean wind {trim.wind:.3g} m/s, tilt {degrees(trim.tilt):.1f} of {degrees(trim.tilt_limit):.3g} deg, "
        f"thrust {trim.thrust:.2f} times the weight.{_tilt_left(trim)}"
        for name, trim in trims
        if trim is not None
    ]


def _tilt_left(trim: MeanWindTrim) -> str:
    """Return a sentence where little tilt is left for gusts, else ""."""
    if trim.tilt < NEAR_LIMIT * trim.tilt_limit:
        return ""
    left = degrees(trim.tilt_limit - trim.tilt)
    return f" Only {left:.1f} deg of tilt are left for gusts; lower the wind or raise controller.tilt_limit_deg."


def steady_states(specs: Sequence[ScenarioSpec], system: System) -> tuple[SteadyState, ...]:
    """Return hover, then the trims of scenarios that hold a place: each mean wind in each direction, and against their speed.

    A trim beyond what the controller can hold is left out, as no flight stays in it.
    """
    (hover,) = hover_of(specs, system.timing)
    states = {HOVER: hover}
    for spec in specs if hover.hold else ():
        for state in _trims_of(spec, system):
            if state.name not in states and state.can_hold(system.vehicle, system.nominal):
                states[state.name] = state
    return tuple(states.values())


def hover_of(specs: Sequence[ScenarioSpec], timing: Timing) -> tuple[SteadyState]:
    """Return hover alone, holding position where any scenario does.

    It then has the position loops of x and y closed.
    """
    return (SteadyState(HOVER, hold=holds_place(specs, timing)),)


def holds_place(specs: Sequence[ScenarioSpec], timing: Timing) -> bool:
    """Return True if any scenario closes the x and y position loops.

    Attitude mode leaves them open.
    """
    return any(bool(np.any(spec.track(timing).samples[:, HOLD] > 0.5)) for spec in specs)


def _trims_of(spec: ScenarioSpec, system: System) -> Iterator[SteadyState]:
    samples = spec.track(system.timing).samples
    samples = samples[samples[:, HOLD] > 0.5]
    if not len(samples):
        return
    wind = spec.air.wind_speed if spec.air.mean_wind else 0.0
    given = spec.air.wind_direction_deg
    start, speeds = samples[0], np.linalg.norm(samples[:, VELOCITY], axis=1)
    if wind > MOVES:
        for degree, way in _directions(spec):
            name = f"{wind:.3g} m/s wind to {degree:g} deg"
            yield SteadyState(
                name, float(start[YAW]), wind=_vector(wind * way), is_diagonal=given is None and degree == DIAGONAL
            )
    fastest = samples[np.argmax(speeds)]
    speed = float(speeds.max())
    if speed > MOVES:
        velocity = fastest[VELOCITY]
        against = -velocity / speed if given is None else _way(given)
        name = f"{speed:.3g} m/s" + (f" against {wind:.3g} m/s wind" if wind > MOVES and given is None else "")
        name += f" in {wind:.3g} m/s wind to {given:g} deg" if wind > MOVES and given is not None else ""
        yield SteadyState(name, float(fastest[YAW]), _vector(velocity), _vector(wind * against * [1.0, 1.0, 0.0]))


def _directions(spec: ScenarioSpec) -> list[tuple[float, np.ndarray]]:
    """Return the directions [deg] of a mean wind, with world unit vectors (3,).

    They are those that the wind may blow to.
    """
    given = spec.air.wind_direction_deg
    return [(angle, _way(angle)) for angle in (DIRECTIONS if given is None else (given,))]


def _way(degree: float) -> np.ndarray:
    return np.array([np.cos(radians(degree)), np.sin(radians(degree)), 0.0])


def _vector(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def trim_entry(spec: ScenarioSpec, system: System) -> dict[str, float]:
    """Return the part of a summary about a trim: tilt [rad] and thrust over the weight; empty where no mean wind is held."""
    trim = mean_wind_trim(spec, system)
    return {} if trim is None else {"trim_tilt": trim.tilt, "trim_thrust": trim.thrust}


def trimmed_flights(spec: ScenarioSpec, system: System, shares: np.ndarray) -> SteadyFlight:
    """Return steady flight in shares of the mean wind, by direction.

    Rows (shares x directions): from every direction in turn.
    """
    ways = np.array([way for _, way in _directions(spec)])
    winds = (spec.air.wind_speed * shares[:, None, None] * ways).reshape(-1, 3)
    return steady_flight(np.repeat([flatten(dynamics(system.vehicle))], len(winds), axis=0), winds)
