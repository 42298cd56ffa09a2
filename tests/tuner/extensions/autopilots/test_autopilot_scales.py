"""Torque for a unit of an autopilot's output: the published closed forms, sums of r x F, and airframes that have no such scale."""

import re
from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np
import pytest

from plant.errors import InputError
from plant.law_registry import LAWS
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import RotorMount, actuation
from plant.quadrotor.nominal import shift_center_of_mass
from plant.vectors import Rotors
from tests.tuner.exchange.controllers import pid
from tests.tuner.exchange.flying_autopilots import (
    ardupilot_mix,
    hover_thrust,
    motor_command,
    px4_allocation,
    thrust_of,
    torque_on,
)
from tuner.exchange.registry import exporter, settings_of
from tuner.exchange.target import Request
from tuner.extensions.autopilots.scales import (
    accelerations,
    ardupilot_factors,
    betaflight_factors,
    command_slope,
    hover_share,
    px4_factors,
    torque_scale,
)

FACTORS = {"px4": px4_factors, "ardupilot": ardupilot_factors, "betaflight": betaflight_factors}


def rectangle(l_x, l_y, k_m, thrust):
    rotors = actuation(load("iris").vehicle)
    mounts = [
        RotorMount(x, y, spin, k_m) for x, y, spin in ((l_x, l_y, 1), (l_x, -l_y, -1), (-l_x, l_y, -1), (-l_x, -l_y, 1))
    ]
    return replace(rotors, thrust_max=thrust, rotors=tuple(mounts))


@pytest.mark.parametrize(
    ("target", "roll", "pitch", "yaw"),
    [("px4", 1.4934, 1.4934, 0.384), ("ardupilot", 1.056, 1.056, 0.192), ("betaflight", 2.112, 2.112, 0.384)],
)
def test_the_published_example(target, roll, pitch, yaw):
    """0.088 m, 6 N, 0.016 m: worked out by hand from the autopilots' sources."""
    rotors = rectangle(0.088, 0.088, 0.016, 6.0)
    scale = torque_scale(rotors, FACTORS[target](rotors), 6.0, target)
    assert scale == pytest.approx((roll, pitch, yaw), rel=2e-5)


@pytest.mark.parametrize(("l_x", "l_y"), [(0.13, 0.22), (0.2, 0.1)])
def test_closed_forms_of_a_rectangle(l_x, l_y):
    """Roll goes with the side arm, pitch with the fore-and-aft arm; PX4 gives both the scale of the shorter."""
    k_m, thrust = 0.03, 5.0
    rotors = rectangle(l_x, l_y, k_m, thrust)
    found = {name: torque_scale(rotors, factors(rotors), thrust, name) for name, factors in FACTORS.items()}
    shorter = 2.0 * sqrt(2.0) * min(l_x, l_y) * thrust
    assert found["px4"] == pytest.approx((shorter, shorter, 4.0 * k_m * thrust), rel=1e-12)
    assert found["ardupilot"] == pytest.approx((2.0 * l_y * thrust, 2.0 * l_x * thrust, 2.0 * k_m * thrust), rel=1e-12)
    assert found["betaflight"] == pytest.approx((4.0 * l_y * thrust, 4.0 * l_x * thrust, 4.0 * k_m * thrust), rel=1e-12)


def test_closed_forms_of_a_plus():
    """Two rotors turn the vehicle instead of four."""
    rotors = actuation(load("hummingbird-rotors").vehicle)
    arm, k_m, thrust = 0.17, 0.016, 3.0
    found = {name: torque_scale(rotors, factors(rotors), thrust, name) for name, factors in FACTORS.items()}
    assert found["px4"] == pytest.approx(
        (sqrt(2.0) * arm * thrust, sqrt(2.0) * arm * thrust, 4.0 * k_m * thrust), rel=1e-12
    )
    assert found["ardupilot"] == pytest.approx((arm * thrust, arm * thrust, 2.0 * k_m * thrust), rel=1e-12)
    assert found["betaflight"] == pytest.approx((2.0 * arm * thrust, 2.0 * arm * thrust, 4.0 * k_m * thrust), rel=1e-12)


@pytest.mark.parametrize("airframe", ["iris", "f450", "hummingbird-rotors"])
@pytest.mark.parametrize(("target", "independent"), [("px4", px4_allocation), ("ardupilot", ardupilot_mix)])
def test_motors_move_as_the_autopilots_say(airframe, target, independent):
    vehicle = load(airframe).vehicle
    rotors = actuation(vehicle)
    assert np.allclose(FACTORS[target](rotors), independent(vehicle), atol=1e-9)


@pytest.mark.parametrize("target", FACTORS)
@pytest.mark.parametrize("airframe", ["iris", "f450", "hummingbird-rotors"])
def test_a_unit_of_output_gives_that_torque(airframe, target):
    """Thrusts on the real rotors, r x F, FLU against the autopilots' FRD: a unit of pitch or yaw turns the other way round."""
    vehicle = load(airframe).vehicle
    rotors = actuation(vehicle)
    factors = FACTORS[target](rotors)
    scale = torque_scale(rotors, factors, rotors.thrust_max, target)
    for k, sign in enumerate((1.0, -1.0, -1.0)):
        up, down = (torque_on(vehicle, 0.5 + step * factors[:, k], 0.0, 0.0) for step in (0.1, -0.1))
        expected = np.zeros(3)
        expected[k] = sign * scale[k]
        assert np.allclose((up - down) / 0.2, expected, atol=1e-12)


@pytest.mark.parametrize("target", FACTORS)
def test_rotors_about_another_point_than_the_centre_of_mass(target):
    """PX4's pseudo-inverse knows the places and keeps the axes apart; fixed factors do not, and lift would turn the vehicle."""
    vehicle = shift_center_of_mass(load("iris").vehicle, 0.01, 0.005)
    rotors = actuation(vehicle)
    if target == "px4":
        assert min(torque_scale(rotors, px4_factors(rotors), 5.0, target)) > 0.0
    else:
        with pytest.raises(InputError, match="airframe: a unit of roll, pitch or yaw .* symmetrically"):
            uneven = (replace(rotors.rotors[0], x=0.2), *rotors.rotors[1:])
            torque_scale(replace(rotors, rotors=uneven), FACTORS[target](rotors), 5.0, target)


@pytest.mark.parametrize("curve", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("model", [0.0, 0.65, 1.0])
def test_slope_and_hover_of_a_command(curve, model):
    """By differences through the autopilot's inversion and the rotor's own curve."""
    vehicle = load("hummingbird").vehicle
    rotors = actuation(vehicle, curve)
    hover, step = hover_thrust(vehicle, curve, model), 1e-6
    above, below = (thrust_of(vehicle, motor_command(hover + part, model), curve) for part in (step, -step))
    assert hover_share(rotors, model) == pytest.approx(hover, rel=1e-12)
    assert command_slope(rotors, model) == pytest.approx((above - below) / (2.0 * step), rel=1e-8)
    if curve == model:
        assert command_slope(rotors, model) == pytest.approx(rotors.thrust_max, rel=1e-12)


@pytest.mark.parametrize("linear", [-0.4, 0.0, 0.4, 1.0])
def test_authority_is_the_slope_of_the_airframes_curve_through_the_autopilots(linear):
    """PX4 and ArduPilot undo curves between line and square, so a unit gives all of the thrust; Betaflight undoes none."""
    vehicle = load("hummingbird").vehicle._replace(thrust_linear=linear)
    most, step = actuation(vehicle).thrust_max, 1e-6
    for name, model in (("px4", min(1.0 - linear, 1.0)), ("ardupilot", min(1.0 - linear, 1.0)), ("betaflight", 0.0)):
        on_airframe = LAWS[name].on_airframe
        assert on_airframe is not None
        hover = hover_thrust(vehicle, 1.0 - linear, model)
        thrusts = [thrust_of(vehicle, motor_command(hover + part, model), 1.0 - linear) for part in (step, -step)]
        slope = (thrusts[0] - thrusts[1]) / (2.0 * step)
        plain = accelerations(actuation(vehicle), FACTORS[name](actuation(vehicle)), slope, vehicle, name)
        unit = 1000.0 if name == "betaflight" else 1.0
        assert on_airframe(vehicle)["authority"]["roll"] * unit == pytest.approx(plain["roll"], rel=1e-7)
        if name != "betaflight" and linear >= 0.0:
            assert slope == pytest.approx(most, rel=1e-7)


# Where a motor stands clockwise from the nose [deg], and whether it turns clockwise, by its number: AP_MotorsMatrix.cpp (frames X
# and plus), PX4's geometry of a quad X, Betaflight's mixerQuadX, power_distribution_quadrotor.c of the Crazyflie.
ARDUPILOT_X = {1: (45, False), 2: (225, False), 3: (315, True), 4: (135, True)}
PUBLISHED = {
    "ardupilot": ("gainproof.param", ARDUPILOT_X),
    "px4": ("gainproof.params", ARDUPILOT_X),
    "betaflight": ("gainproof.betaflight.txt", {1: (135, True), 2: (45, False), 3: (225, False), 4: (315, True)}),
    "crazyflie": ("gainproof_params.yaml", {1: (45, False), 2: (135, True), 3: (225, False), 4: (315, True)}),
}
BEARINGS = {
    "front right": 45,
    "rear right": 135,
    "rear left": 225,
    "front left": 315,
    "front": 0,
    "right": 90,
    "rear": 180,
    "left": 270,
}


def told_motors(text):
    found = re.findall(r"motor (\d) ([a-z ]+?) (clockwise|counter-clockwise)\b", text)
    return {int(number): (BEARINGS[place], sense == "clockwise") for number, place, sense in found}


# Gains in the ranges that each target documents.
FITTING = {
    "ardupilot": {
        "yaw__kp": 26.0, "yaw__ki": 10.0, "yaw__kd": 6.5, "z__kp": 7.4, "z__ki": 4.9, "z__kd": 3.4, "pitch__kp": 80.0,
        "pitch__ki": 50.0, "pitch__kd": 14.0,
    },
    "px4": {"z__kp": 7.0, "z__ki": 1.5, "z__kd": 6.0, "yaw__kp": 9.0, "yaw__ki": 3.0, "yaw__kd": 4.0},
    "betaflight": {"yaw__kp": 20.0, "yaw__ki": 12.0, "yaw__kd": 6.0},
    "crazyflie": {},
}  # fmt: skip


def exported_text(target, airframe: Any = "iris"):
    entry = exporter(target)
    given = pid(airframe, **FITTING[target])
    settings = settings_of(entry, ("firmware=4.7",) if target == "ardupilot" else ())
    return entry.export(Request(given, "ab" * 32, settings)).files[PUBLISHED[target][0]].decode()


@pytest.mark.parametrize("target", PUBLISHED)
def test_motors_are_named_by_the_targets_own_numbers_and_their_place(target):
    text = exported_text(target, {"px4": "hummingbird", "crazyflie": "crazyflie-pybullet"}.get(target, "iris"))
    assert told_motors(text) == PUBLISHED[target][1]
    assert "rotor 1" not in text


def test_a_plus_frame_and_the_other_sense_name_another_frame_of_ardupilot():
    """The Iris with its rotors turned about: frame H; on the axes of the body: plus."""
    frame = load("iris")
    arm = frame.vehicle.rotor_x[0]
    plus = {"rotor_x": Rotors(arm, 0.0, 0.0, -arm), "rotor_y": Rotors(0.0, -arm, arm, 0.0)}
    about = Rotors(*(-spin for spin in frame.vehicle.spin))
    assert "FRAME_TYPE 1)" in exported_text("ardupilot", frame)
    turned = exported_text("ardupilot", replace(frame, vehicle=frame.vehicle._replace(spin=about)))
    assert "FRAME_TYPE 3" in turned and told_motors(turned) == {
        n: (at, not way) for n, (at, way) in ARDUPILOT_X.items()
    }
    crossed = exported_text("ardupilot", replace(frame, vehicle=frame.vehicle._replace(**plus)))
    assert "FRAME_TYPE 0" in crossed
    assert told_motors(crossed) == {1: (90, False), 2: (270, False), 3: (0, True), 4: (180, True)}
