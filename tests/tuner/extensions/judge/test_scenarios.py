"""Flights of an opinion: the torque of a step, the gust, the low battery, and what each source compares."""

from dataclasses import replace

import pytest

from plant.quadrotor.airframes import load
from tests.tuner.exchange.reading import write
from tuner.extensions.judge.scenarios import drain_battery, judged_scenarios, torque_step
from tuner.extensions.judge.vehicle_files import read_parameter_file

GAINS = "set p_roll = 45\nset i_roll = 80\n"
HEAD = "# Betaflight / STM32F7X2 (S7X2) 2026.6.0 Jul  1 2026 / 00:00:00 (abc) MSP API: 1.48\nprofile 0\n"


@pytest.fixture
def controller(tmp_path):
    file = write(tmp_path, HEAD + GAINS, "present.txt")
    return read_parameter_file(file, "betaflight", load("racer5")).gains.controller


def test_a_torque_step_is_the_weight_on_a_tenth_of_the_arm(controller):
    vehicle = controller.airframe.vehicle
    x, y, z = torque_step(vehicle).angular_bias
    # racer5: 0.7 kg on rotors 125 mm from the middle.
    torque = 0.1 * 0.125 * vehicle.mass * 9.80665
    assert (x * vehicle.inertia.x, y * vehicle.inertia.y, z) == pytest.approx((torque, torque, 0.0), rel=2e-3)


@pytest.mark.parametrize(("source", "position"), [("px4", True), ("gains", True), ("betaflight", False)])
def test_position_is_compared_where_its_loops_are_in_the_file(source, position, controller):
    first, _, gust, _ = judged_scenarios(controller, source)
    assert [scenario.spec.name for scenario in (first, gust)] == ["small steps in a light breeze", "gust"]
    assert all(("rms.position" in scenario.metrics) == position for scenario in (first, gust))
    assert "noise" in first.metrics and "noise" not in gust.metrics


def test_a_low_battery_flies_where_the_airframe_has_one(controller):
    vehicle = controller.airframe.vehicle._replace(
        battery_full=16.8, battery_empty=14.0, battery_resistance=0.02, battery_capacity=4680.0, hover_power=150.0
    )
    assert "low battery" not in [scenario.spec.name for scenario in judged_scenarios(controller, "px4")]
    driven = replace(controller, airframe=replace(controller.airframe, vehicle=vehicle))
    *_, low = judged_scenarios(driven, "px4")
    assert low.spec.name == "low battery"
    assert low.vehicle_of(driven).airframe.vehicle.battery_used == 0.8 * 4680.0
    assert drain_battery(vehicle._replace(battery_used=4600.0)).battery_used == 4600.0
