"""The law in flight: its margins on an airframe are those of the linear loop, and a study searches its settings."""

from math import degrees, log10, sqrt

import pytest

import tuner
from plant.quadrotor.airframes import load
from plant.quadrotor.nominal import yaw_lead
from tuner.extensions.betaflight.betaflight_law import on_airframe
from tuner.extensions.betaflight_adrc.linear_loop import AxisPlant, Sampling, margins
from tuner.extensions.betaflight_adrc.settings import AXES, default_tune

PERIOD = 250e-6
STUDY = f"""
title = "ADRC of Betaflight"
seed = 1
[airframe]
name = "racer5"
[controller]
attitude = "betaflight_adrc"
position = "pid"
control_period = {PERIOD}
position_every = 16
[gains]
"tilt.wc" = {{}}
"tilt.b0" = {{}}
"attitude.schedule" = {{}}
[[scenario]]
name = "hover"
duration = 2.0
search = 2
held_out = 4
reference = {{ kind = "hover" }}
air = {{ intensity = 0.1, mean_wind = false }}
[[objective]]
metric = "rms.tilt"
risk = "mean"
[[objective]]
metric = "noise"
risk = "mean"
"""


def schedules(number):
    return {f"{axis}.schedule": number for axis in AXES}


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("adrc") / "study.toml"
    path.write_text(STUDY)
    return tuner.load_study(path)


def test_margins_of_the_airframe_are_those_of_the_linear_loop(study):
    """The rate loops alone, with hardly any level gain: rotor lag, zero of yaw, filters, sampling and schedule are in both."""
    slow = {f"{axis}.angle_p": 0.01 for axis in AXES}
    gains = tuner.default_gains(study).replace({**slow, **schedules(2.0), "yaw.b0": 600.0})
    table = tuner.margins(gains, study=study, hold_position=False).table
    tune = default_tune().with_numbers({"adrc_b0_yaw": 600.0})
    vehicle = load("racer5").vehicle
    facts = on_airframe(vehicle)
    for axis in AXES:
        zero = 1.0 / yaw_lead(vehicle) if axis == "yaw" else 0.0
        plant = AxisPlant(degrees(facts["authority"][axis]), vehicle.lag_up, 0.0, zero)
        scale = facts["throttle"][axis] / 0.35
        expected = margins(tune, axis, plant, Sampling(PERIOD, PERIOD, (250.0, 500.0)), scale)
        assert 20.0 * log10(table.loc[axis, "gain_up"]) == pytest.approx(20.0 * log10(expected.gain), abs=1e-3)
        assert degrees(table.loc[axis, "phase_margin"]) == pytest.approx(degrees(expected.phase), abs=1e-2)


def test_the_scale_of_b0_is_that_of_hover(study):
    """A schedule that doubles b0 halves the loop's gain."""
    throttle = on_airframe(load("racer5").vehicle)["throttle"]["roll"]
    gains = tuner.default_gains(study).replace({f"{axis}.angle_p": 0.01 for axis in AXES})
    sampled = {
        schedule: tuner.margins(gains.replace(schedules(schedule)), study=study, hold_position=False).table
        for schedule in (1.0, 3.0)
    }
    ratio = sampled[1.0].loc["roll", "gain_up"] / sampled[3.0].loc["roll", "gain_up"]
    assert ratio == pytest.approx(sqrt(throttle / 0.35), rel=1e-3)
