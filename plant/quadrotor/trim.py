"""Steady flight: the attitude and rotor speeds at which wind, weight and rotors leave a vehicle at rest, whatever its gains.

Newton's method on the accelerations of the model itself, in roll, pitch and the four rotor speeds, for many vehicles and winds
at once. Flights that hold a place start here, and loops are linearised here.
"""

from collections.abc import Sequence
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.backends import array
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.rigid_body import Body, Dynamics, body_rate, dynamics
from plant.quadrotor.vehicle import Vehicle
from plant.records import flatten, pack
from plant.vectors import Quaternion, Rotors, Vec3

Array = NDArray[np.float64]

ITERATIONS = 40
# Accelerations [m/s2, rad/s2] below which Newton's method stops: a hundred roundings of the largest torque over the smallest
# inertia of the airframes.
BALANCED = 1e-11
# Steps of the central differences [rad] and as a share of the rotor speed; their error slows Newton's method, no more.
STEP = 1e-6
# Largest part of a step that is taken in an angle [rad]: drag that grows with tilt is no straight line.
LARGEST_TURN = 0.3
# Vehicles at most whose balance is kept for the next call: the lanes of a block of scenarios, 50 KB.
MAX_KEPT_ROWS = 64


class SteadyFlight(NamedTuple):
    """Trimmed flights in steady wind.

    Attributes:
        body: rows (n, 17) of `Body` at rest at the origin.
        tilt (n,) [rad].
        thrust (n,): thrust of all rotors over the weight [1].
        balanced (n,): whether the row is a balance; where there is none it is level hover.
    """

    body: Array
    tilt: Array
    thrust: Array
    balanced: NDArray[np.bool_]


@cache
def _body_rate() -> Any:
    return array.rebinder()(body_rate)


def steady_flight(rows: Array, wind: Array, yaw: float = 0.0) -> SteadyFlight:
    """Balance vehicles with dynamics rows (n, size of `Dynamics`) in winds (n, 3) [m/s], world ENU, at a yaw [rad].

    The arrays are read-only where there are few rows: studies and scenarios that are loaded again have the same ones.
    """
    if not 0 < len(rows) <= MAX_KEPT_ROWS:
        return _flight(rows, wind, yaw)
    given = (np.ascontiguousarray(part, dtype=float).tobytes() for part in (rows, wind))
    return _balanced(*given, len(rows), float(yaw))


@lru_cache(maxsize=64)
def _balanced(rows: bytes, wind: bytes, count: int, yaw: float) -> SteadyFlight:
    """Balance the vehicles of dynamics rows in winds: half of a study's loading, which a process repeats."""
    flight = _flight(np.frombuffer(rows).reshape(count, -1), np.frombuffer(wind).reshape(count, 3), yaw)
    for part in flight:
        part.flags.writeable = False
    return flight


def _flight(rows: Array, wind: Array, yaw: float) -> SteadyFlight:
    f = pack(Dynamics, rows.T)
    hover = np.sqrt(f.gravity / (4.0 * f.inverse_mass * f.thrust_coefficient))
    x = level = np.concatenate([np.zeros((len(rows), 2)), np.repeat(hover[:, None], 4, axis=1)], axis=1)
    off, going = _pushed(x, f, wind, yaw), np.ones(len(rows), dtype=bool)
    around, winds = pack(Dynamics, np.tile(rows, (12, 1)).T), np.tile(wind, (12, 1))
    with np.errstate(all="ignore"):
        for _ in range(ITERATIONS):
            # Each row stops by itself, so that it does not depend on the others.
            going &= ~(np.abs(off).max(axis=1) < BALANCED) & np.isfinite(off).all(axis=1)
            if not going.any():
                break
            x = np.where(going[:, None], x - _step(x, off, around, winds, yaw, hover), x)
            off = _pushed(x, f, wind, yaw)
        balanced = (np.abs(off).max(axis=1) < BALANCED) & (x[:, 2:] > 0.0).all(axis=1)
    x = np.where(balanced[:, None], x, level)
    thrust = f.thrust_coefficient * np.sum(x[:, 2:] ** 2, axis=1) * f.inverse_mass / f.gravity
    tilt = np.arccos(np.clip(np.cos(x[:, 0]) * np.cos(x[:, 1]), -1.0, 1.0))
    return SteadyFlight(_rows(_body(x, yaw), len(rows)), tilt, thrust, balanced)


def trim_of(vehicle: Vehicle, wind: Sequence[float], yaw: float = 0.0) -> SteadyFlight:
    """Balance one vehicle in one wind [m/s], world ENU: read-only rows of one."""
    return steady_flight(np.array([flatten(dynamics(vehicle))]), np.array([wind], dtype=float), yaw)


def within_limits(flight: SteadyFlight, nominal: Nominal) -> NDArray[np.bool_]:
    """Return the mask (n,) of rows that a controller can hold: balanced, in its tilt cone, rotor speeds inside their limits."""
    k_f = nominal.vehicle.thrust_coefficient
    speeds = flight.body[:, -4:]
    low, high = np.sqrt(nominal.thrust_min / k_f), np.sqrt(nominal.thrust_max / k_f)
    held = (low < speeds).all(axis=1) & (speeds < high).all(axis=1)
    return flight.balanced & held & (np.tan(flight.tilt) < nominal.tilt_tangent)


def _step(x: Array, off: Array, around: Dynamics, winds: Array, yaw: float, hover: Array) -> Array:
    """Newton's step (n, 6), shortened where it would turn too far; around, winds: dynamics and winds of all rows, 12 times."""
    sizes = np.concatenate([np.ones((len(x), 2)), np.repeat(hover[:, None], 4, axis=1)], axis=1)
    moved = STEP * sizes * np.eye(6)[:, None]
    # All at once: of a single vehicle each call takes as long as of a hundred.
    tried = np.concatenate([x + moved, x - moved]).reshape(-1, 6)
    ahead, back = _pushed(tried, around, winds, yaw).reshape(2, 6, len(x), 6)
    slope = np.ascontiguousarray(np.moveaxis((ahead - back) / (2.0 * STEP), 0, -1))
    step = _solved(slope, off)
    turn = np.abs(step[:, :2]).max(axis=1)
    return step * sizes * np.minimum(1.0, LARGEST_TURN / np.maximum(turn, 1e-300))[:, None]


def _solved(slope: Array, off: Array) -> Array:
    """Solutions (n, 6) of rows; those of a row that has none are not finite."""
    sound = np.flatnonzero(np.isfinite(slope).all(axis=(1, 2)))
    sound = sound[np.linalg.cond(slope[sound]) < 1e14]
    out = np.full_like(off, np.nan)
    out[sound] = np.linalg.solve(slope[sound], off[sound][..., None])[..., 0]
    return out


def _pushed(x: Array, f: Dynamics, wind: Array, yaw: float) -> Array:
    """Accelerations (n, 6) [m/s2, rad/s2] of vehicles at rest with roll, pitch [rad] and rotor speeds [rad/s] x (n, 6)."""
    body, still = _body(x, yaw), _still(len(x))
    rate = _body_rate()(body, body.rotor_speed, Disturbance(pack(Vec3, wind.T), still, still, still), f)
    return np.stack([np.broadcast_to(part, len(x)) for part in (*rate.velocity, *rate.rate)], axis=1)


def _body(x: Array, yaw: float) -> Any:
    still = _still(len(x))
    return Body(still, still, _quaternion(x[:, 0], x[:, 1], yaw), still, pack(Rotors, x[:, 2:].T))


def _still(count: int) -> Any:
    return pack(Vec3, [np.zeros(count)] * 3)


def _quaternion(roll: Array, pitch: Array, yaw: float) -> Any:
    """Attitude Rz(yaw) Ry(pitch) Rx(roll)."""
    (a, x), (b, y) = [(np.cos(0.5 * angle), np.sin(0.5 * angle)) for angle in (roll, pitch)]
    c, z = np.cos(0.5 * yaw), np.sin(0.5 * yaw)
    return Quaternion(a * b * c + x * y * z, x * b * c - a * y * z, a * y * c + x * b * z, a * b * z - x * y * c)


def _rows(body: Any, count: int) -> Array:
    return np.stack([np.broadcast_to(part, count) for part in flatten(body)], axis=1).astype(float)
