"""Plant steps that modes at rest allow, against Runge-Kutta maps and exponentials of matrices."""

import numpy as np
import pytest
from scipy.linalg import expm

from plant.errors import InputError
from plant.model.modes import MAX_ERROR, MAX_STEPS, accurate_timing, check_plant_step
from plant.model.plan import Actuator
from plant.own_code import run_own_code
from tests.plant.model.plants import FILES, pid
from tuner.api.plants import plant_system
from tuner.api.studies import make_study
from tuner.gains.ranges import timing_of

PERIOD = 0.04


def mode(angle, damping):
    """An oscillator that turns so far in a period and is damped so much, where negative it grows: a matrix (2, 2) [1/s]."""
    w = angle / PERIOD
    return np.array([[0.0, 1.0], [-w * w, -2.0 * damping * w]])


def runge_kutta(matrix, steps):
    """The matrix of a period in so many classical steps."""
    a = PERIOD / steps * matrix
    unit = np.eye(len(a))
    return np.linalg.matrix_power(unit + a @ (unit + a / 2.0 @ (unit + a / 3.0 @ (unit + a / 4.0))), steps)


def wrong(matrix, steps):
    """Largest error of an eigenvalue of the period's matrix, where it grows as a share of it."""
    exact, flown = (
        np.sort_complex(np.linalg.eigvals(each).astype(complex))
        for each in (expm(PERIOD * matrix), runge_kutta(matrix, steps))
    )
    return np.max(np.abs(flown - exact) / np.maximum(np.abs(exact), 1.0))


@pytest.mark.parametrize("angle", [0.05, 0.3, 0.8, 2.0, 2.5])
@pytest.mark.parametrize("damping", [0.003, 0.1, 0.7, -0.1])
def test_the_default_step_is_the_longest_that_flies_a_mode_as_its_exponential(angle, damping):
    matrix = mode(angle, damping)
    steps = accurate_timing(np.linalg.eigvals(matrix), PERIOD).steps
    allowed = MAX_ERROR * min(abs(damping) * angle, 1.0)
    assert wrong(matrix, steps) <= allowed
    assert steps == 1 or wrong(matrix, steps - 1) > allowed


@pytest.mark.parametrize("lag", [0.001, 0.004, 0.04, 0.4])
def test_a_fast_lag_only_has_to_settle_within_the_period(lag):
    """A lag of a fortieth of the period needs 27 steps, where half a lag a step would be 80."""
    steps = accurate_timing(np.array([-1.0 / lag]), PERIOD).steps
    assert abs(runge_kutta(np.array([[-1.0 / lag]]), steps)[0, 0] - np.exp(-PERIOD / lag)) < MAX_ERROR
    assert steps == {0.001: 27, 0.004: 7, 0.04: 2, 0.4: 1}[lag]


def test_what_takes_too_many_steps_is_refused_with_a_step_that_works():
    poles = np.array([-1e5, -1.0])
    with pytest.raises(
        InputError, match=f"a time constant of 1e-05 s, which takes .* up to {MAX_STEPS} are taken by default"
    ) as caught:
        accurate_timing(poles, PERIOD)
    advised = float(str(caught.value).split("plant_step = ")[1].split()[0])
    check_plant_step(poles, timing_of(PERIOD, advised, 1.0, 0.0))


STUDY = {
    "title": "A kiln", "seed": 1,
    "channel": [{"name": "heat", "law": "pid", "output": "chamber", "to": "power", "lost_beyond": 100.0}],
    "gains": {"heat.kp": {"low": 1.0, "high": 500.0, "default": 60.0}, "heat.ki": 0.05, "heat.kd": 0.0, "heat.t_f": 0.0},
    "scenario": [{"name": "still", "duration": 4.0, "search": 2, "held_out": 2}], "objective": [{"metric": "iae.heat"}],
}  # fmt: skip


def timing_in_a_study(lag, plant_step):
    plant = {"control_period": PERIOD} | ({} if plant_step is None else {"plant_step": plant_step})
    tables = STUDY | {"plant": plant, "actuator": [{"name": "power", "low": 0.0, "high": 1e4, "lag": lag}]}
    return make_study(tables, "kiln", plant=run_own_code(FILES["kiln"]).names).system.timing


def timing_of_a_system(lag, plant_step):
    names, channels = run_own_code(FILES["kiln"]).names, [pid("heat", "chamber", "power", limit=100.0)]
    actuators = [Actuator("power", 0.0, 1e4, lag=lag)]
    return plant_system(names, "kiln", channels, actuators, control_period=PERIOD, plant_step=plant_step).timing


def test_a_mode_that_swings_too_fast_for_the_period_is_refused_with_a_period():
    poles = np.array([-0.01 + 2.0j, -0.01 - 2.0j])
    with pytest.raises(
        InputError, match=r"given 200 s; at rest a mode swings at 0.3183 Hz, .* 0.0025 Hz: .* up to 1.57 s"
    ):
        accurate_timing(poles, 200.0)


def test_a_pole_at_zero_that_rounding_moved_takes_one_step():
    assert accurate_timing(np.array([3e-16 + 0.0j, -2e-16]), 2.0).plant_step == 2.0


@pytest.mark.parametrize("timing", [timing_in_a_study, timing_of_a_system])
def test_a_study_and_a_system_take_and_refuse_the_same_lags(timing):
    assert timing(0.001, None).steps == 27
    assert timing(0.02, PERIOD).steps == 1
    with pytest.raises(InputError, match="a time constant of 0.001 s, which would grow at such steps") as caught:
        timing(0.001, PERIOD)
    assert (caught.value.key or "").endswith("plant_step")
    advised = float(str(caught.value).split("plant_step = ")[1])
    assert timing(0.001, advised).steps == 27
    with pytest.raises(InputError, match="whole number of control periods"):
        plant_system(
            run_own_code(FILES["kiln"]).names,
            "kiln",
            [pid("heat", "chamber", "power")],
            [Actuator("power", delay=0.03)],
            control_period=PERIOD,
        )
