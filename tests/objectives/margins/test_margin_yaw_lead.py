"""Margins of yaw on heavy rotors: an independent transfer function, figures found outside this project, and the low-pass."""

from dataclasses import replace
from typing import Any

import control
import numpy as np
import pytest

from objectives.margins.describing import describing_function
from objectives.margins.margins import MarginModel
from objectives.margins.period import CHANNELS
from plant.laws import hybrid
from plant.quadrotor.airframes import load
from plant.quadrotor.nominal import ControlOptions, nominal, yaw_lead
from plant.vectors import Vec3
from tests.objectives.margins.designs import TIMING, H, cascade_of, constants_of_hybrid, gains_with

YAW = CHANNELS.index("yaw")
F450 = load("f450").vehicle
GAINS = {"yaw__kp": 24.0, "yaw__ki": 2.0, "yaw__kd": 6.4, "yaw__t_f": 0.004}
DELAYED = ControlOptions(delay=True)


def margins(rotor_inertia, options=DELAYED):
    vehicle = F450._replace(rotor_inertia=rotor_inertia)
    model = MarginModel(cascade_of("pid", "pid"), nominal(vehicle, options, H), TIMING, vehicle)
    return model.evaluate(gains_with("pid", "pid", **GAINS))


@pytest.mark.parametrize(
    ("rotor_inertia", "gain_db"), [(0.0, 25.6), (3e-5, 15.6), (5e-5, 11.3), (8e-5, 7.2), (1.287e-4, 3.1)]
)
def test_an_exported_yaw_loop_loses_its_margin_to_the_rotors(rotor_inertia, gain_db):
    """Gains of an exported study, figures of a model of others: to the 0.05 dB that they are printed with."""
    found = margins(rotor_inertia)
    assert 20.0 * np.log10(found.gain_up.value[0, YAW]) == pytest.approx(gain_db, abs=0.051)


def test_the_low_pass_takes_the_lead_back():
    bare, filtered = margins(1.287e-4), margins(1.287e-4, replace(DELAYED, yaw_torque_cutoff=0.25))
    assert np.degrees(bare.phase.value[0, YAW]) == pytest.approx(26.5, abs=0.1)
    assert bare.sensitivity.value[0, YAW] == pytest.approx(3.93, abs=0.01)
    assert np.degrees(filtered.phase.value[0, YAW]) > 50.0
    assert 20.0 * np.log10(filtered.gain_up.value[0, YAW]) > 25.0
    assert filtered.sensitivity.value[0, YAW] < 1.3


def test_the_loop_is_that_of_python_control():
    """Yaw at hover, continuous: PID, low-pass, delay and hold by Pade, rotors with their lead, double integrator.

    Sampled, the hold is half a period late and each of the two low-passes half a period early: at 82 rad/s and 0.25 ms each of
    them is worth 0.6 deg, and some percent of the gain margin.
    """
    h, cutoff = 2.5e-4, 2.0
    none = Vec3(0.0, 0.0, 0.0)
    vehicle = F450._replace(rate_damping=none)
    options = ControlOptions(yaw_torque_cutoff=cutoff)
    timing = TIMING._replace(control_period=h, plant_step=h)
    model = MarginModel(cascade_of("pid", "pid"), nominal(vehicle, options, h), timing, vehicle)
    found = model.evaluate(gains_with("pid", "pid", **GAINS))
    s: Any = control.tf("s")
    law = GAINS["yaw__kp"] + GAINS["yaw__ki"] / s + GAINS["yaw__kd"] * s / (GAINS["yaw__t_f"] * s + 1.0)
    smooth = 1.0 / (s / (2.0 * np.pi * cutoff) + 1.0)
    rotors = (1.0 + s / yaw_lead(vehicle)) / (1.0 + 0.02 * s)
    hold: Any = control.tf(*control.pade(0.5 * h, 4))
    gain, phase, _, _, wc, _ = control.stability_margins(law * smooth * rotors * hold / s**2)
    assert np.degrees(found.phase.value[0, YAW]) == pytest.approx(phase, abs=0.7)
    assert found.gain_up.value[0, YAW] == pytest.approx(gain, rel=0.1)
    assert found.crossover.value[0, YAW] == pytest.approx(wc, rel=0.01)


@pytest.mark.parametrize(("k1", "k2", "delta"), [(40.0, 0.5, 0.01), (5.0, 6.0, 0.5), (20.0, 0.1, 1e-3)])
def test_vanishing_signals_see_the_slope_at_rest(k1, k2, delta):
    """k1 |S|^(1/2) sat(S/delta) + k2 S has the slope k2 at S = 0; at 1e-9 it is still up to 20 % more."""
    constants = constants_of_hybrid(k1, k2, delta)
    found = describing_function(hybrid.sliding_term, constants, np.array([0.0, 1e-3]))[0]
    assert found[0] == pytest.approx(k2, rel=1e-12)
    assert found[1] > k2
