"""The loop that somebody outside flies is our loop: with our own attitude loops outside, every number of the flight is the same."""

from dataclasses import replace
from math import cos, radians

import numpy as np
import pytest

from objectives import meters
from plant.air.spec import AirSpec
from plant.backends.stepping import fly_steps, lane_of, unchanged
from plant.law_registry import LAWS
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.loop import MeterModel, Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import Limits, close_loop
from plant.quadrotor.features import VehicleFeatures
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.scenarios import ScenarioSpec, sample_scenarios
from plant.records import flatten, pack
from plant.references.hover import Hover
from tests.plant.attitude_outside import AttitudeOutside
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.autopilots.piloted import angle, close_piloted, pilot_of

TIMING = Timing(0.00025, 0.00025)
METER = MeterModel(meters.Meters, meters.start, meters.update)
LIMITS = Limits(5.0, cos(radians(80.0)))


def heading_rate(constants, setpoint, measured):
    return constants.outer * (setpoint.value - measured.value) + setpoint.rate


def given(duration=0.04):
    vehicle = load("racer5").vehicle
    options = ControlOptions(delay=True)
    cascade = close_cascade(LAWS["pid"], LAWS["betaflight"], 16)
    spec = ScenarioSpec("gusts", duration, Hover(), AirSpec(intensity=3.5, altitude=20.0, mean_wind=True))
    inputs = sample_scenarios(spec, vehicle, TIMING, 3, "test", range(1))
    gains = pack(cascade.Gains, default_row(cascade, vehicle))
    return cascade, gains, nominal(vehicle, options, TIMING.control_period), inputs


def flown_outside(cascade, gains, known, inputs, late):
    loop = close_piloted(cascade, pilot_of(cascade.attitude, heading_rate), METER, VehicleFeatures(late))
    outside = AttitudeOutside(cascade.attitude, gains, known, TIMING.control_period)

    def decide(flight, constants, nominal, reference, noise, targets, limits, time, h):
        flight = loop.ask(flight, constants, nominal, reference, noise, h)
        seen = flight.control
        asked = Instant(
            tuple(seen.angles), tuple(seen.rate), tuple(seen.tilt), seen.controller.yaw.wish, 0.25 * sum(seen.lift)
        )
        control = seen._replace(outside=outside.thrusts(asked))
        return loop.decide(
            flight._replace(control=control), constants, nominal, reference, noise, targets, limits, time, h
        )

    return fly_steps(
        replace(loop, decide=decide), unchanged, gains, known, lane_of(inputs, 0), inputs.targets, LIMITS, TIMING
    )


@pytest.mark.parametrize("late", [0, 3])
def test_our_own_attitude_loops_outside_fly_our_own_flight(late):
    cascade, gains, known, inputs = given()
    own = fly_steps(
        close_loop(cascade, METER, VehicleFeatures(late)),
        unchanged,
        gains,
        known,
        lane_of(inputs, 0),
        inputs.targets,
        LIMITS,
        TIMING,
    )
    there = flown_outside(cascade, gains, known, inputs, late)
    assert max(abs(part) for part in own.body.rate) > 0.003
    np.testing.assert_allclose(flatten(there.body), flatten(own.body), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(flatten(there.meters), flatten(own.meters), rtol=1e-9, atol=1e-12)


def test_the_pilot_tells_the_angle_and_the_rate_of_the_reference():
    pilot = pilot_of(LAWS["px4"], angle)
    memory = pilot.start(None, Measured(0.0, 0.0), 0.0)
    goal, unit = Setpoint(0.3, 0.7, 0.0), Channel(1.0, 0.0)
    torque, command = pilot.step(memory, None, unit, goal, Measured(0.1, 0.2), Applied(0.0, 0.0), 0.0025)
    assert (torque, command.wish, command.rate) == (0.0, 0.3, 0.7)
