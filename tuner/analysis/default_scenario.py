"""Default scenario of commands without a study: one metre steps and a turn of 20 deg in a fresh breeze at 10 m, for 10 s."""

from math import cos, radians

from objectives.system import System
from plant.air.spec import AirSpec
from plant.closed_loop import Limits, Timing
from plant.nominal import nominal
from plant.references.steps import Steps
from plant.scenarios import ScenarioSpec
from tuner.gains import Controller

SCENARIO = ScenarioSpec(
    "steps in a fresh breeze", 10.0, Steps(x=1.0, y=-1.0, z=0.5, yaw_deg=20.0, time=0.5), AirSpec(intensity="light"),
)  # fmt: skip
LIMITS = Limits(5.0, cos(radians(80.0)))
"""Largest position error [m] and cosine of the largest tilt."""


def system_of(controller: Controller, limits: Limits = LIMITS) -> System:
    """Return a controller on its own airframe as a system; limits: beyond them a flight has failed."""
    vehicle = controller.airframe.vehicle
    knowledge = nominal(vehicle, controller.options, controller.control_period)
    timing = Timing(controller.control_period, controller.plant_step)
    return System(vehicle, controller.cascade, knowledge, limits, timing)
