"""The advice on a yaw loop that heavy rotors speed up: what it promises comes true on the margins of the changed study."""

import re
from dataclasses import replace

import numpy as np
import pytest

from objectives.margins.margins import MarginModel
from objectives.margins.period import CHANNELS
from objectives.margins.trim import Trim
from plant.quadrotor.nominal import nominal, yaw_lead
from tuner.experiments.tuning.guards.leading_yaw import HEALTHY, leading_yaw
from tuner.study.build import load_study
from tuner.study.files import SHIPPED

LEADS = re.compile(r"leads from [\d.]+ rad/s on")
CUTOFF = re.compile(r"yaw_torque_cutoff = ([\d.]+) \(Hz\): its phase margin is then ([\d.]+) deg \(now ([\d.]+) deg\)")
HALF = re.compile(r"Half of yaw\.(\w+) gives a phase margin of ([\d.]+) deg \(now ([\d.]+) deg\)")


def heavier(study, factor, **options):
    """The study with rotors of so many times the inertia, and other options of the controller."""
    vehicle = study.system.vehicle
    vehicle = vehicle._replace(rotor_inertia=vehicle.rotor_inertia * factor)
    chosen = replace(study.options, **options)
    knowledge = nominal(vehicle, chosen, study.system.timing.control_period)
    return replace(study, options=chosen, system=replace(study.system, vehicle=vehicle, nominal=knowledge))


def phase(study, row):
    """Phase margin of yaw at hover [deg], with the loops at their own rates."""
    system = study.system
    model = MarginModel(system.cascade, system.nominal, system.timing, system.vehicle, Trim(hold=False))
    return float(np.degrees(model.evaluate(row[None]).phase.value[0, CHANNELS.index("yaw")]))


def scaled(study, factor):
    """The default with its gains of yaw so many times as large."""
    row = study.default_row.copy()
    row[[gain.column for gain in study.system.gains if gain.axis == "yaw"]] *= factor
    return row


@pytest.mark.parametrize(
    ("name", "inertia", "factor", "advice"),
    [
        ("betaflight", 3.0, 3.0, HALF),
        ("betaflight", 10.0, 1.0, HALF),
        ("f450", 10.0, 1.0, CUTOFF),
        ("quickstart", 30.0, 1.0, CUTOFF),
    ],
)
def test_the_advice_comes_true(name, inertia, factor, advice):
    study = heavier(load_study(SHIPPED / f"{name}.toml"), inertia)
    row = scaled(study, factor)
    (text,) = leading_yaw(study, row, "the default's yaw loop")
    assert LEADS.search(text)
    now, found = phase(study, row), advice.search(text)
    assert found
    if advice is CUTOFF:
        cutoff, then, before = map(float, found.groups())
        reached = phase(heavier(study, 1.0, yaw_torque_cutoff=cutoff), row)
    else:
        then, before = float(found[2]), float(found[3])
        changed = row.copy()
        changed[next(gain.column for gain in study.system.gains if gain.address == f"yaw.{found[1]}")] *= 0.5
        reached = phase(study, changed)
    assert before == pytest.approx(now, abs=0.5) and then == pytest.approx(reached, abs=0.5) and reached > now + 0.5


def test_no_advice_is_given_where_none_that_was_tried_helps():
    study = heavier(load_study(SHIPPED / "f450.toml"), 60.0)
    (text,) = leading_yaw(study, study.default_row, "the default's yaw loop")
    assert "A yaw_torque_cutoff of 0.1 Hz and the half of each yaw gain were tried: none raises" in text
    assert phase(heavier(study, 1.0, yaw_torque_cutoff=0.1), study.default_row) == 0.0


def test_a_loop_that_bears_its_lead_is_left_alone():
    """With the cutoff that was printed for it before, 2.1 Hz, the shipped loop of 59 deg is unstable."""
    study = load_study(SHIPPED / "betaflight.toml")
    assert yaw_lead(study.system.vehicle) < 0.5 * 35.0
    assert phase(study, study.default_row) > HEALTHY
    assert leading_yaw(study, study.default_row, "the default's yaw loop") == []
    assert phase(heavier(study, 1.0, yaw_torque_cutoff=2.1), study.default_row) == 0.0
