"""The law against the firmware's code, its closed forms, and its gate."""

from pathlib import Path

import numpy as np
import pytest

from plant.errors import InputError, UnknownNameError
from tests.tuner.extensions.betaflight_adrc.traces import random_case, run_law
from tuner.extensions.betaflight_adrc import equations
from tuner.extensions.betaflight_adrc.equations import SCHEDULES
from tuner.extensions.betaflight_adrc.settings import BUILDS, build_of, default_tune, recognize_build

N_TUNES = 40
LOOPS = [0, 299, 450, 600, 900, 1199]
FIRMWARE = {
    build: np.loadtxt(Path(__file__).with_name(name)).reshape(N_TUNES, len(LOOPS), 3)
    for build, name in (("b11", "firmware_outputs.txt"), ("pr-august", "august_outputs.txt"))
}


@pytest.mark.parametrize("seed", range(N_TUNES))
@pytest.mark.parametrize("build", FIRMWARE)
def test_outputs_are_those_of_the_firmware(build, seed):
    outputs = run_law(*random_case(seed, BUILDS[build])).reshape(-1, 3, 4)
    largest = np.abs(outputs).max()
    np.testing.assert_allclose(outputs[LOOPS, :, :3].sum(axis=2), FIRMWARE[build][seed], rtol=0.0, atol=1e-6 * largest)


def test_the_gate_opens_by_rate_only_off_idle_and_after_the_hold():
    constants = default_tune().gate(1e-3)
    gate = equations.SHUT
    for _ in range(200):
        gate = equations.step_gate(gate, constants, 100.0, 0.1, 0.1, 1e-3)
    assert gate.is_open == 0.0
    opened = 0
    while gate.is_open == 0.0:
        gate, opened = equations.step_gate(gate, constants, 100.0, 0.3, 0.3, 1e-3), opened + 1
    # 25 ms; the sum of 25 periods is rounded.
    assert opened in (25, 26)
    gate = equations.step_gate(gate, constants, 0.0, 0.0, 0.0, 1e-3)
    assert gate.is_open == 1.0


def test_the_scale_falls_below_1_in_the_air_alone():
    constants = default_tune().with_numbers({"adrc_b0_scale_min": 50.0}).gate(1e-3)
    assert equations.limited_scale(0.2, 0.0, constants) == 1.0
    assert equations.limited_scale(0.2, 1.0, constants) == 0.5


@pytest.mark.parametrize(
    ("schedule", "scale"), [("QUADRATIC", 4.0), ("SQRT", 2.0**0.5), ("LINEAR", 2.0), ("FIXED", 1.0)]
)
def test_schedules_at_twice_the_collective_of_hover(schedule, scale):
    assert equations.schedule_scale(SCHEDULES[schedule], 2.0) == pytest.approx(scale)


def test_the_observer_is_slowed_down_to_half_the_loop():
    tune = default_tune().with_numbers({"adrc_wo_roll": 600.0})
    assert tune.axis("roll", 1e-3).wo == 500.0 and tune.axis("roll", 125e-6).wo == 600.0


def test_ground_wc_of_the_default_tune_is_10_rad_per_s():
    # 4.0 x 2000/(2 x 100) = 40 is no limit below 10; a larger wo makes it one.
    tune = default_tune()
    assert tune.axis("roll", 1e-3).ground_wc == 10.0
    assert tune.with_numbers({"adrc_wo_roll": 500.0}).axis("roll", 1e-3).ground_wc == 8.0


@pytest.mark.parametrize("zeta", [100.0, 50.0, 0.0])
def test_a_damping_ratio_scales_d_alone(zeta):
    """Notes of b11: 100 % leaves the law as it is, 50 % halves D, and 0 % removes it."""
    full, scaled = (default_tune().with_numbers({"adrc_zeta_yaw": value}).axis("yaw", 1e-3) for value in (100.0, zeta))
    state = equations.seeded(30.0)._replace(z2=500.0, z3=-4000.0)
    usual, damped = (equations.feedback(state, constants, 1.0, 2000.0) for constants in (full, scaled))
    assert damped == usual._replace(d=0.01 * zeta * usual.d)


def test_builds_are_known_by_revision_or_by_settings():
    assert recognize_build("6317fe2aa", frozenset()) is BUILDS["pr-august"]
    assert recognize_build("923932bde", frozenset()) is BUILDS["b10.1"]
    assert recognize_build("0123456", frozenset({"adrc_motor_tau_ms"})) is BUILDS["mp2"]
    assert recognize_build("0123456", frozenset({"adrc_wc_roll"})) is None
    with pytest.raises(UnknownNameError, match=r"b10\.1.*mp2"):
        build_of("b12")


@pytest.mark.parametrize(
    ("build", "name", "value", "said"),
    [
        ("b10.1", "adrc_ground_wc", 10.0, "build b10.1 has no such setting"),
        ("pr-august", "adrc_b0_law", 1.0, "build pr-august has no such setting"),
        ("mp2", "adrc_td_hz", 10.0, "build mp2 has no such setting"),
        ("b11", "adrc_wc_roll", 4.0, "given 4 rad/s; give a whole number from 5 to 300"),
        ("b11", "adrc_wc_roll", 60.5, "given 60.5 rad/s"),
    ],
)
def test_numbers_that_a_build_refuses(build, name, value, said):
    with pytest.raises(InputError, match=said):
        default_tune(BUILDS[build]).with_numbers({name: value})


def test_builds_without_a_ground_mode_fly_wc_on_the_ground():
    assert default_tune(BUILDS["b10.1"]).axis("roll", 1e-3).ground_wc == 60.0
