"""Closed loops and inputs that several tests fly; the full kernel of one combination of laws is compiled once and cached."""

from functools import cache
from math import cos, radians

import numpy as np

from objectives import meters
from plant.air.spec import AirSpec
from plant.backends.flyer import Flyer
from plant.law_registry import LAWS
from plant.loop import MeterModel, Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import Limits, close_loop
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.scenarios import ScenarioSpec, Spread, sample_scenarios
from plant.references.steps import Steps

TIMING = Timing(0.004, 0.001)
LIMITS = Limits(5.0, cos(radians(80.0)))
VEHICLE = load("hummingbird").vehicle
NOMINAL = nominal(VEHICLE, ControlOptions(delay=True), TIMING.control_period)


@cache
def loop(position="ladrc", attitude="hybrid"):
    cascade = close_cascade(LAWS[position], LAWS[attitude])
    return close_loop(cascade, MeterModel(meters.Meters, meters.start, meters.update))


@cache
def flyer(threads=2, limits=LIMITS):
    return Flyer(loop(), limits, TIMING, threads)


def gains(position="ladrc", attitude="hybrid"):
    return np.array(default_row(loop(position, attitude).cascade))


def spec(duration=0.4, **air):
    return ScenarioSpec(
        "test",
        duration,
        Steps(x=1.0, y=-0.5, z=0.3, yaw_deg=20.0, time=0.1),
        AirSpec(intensity="moderate", mean_wind=False, **air),
        spread=Spread(mass=0.1, inertia=0.1, thrust=0.05, lag=0.1),
    )


def inputs(indices, duration=0.4, stream="search", **air):
    return sample_scenarios(spec(duration, **air), VEHICLE, TIMING, 7, stream, indices)
