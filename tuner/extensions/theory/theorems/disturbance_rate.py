"""Measured disturbance rate of each channel in a scenario's air: the L that theorems ask for.

The channels are y'' = d + b0 u. d is what wind, gust and injection add to the acceleration of the vehicle hovering level, by
the model that flies (`body_rate` of `plant.quadrotor.rigid_body` on arrays); the number is a quantile of |d(t + w) - d(t)|/w
over time and scenarios. It is not a bound: at a level of 0.99 the disturbance changes faster for one instant in a hundred, and
what a theorem promises for that rate it does not promise then. Nor is everything in it that an observer calls disturbance:
actuator lag and coupling of the axes come on top, for x and y the error of the tilt they ask for, for roll and pitch its motion.

A larger window gives a smaller rate. Dryden turbulence and injected noise have no derivative: their spectra fall as 1/f^2, so
the change over w grows as w^(1/2) and the rate as w^(-1/2). In roll, of a
Hummingbird in light turbulence at 10 m without mean wind, level 0.99:

    window [s]       0.004  0.008  0.016  0.032  0.064
    rate [rad/s3]    127    89.5   62.7   44.2   30.9

The default window is the control period: the air of a flight is held over it, and no sampled controller reacts within it. An
observer of bandwidth wo averages over 1/wo, so a window of that size is the less cautious choice.
"""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from plant.backends.array import rebinder
from plant.backends.flyer import FlightInputs
from plant.backends.lane_layout import LANES
from plant.loop import Timing
from plant.quadrotor.cascade import AXES
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.rigid_body import Body, Dynamics, body_rate
from plant.quadrotor.scenarios import SEARCH, ScenarioSpec, sample_scenarios
from plant.quadrotor.vehicle import Vehicle
from plant.records import pack, size
from plant.vectors import Quaternion, Rotors, Vec3
from tuner.extensions.theory.theorems.theorem import Array

LEVEL = 0.99
# Scenarios looked at, and samples of an axis kept at most: of flights of ten minutes and more, fewer are looked at.
SCENARIOS, SAMPLES = 64, 2_000_000


def disturbance_rates(
    spec: ScenarioSpec, vehicle: Vehicle, timing: Timing, root: int, level: float = LEVEL, window: float | None = None
) -> Array:
    """Return the rate of each channel (6,): x, y, z [m/s3], roll, pitch, yaw [rad/s3].

    The scenarios are the first of the search's own, vehicle spread included. window [s]: rounded to control periods, by
    default one; below the duration. level: of the quantile, in (0, 1).
    """
    control_period = timing.control_period
    periods = 1 if window is None else max(round(window / control_period), 1)
    steps = spec.steps(timing)
    assert periods < steps, "a window comes from a checked study"
    count = min(SCENARIOS, max(SAMPLES // steps, 1))
    changes = [np.abs(d[:, periods:] - d[:, :-periods]) for d in _accelerations(spec, vehicle, timing, root, count)]
    rates = np.concatenate(changes, axis=0) / (periods * control_period)
    return np.quantile(rates, level, axis=(0, 1), method="inverted_cdf")


def _accelerations(spec: ScenarioSpec, vehicle: Vehicle, timing: Timing, root: int, count: int) -> Iterator[Array]:
    """Yield the disturbance accelerations (scenarios, K, 6), a block of lanes at once."""
    for first in range(0, count, LANES):
        indices = range(first, min(first + LANES, count))
        inputs = sample_scenarios(spec, vehicle, timing, root, SEARCH, indices)
        yield hovering_disturbance(inputs, vehicle)


def hovering_disturbance(inputs: FlightInputs, vehicle: Vehicle) -> Array:
    """Return the disturbance accelerations (scenarios, K, 6) of a hovering vehicle.

    In these flights it would hover level, nose East.
    """
    air = _from_lanes(inputs.disturbances, inputs.count)
    parts = np.zeros((size(Disturbance), *air.shape[:2]))
    parts[: air.shape[2]] = np.moveaxis(air, 2, 0)
    model = pack(Dynamics, _from_lanes(inputs.dynamics, inputs.count).T[..., None])
    derivative = rebinder()(body_rate)
    body = _level_body(vehicle)
    blown = derivative(body, body.rotor_speed, pack(Disturbance, parts), model)
    still = derivative(body, body.rotor_speed, pack(Disturbance, np.zeros((len(parts), 1, 1))), model)
    pairs = zip((*blown.velocity, *blown.rate), (*still.velocity, *still.rate), strict=True)
    return np.stack([np.broadcast_to(one - other, air.shape[:2]) for one, other in pairs], axis=-1)


def worst_rates(
    specs: tuple[ScenarioSpec, ...],
    vehicle: Vehicle,
    timing: Timing,
    root: int,
    level: float = LEVEL,
    window: float | None = None,
) -> dict[str, float]:
    """Return the largest rate over scenarios of each channel by its axis."""
    rates = np.stack([_rates(spec, vehicle, timing, root, level, window) for spec in specs])
    return dict(zip(AXES, rates.max(axis=0).tolist(), strict=True))


@lru_cache(maxsize=16)
def _cached_rates(
    spec: ScenarioSpec, vehicle: Vehicle, timing: Timing, root: int, level: float, window: float | None
) -> Array:
    """Return rates of a process: each loading of a study needs the same ones, which take 0.1 s a scenario."""
    return disturbance_rates(spec, vehicle, timing, root, level, window)


def _rates(
    spec: ScenarioSpec, vehicle: Vehicle, timing: Timing, root: int, level: float, window: float | None
) -> Array:
    try:
        hash(spec)
    except TypeError:
        # A reference of a user's file may have no hash.
        return disturbance_rates(spec, vehicle, timing, root, level, window)
    return _cached_rates(spec, vehicle, timing, root, level, window)


def _from_lanes(blocks: Array, count: int) -> Array:
    """Turn (blocks, ..., lanes) into (scenarios, ...), as many as there are."""
    rows = np.moveaxis(blocks, -1, 1)
    return rows.reshape(-1, *rows.shape[2:])[:count]


def _level_body(vehicle: Vehicle) -> Body:
    still = Vec3(0.0, 0.0, 0.0)
    speed = float(np.sqrt(0.25 * vehicle.mass * vehicle.gravity / vehicle.thrust_coefficient))
    return Body(still, still, Quaternion(1.0, 0.0, 0.0, 0.0), still, Rotors(speed, speed, speed, speed))
