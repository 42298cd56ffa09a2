"""What the tests of the plant share: airframes, random records, closed loops and batches of flights as plain arrays."""

from functools import cache
from math import cos, radians
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives import meters
from objectives.margins.period import NO_METERS
from plant.backends.flyer import FlightInputs, to_lanes
from plant.backends.stepping import Inputs
from plant.law_registry import LAWS
from plant.loop import MeterModel, Timing
from plant.quadrotor.airframes import load, names
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import CascadeLoop, Limits, close_loop
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.gains import default_row
from plant.quadrotor.rigid_body import dynamics
from plant.quadrotor.sample import Targets
from plant.quadrotor.trim import steady_flight
from plant.quadrotor.vehicle import Vehicle
from plant.records import flatten, pack, size
from plant.sample import Target
from plant.vectors import Quaternion, Vec3

Array = NDArray[np.float64]

VEHICLES: dict[str, Vehicle] = {name: load(name, allow_unphysical=True).vehicle for name in names()}
HUMMINGBIRD = VEHICLES["hummingbird"]
H = 0.004
TIMING = Timing(H, 0.001)
LIMITS = Limits(5.0, cos(radians(80.0)))
ZERO = Vec3(0.0, 0.0, 0.0)
CALM = Disturbance(ZERO, ZERO, ZERO, ZERO)
# Every law once as position law and once as attitude law.
PAIRS = list(zip(LAWS, [*LAWS][1:] + [*LAWS][:1], strict=True))
TARGETS = Targets(*[Target(0.0, step, 0.1, 0.05, 0.3, 0.1, 0.4) for step in (1.0, 1.0, 1.0, 0.0, 0.0, 0.5)])


@cache
def loop_of(position: str, attitude: str) -> CascadeLoop:
    """Return the closed loop of two laws, judged by the meters that every study uses."""
    model = MeterModel(meters.Meters, meters.start, meters.update)
    return close_loop(close_cascade(LAWS[position], LAWS[attitude]), model)


@cache
def unmetered(position: str, attitude: str) -> CascadeLoop:
    """Return the closed loop of two laws without meters, which take half of the time of a step in Python."""
    return close_loop(close_cascade(LAWS[position], LAWS[attitude]), NO_METERS)


def default_gains(loop: CascadeLoop) -> Any:
    """Return the default gains of a loop as a record."""
    return pack(loop.cascade.Gains, default_row(loop.cascade, HUMMINGBIRD))


def random_quaternion(rng: np.random.Generator) -> Quaternion:
    """Return a uniformly distributed attitude."""
    q = rng.standard_normal(4)
    return Quaternion(*map(float, q / np.linalg.norm(q)))


def random_record(kind: Any, rng: np.random.Generator) -> Any:
    """Return a record with standard normal leaves."""
    return pack(kind, map(float, rng.standard_normal(size(kind))))


def references(steps: int, hold: float = 1.0, **values: float) -> Array:
    """Return the rows (steps, 14) of a constant reference; values: x, y, z [m], roll, pitch, yaw [rad]."""
    columns = {"x": 0, "y": 1, "z": 2, "roll": 9, "pitch": 10, "yaw": 11}
    rows = np.zeros((steps, 14))
    rows[:, 13] = hold
    for name, value in values.items():
        rows[:, columns[name]] = value
    return rows


def batch(vehicles: list[Vehicle], disturbances: Array, noises: Array, reference: Array) -> Inputs:
    """Return what a batch of flights meets from arrays (scenarios, K, 12), as the steppers read it: lanes last."""
    rows = np.array([flatten(dynamics(vehicle)) for vehicle in vehicles])
    return Inputs(
        rows.T,
        steady_flight(rows, np.zeros((len(rows), 3))).body.T,
        np.moveaxis(disturbances, 0, -1),
        np.moveaxis(noises, 0, -1),
        reference,
    )


def scenario(inputs: Inputs, lane: int) -> Inputs:
    """Return one lane of a batch as floats."""
    dynamics, starts, disturbances, noises = (part[..., lane] for part in inputs[:4])
    return Inputs(dynamics, starts, disturbances, noises, inputs.references)


def in_blocks(inputs: Inputs, order: list[int] | None = None) -> FlightInputs:
    """Return a batch as blocks of lanes for the compiled kernel; order: which scenario flies in which place."""
    order = list(range(inputs.dynamics.shape[-1])) if order is None else order
    parts = [to_lanes(np.moveaxis(part, -1, 0)[order]) for part in inputs[:4]]
    return FlightInputs(parts[0], parts[1], parts[2], parts[3], inputs.references, TARGETS, len(order))
