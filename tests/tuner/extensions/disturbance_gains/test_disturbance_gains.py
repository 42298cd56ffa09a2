"""Gains from a disturbance to an output: closed forms, python-control, and a quarter car's transfer function."""

from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest

import tuner
from plant.errors import InputError
from tests.tuner.extensions.textbook_laws.loops import loop_of, row_of
from tuner.extensions.disturbance_gains.response import DisturbanceResponse
from tuner.study.plant_study import PlantStudy

H = 0.01
QUARTER_CAR = Path(__file__).parents[2] / "study" / "quarter_car.toml"


def peak(numerator, denominator, output="y", **gains):
    system = loop_of(numerator, denominator, "pid_parallel", H)
    return DisturbanceResponse(system, "u_load", output).peaks(row_of(system, ki=0.0, kd=0.0, t_f=0.0, **gains)[None])[
        0
    ]


def test_a_first_order_loop_has_its_peak_at_rest():
    """y+ = a y + b (w - k y), the command acting at once: b/(1 - a + b k) is the constant's gain."""
    a = np.exp(-H)
    b = 1.0 - a
    assert peak([1.0], [1.0, 1.0], kp=4.0) == pytest.approx(b / (1.0 - a + 4.0 * b), rel=1e-9)


def test_a_resonant_loop_has_the_peak_of_python_control():
    plant: Any = control.tf([1.0], [1.0, 0.02, 1.0])
    held: Any = control.c2d(plant, H, "zoh")
    gain: Any = control.tf([3.0], [1.0], H)
    loop = control.feedback(held, gain)
    w = np.concatenate([np.linspace(1.9, 2.1, 20_001), np.geomspace(1e-3, 300.0, 4000)])
    found: Any = control.frequency_response(loop, w)
    right = np.abs(found.complex).max()
    assert peak([1.0], [1.0, 0.02, 1.0], kp=3.0) == pytest.approx(right, rel=1e-4)


def test_an_unstable_loop_has_no_bound():
    assert peak([1.0], [1.0, 0.0, 0.0], kp=5.0) == np.inf


def quarter_car(**changes):
    return tuner.load_study(QUARTER_CAR, {"plant.lost_beyond.stroke": 0.12, **changes}, kind=PlantStudy)


@pytest.mark.slow
def test_the_acceleration_of_a_quarter_car_is_limited_without_a_channel_of_its_own():
    """Hardly controlled, it is the passive car's transfer function from the road, held over each period."""
    limit = {"disturbance": "road", "output": "acceleration", "max": 1.0}
    study = quarter_car(disturbance_gain=[limit])
    row = np.array(study.default_row)
    row[0] = 1e-6
    screen = study.screens[-1]
    (requirement,) = screen.requirements
    assert requirement.label == "disturbance_gain(road, acceleration)" and requirement.unit == "m/s^2/m"
    body, wheel, spring, damper, tyre = 300.0, 40.0, 16e3, 1000.0, 180e3
    s: Any = control.tf("s")
    strut = spring + damper * s
    top = tyre * strut * s**2
    road = top / ((body * s**2 + strut) * (wheel * s**2 + tyre) + body * s**2 * strut)
    w = np.geomspace(0.1, 300.0, 5000)
    found: Any = control.frequency_response(road, w)
    right = np.abs(found.complex).max()
    assert screen.analyse(row[None])[0, 0] == pytest.approx(right, rel=0.01)
    assert study.comparable().get("disturbance_gain") and "disturbance_gain" not in quarter_car().comparable()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            {"disturbance": "rode"},
            r"disturbance_gain\[0\].disturbance: unknown disturbance 'rode'; did you mean 'road'",
        ),
        ({"output": "comfort"}, r"disturbance_gain\[0\].output: unknown output 'comfort'; .*valid: acceleration, "),
    ],
)
def test_an_unknown_name_is_refused_with_those_there_are(change, said):
    limit = {"disturbance": "road", "output": "acceleration", "max": 1.0, **change}
    with pytest.raises(InputError, match=said):
        quarter_car(disturbance_gain=[limit])


def lag_study(**changes):
    """1.0/(s + 1) under a gain of 4, whose own gain varies by 20 %."""
    tables = {
        "title": "Lag", "seed": 1,
        "plant": {"transfer_function": {"numerator": [1.0], "denominator": [1.0, 1.0]}, "control_period": H},
        "channel": [{"name": "lag", "law": "pid_parallel", "output": "y", "to": "u", "lost_beyond": 9.0}],
        "gains": {"lag.kp": {"low": 1.0, "high": 9.0, "default": 4.0}, "lag.ki": 0.0, "lag.kd": 0.0, "lag.t_f": 0.0},
        "scenario": [{"name": "rest", "duration": 1.0, "search": 2, "held_out": 2, "spread": {"b0": 0.2}}],
        "objective": [{"metric": "rms.lag"}],
        "mission": {"off": ["rms.lag"]},
        "disturbance_gain": [
            {"disturbance": "u_load", "output": "y", "max": 0.205},
            {"disturbance": "u_load", "output": "y", "max": 0.205, "spread": True},
        ],
    }  # fmt: skip
    return tuner.make_study({**tables, **changes})


def test_the_largest_gain_in_a_spread_is_that_of_the_strongest_plant_and_is_shown_with_the_margins():
    """At rest K/(1 + 4 K): 1/5 as assumed, 1.2/5.8 with 20 % more gain."""
    found = tuner.margins(tuner.default_gains(lag_study()))
    rows = {row.label: row for row in found.document.requirements if row.label.startswith("disturbance_gain")}
    nominal, spread = (rows[f"disturbance_gain(u_load, y{text})"] for text in ("", ", spread"))
    assert nominal.value == pytest.approx(0.2, rel=1e-9) and nominal.is_satisfied
    assert spread.value == pytest.approx(1.2 / 5.8, rel=1e-9) and not spread.is_satisfied
    assert not found.passed


def test_a_spread_without_a_scenario_that_has_one_is_refused():
    rest = {"name": "rest", "duration": 1.0, "search": 2, "held_out": 2}
    with pytest.raises(
        InputError, match=r"disturbance_gain\[1\].spread: no scenario spreads a parameter; write spread.NAME"
    ):
        lag_study(scenario=[rest])


def test_channels_of_several_rates_are_refused_with_the_reason():
    slow = {"name": "lag", "law": "pid_parallel", "output": "y", "to": "u", "lost_beyond": 9.0, "every": 2}
    with pytest.raises(InputError, match=r"disturbance_gain\[0\].output: channels step at several rates, so a sine"):
        lag_study(channel=[slow])
