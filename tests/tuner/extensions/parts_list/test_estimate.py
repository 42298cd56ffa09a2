"""An airframe from a parts list: published bench data, momentum theory, and vehicles whose numbers are known."""

from math import pi, sqrt

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.uncertainty import can_exist
from tuner.extensions.parts_list.api import estimate_airframe
from tuner.extensions.parts_list.estimate import (
    DENSITY,
    INCH,
    MERIT,
    PartsList,
    Propeller,
    estimated,
    thrust_coefficient,
    torque_ratio,
)

CRAZYFLIE = PartsList(0.027, 2.0 * 0.0397, Propeller(0.046, 0.030), 14000, 1)
KNOWN = {
    "f450": PartsList(1.4, 0.45, Propeller(10.0 * INCH, 4.5 * INCH), 920, 3),
    "racer5": PartsList(0.752, 0.25, Propeller(5.1 * INCH, 4.8 * INCH, 3), 2400, 4),
    "hummingbird-rotors": PartsList(0.716, 0.34, Propeller(8.0 * INCH, 4.5 * INCH), 1000, 3),
    "crazyflie-rotors": CRAZYFLIE,
    "crazyflie-pybullet": CRAZYFLIE,
}
"""Airframes with parts that such vehicles are built of."""
OUTSIDE = {("crazyflie-pybullet", "torque_ratio"), ("f450", "drag_linear.z")}
"""The first has four times the yaw torque that crazyflie-rotors, the same vehicle, has; the second has no linear drag at all."""


def truth_of(name, estimate):
    """Numbers of a bundled airframe by name, its thrust at the command that gives the estimate's speed."""
    vehicle = load(name).vehicle
    scale = (vehicle.speed_max / estimate.values["speed_max"].value) ** 2
    known = {key: getattr(vehicle, key) for key in ("mass", "torque_ratio", "lag_up", "lag_down")}
    known |= {f"inertia.{axis}": getattr(vehicle.inertia, axis) for axis in "xyz"}
    return known | {"thrust_coefficient": vehicle.thrust_coefficient * scale, "drag_linear.z": vehicle.drag_linear.z}


@pytest.mark.parametrize("name", KNOWN)
def test_the_numbers_of_known_vehicles_lie_in_the_ranges(name):
    found = estimated(KNOWN[name])
    outside = set()
    for key, value in truth_of(name, found).items():
        low, high = found.interval(key)
        outside |= set() if low <= value <= high else {(name, key)}
    assert outside == {entry for entry in OUTSIDE if entry[0] == name}


def test_static_thrust_is_that_of_the_example_of_its_source():
    """A 10x6 at 10,500 rpm: 1619 g."""
    thrust = thrust_coefficient(Propeller(10.0 * INCH, 6.0 * INCH)) * (10500.0 * 2.0 * pi / 60.0) ** 2
    assert thrust / 9.81 == pytest.approx(1.619, rel=1e-3)


def test_torque_is_that_of_a_rotor_with_the_figure_of_merit():
    """The power that the slipstream takes away, from its own speed, over that of the shaft."""
    propeller, omega = Propeller(0.2, 0.1), 700.0
    thrust = thrust_coefficient(propeller) * omega**2
    induced = sqrt(thrust / (2.0 * DENSITY * pi * 0.1**2))
    shaft = torque_ratio(propeller) * thrust * omega
    assert thrust * induced / shaft == pytest.approx(MERIT)


def test_a_known_hover_narrows_the_thrust_and_decides_the_thrust_to_weight():
    wide, narrow = (estimated(KNOWN["f450"]._replace(hover=hover)) for hover in (None, 0.55))
    at = wide.uncertainty.names.index("thrust_coefficient")
    assert narrow.uncertainty.deviations[at] < wide.uncertainty.deviations[at] / 5.0
    assert narrow.thrust_to_weight == pytest.approx(1.0 / 0.55**2)
    assert narrow.uncertainty.correlation[at][0] > 0.1 > wide.uncertainty.correlation[at][0]


def test_more_blades_give_more_thrust_but_less_than_in_proportion():
    two, three = (thrust_coefficient(Propeller(0.127, 0.11, blades)) for blades in (2, 3))
    assert two < three < 1.5 * two


def test_parts_that_do_not_lift_are_refused_and_too_strong_ones_are_lowered():
    with pytest.raises(InputError, match=r"would lift 0\.19 times the weight"):
        estimated(KNOWN["f450"]._replace(mass=14.0))
    strong = estimated(KNOWN["racer5"]._replace(cells=8))
    assert strong.thrust_to_weight == pytest.approx(14.7) and strong.is_lowered
    assert "lowered to a thrust to weight" in strong.values["speed_max"].source
    assert not estimated(KNOWN["racer5"]).is_lowered


def test_a_hover_command_that_is_given_decides_the_thrust_of_strong_vehicles():
    weaker, stronger = (estimated(KNOWN["racer5"]._replace(hover=hover)) for hover in (0.32, 0.28))
    assert (weaker.thrust_to_weight, stronger.thrust_to_weight) == pytest.approx((0.32**-2, 0.28**-2))


@pytest.mark.parametrize(
    ("hover", "said"), [(None, "--hover 0.3"), (0.2, "A hover at 0.2 of full command means 25 times")]
)
def test_a_lowered_speed_is_said(hover, said, tmp_path):
    parts = {"mass": 0.6, "wheelbase": 0.25, "propeller": "5.1x4.8x3", "kv": 2400, "cells": 8, "hover": hover}
    verdict = estimate_airframe(tmp_path / "strong.toml", **parts).document.verdict
    assert verdict.index(said) < verdict.index("These ranges are wide")
    assert "speed_max was lowered to 14.7 times, the most that an airframe may have (15)" in verdict
    assert load(tmp_path / "strong.toml").vehicle.mass == 0.6


def test_every_vehicle_drawn_can_take_off():
    found = estimated(KNOWN["f450"])
    vehicle = load("f450").vehicle._replace(
        thrust_coefficient=found.values["thrust_coefficient"].value, speed_max=found.values["speed_max"].value
    )
    draw = np.random.default_rng(1)
    moved = [
        found.uncertainty.moved(vehicle, found.uncertainty.axes @ draw.standard_normal(len(found.uncertainty.names)))
        for _ in range(50)
    ]
    assert not all(map(can_exist, moved))
    assert all(can_exist(found.uncertainty.draw(vehicle, draw)) for _ in range(50))
