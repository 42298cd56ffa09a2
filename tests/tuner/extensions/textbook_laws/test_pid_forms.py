"""Forms of PID against the transfer functions that textbooks print, against one another, and anti-windup by choice."""

import numpy as np
import pytest

from plant.law_registry import LAWS
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from tests.plant.axis import H, continuous_feedback, defaults, random_inputs, run

PARALLEL, IDEAL, SERIES, INCREMENTAL = (LAWS[f"pid_{form}"] for form in ("parallel", "ideal", "series", "incremental"))
RESTED, STILL = Measured(0.0, 0.0), Applied(0.0, 0.0)
PRINTED = {
    "parallel": (
        PARALLEL.Gains(60.0, 80.0, 14.0, 0.02, 1.0, 0.0, 1.0, 0.0),
        lambda s: 60.0 + 80.0 / s + 14.0 * s / (0.02 * s + 1.0),
    ),
    "ideal": (
        IDEAL.Gains(60.0, 0.75, 0.25, 8.0, 1.0, 0.0, 1.0, 0.0),
        lambda s: 60.0 * (1.0 + 1.0 / (0.75 * s) + 0.25 * s / (0.25 / 8.0 * s + 1.0)),
    ),
    "series": (
        SERIES.Gains(40.0, 0.75, 0.3, 6.0, 1.0, 0.0, 1.0, 0.0),
        lambda s: 40.0 * (1.0 + 1.0 / (0.75 * s)) * (0.3 * s + 1.0) / (0.05 * s + 1.0),
    ),
    "incremental": (
        INCREMENTAL.Gains(60.0, 80.0, 14.0, 0.02, 1.0, 0.0),
        lambda s: 60.0 + 80.0 / s + 14.0 * s / (0.02 * s + 1.0),
    ),
}


@pytest.mark.parametrize("omega", [0.1, 1.0, 10.0, 100.0])
@pytest.mark.parametrize("from_observer", [False, True])
@pytest.mark.parametrize("form", PRINTED)
def test_a_form_has_its_printed_transfer_function(form, from_observer, omega):
    gains, printed = PRINTED[form]
    found = continuous_feedback(LAWS[f"pid_{form}"], gains, from_observer, 1j * omega)
    assert found == pytest.approx(printed(1j * omega), rel=2e-3)


@pytest.mark.parametrize("loop", ["attitude", "position"])
def test_increments_add_up_to_the_positional_form(loop):
    """The integral of increments counts the error of the period at hand, that of the positional form does not yet."""
    inputs = [each._replace(applied=STILL) for each in random_inputs(np.random.default_rng(3), 200)]
    gains = defaults(INCREMENTAL, loop)._replace(b=0.4, c=0.7)
    positional = PARALLEL.Gains(*gains, 1.0, 0.0)
    inputs = [inputs[0]._replace(measured=Measured(inputs[0].measured.value, 0.0)), *inputs[1:]]
    summed, _ = run(INCREMENTAL, gains, inputs, Channel(1.0, 1.0))
    direct, _ = run(PARALLEL, positional, inputs, Channel(1.0, 1.0))
    errors = np.array([each.setpoint.value - each.measured.value for each in inputs])
    np.testing.assert_allclose(summed - direct, H * gains.ki * errors, rtol=0.0, atol=1e-8 * np.abs(direct).max(axis=0))


def test_a_step_of_the_set_point_is_weighted_by_b_and_c():
    gains = PARALLEL.Gains(60.0, 80.0, 14.0, 0.02, 0.3, 0.25, 1.0, 0.0)
    constants = PARALLEL.prepare(gains, H)
    memory = PARALLEL.start(constants, Measured(5.0, 0.0), 0.0)
    command, _ = PARALLEL.step(
        memory, constants, Channel(2.0, 0.0), Setpoint(6.0, 0.0, 0.0), Measured(5.0, 0.0), STILL, H
    )
    assert 2.0 * command == pytest.approx(60.0 * 0.3 + 14.0 * 0.25 / (0.02 + H), rel=1e-12)


def integral_after(seconds, limit, **choice):
    """The integral of a loop whose error stays at 4 and whose command a limit holds."""
    gains = defaults(PARALLEL, "position")._replace(kp=2.5, ki=0.6, kd=0.0, **choice)
    constants = PARALLEL.prepare(gains, H)
    memory, excess = PARALLEL.start(constants, RESTED, 0.0), 0.0
    for _ in range(round(seconds / H)):
        asked, memory = PARALLEL.step(
            memory, constants, Channel(1.0, 0.0), Setpoint(4.0, 0.0, 0.0), RESTED, Applied(limit, excess), H
        )
        excess = min(asked, limit) - asked
    return memory.integral


def test_without_anti_windup_the_integral_grows_with_the_error():
    assert integral_after(10.0, 0.8, tracking=0.0, clamping=0.0) == pytest.approx(0.6 * 4.0 * 10.0, rel=1e-9)


def test_clamping_stops_the_integral_one_period_after_the_limit_holds():
    assert integral_after(10.0, 0.8, tracking=0.0, clamping=1.0) == pytest.approx(0.6 * 4.0 * H, rel=1e-12)


@pytest.mark.parametrize("tracking", [0.25, 1.0, 4.0])
def test_back_calculation_rests_where_error_and_lost_command_balance(tracking):
    """I' = ki e + (a - kp e - I)/Tt with Tt = tracking kp/ki: I = a - kp e + tracking kp e."""
    assert integral_after(400.0, 0.8, tracking=tracking, clamping=0.0) == pytest.approx(
        0.8 + (tracking - 1.0) * 2.5 * 4.0, abs=1.1 * H * 0.6 * 4.0
    )


@pytest.mark.parametrize(("error", "grows"), [(1.0, 0.0), (-1.0, -1.0)])
def test_a_clamped_integral_runs_back_when_the_error_turns(error, grows):
    """With b0 below 0 a command held from below is an acceleration held from above: only an error above 0 drives it further."""
    gains = defaults(PARALLEL, "position")._replace(tracking=0.0, clamping=1.0, kd=0.0)
    constants, channel, goal = PARALLEL.prepare(gains, H), Channel(-2.0, 0.0), Setpoint(error, 0.0, 0.0)
    memory = PARALLEL.start(constants, RESTED, 1.0)
    _, after = PARALLEL.step(memory, constants, channel, goal, RESTED, Applied(0.0, 0.3), H)
    assert after.integral == pytest.approx(1.0 + H * gains.ki * grows, rel=1e-12)


def test_increments_are_added_to_the_limited_command():
    gains = defaults(INCREMENTAL, "position")._replace(kd=0.0)
    constants = INCREMENTAL.prepare(gains, H)
    memory = INCREMENTAL.start(constants, RESTED, 3.0)
    command, _ = INCREMENTAL.step(
        memory, constants, Channel(2.0, 0.0), Setpoint(0.0, 0.0, 0.0), RESTED, Applied(1.0, -0.5), H
    )
    assert command == pytest.approx(1.0, rel=1e-12)
