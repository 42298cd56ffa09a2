"""Certificates of plants of one's own: closed forms, python-control, the channel model of quadrotors, and flights as sampled."""

from dataclasses import replace
from math import pi, sqrt, tanh
from typing import Any

import control
import numpy as np
import pytest

from objectives.linear_axis.channel_model import INPUTS, OUTPUTS, AxisLoop, Factors, RotorLag, closed_loop, is_stable
from objectives.margins.plant_margins import PlantMargins
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.plan import Actuator, Channel
from plant.model.scenario import PlantScenario
from plant.quadrotor.scenarios import SEARCH
from tests.plant.model.plants import cascade, pid, stepped, system_of
from tuner.extensions.certificates import circle_criterion
from tuner.extensions.certificates.linear_bound import smallest_sum, with_modes_apart
from tuner.extensions.certificates.peak_gain import disturbed
from tuner.extensions.certificates.plant_axis import PlantAxis

MOTOR = (10.0, 10.0, 0.2, 0.001)


def body(channels, actuators, timing, inertia=1.0):
    """A pendulum without weight and friction: a double integrator under torque and push."""
    system = system_of("pendulum", channels, actuators, timing)
    free = system.plant.Parameters(inertia=inertia, friction=0.0, weight=0.0, start=0.0)
    object.__setattr__(system, "parameters", free)
    return system


def motor():
    actuator = Actuator("voltage", -12.0, 12.0, delay=0.001, lag=0.001)
    return system_of("dc_motor", [pid("angle", "angle", "voltage", limit=10.0)], [actuator], Timing(0.001, 0.0005))


def impulse(loop, t):
    """Response at times (t,) to an impulse of the disturbance, by modes."""
    poles, modes = np.linalg.eig(loop.a)
    residues = (loop.c @ modes)[0] * np.linalg.solve(modes, loop.d)[:, 0]
    return (residues * np.exp(np.outer(t, poles))).sum(axis=1).real


def exact(loop, times):
    """Peak gain: the L1 norm of the impulse response."""
    return float(np.trapezoid(np.abs(impulse(loop, times)), times))


@pytest.mark.parametrize(("damping", "inertia"), [(0.3, 1.0), (0.7, 0.02)])
def test_the_bound_of_a_second_order_loop_lies_close_above_its_closed_form(damping, inertia):
    """PD on a free body: the L1 norm from force to angle is coth(pi zeta/(2 sqrt(1 - zeta^2)))/(J wn^2)."""
    wn, h = 3.0, 1e-4
    channel = Channel("angle", LAWS["pid"], "angle", "torque", b0=1.0 / inertia, rate_output="speed")
    row = (wn**2, 0.0, 2.0 * damping * wn, 1e-4)
    axis = PlantAxis(body([channel], [], Timing(h, h), inertia), row, "angle", "push")
    closed_form = 1.0 / (inertia * wn**2 * tanh(pi * damping / (2.0 * sqrt(1.0 - damping**2))))
    loop = disturbed(axis)
    # The filter of the derivative, no faster than 0.5 ms, and the hold take from the damping.
    assert exact(loop, np.linspace(0.0, 15.0, 60_001)) == pytest.approx(closed_form, rel=0.01)
    assert closed_form < smallest_sum(loop) < 1.6 * closed_form


def variable() -> Any:
    """The variable of transfer functions."""
    return control.tf("s")


def test_the_motor_is_that_of_python_control():
    """From load torque to angle, put together from transfer functions; the drive's way by `control.pade`."""
    system, s = motor(), variable()
    p = system.parameters
    late = control.tf(*control.pade(0.0015, 2)) / (0.001 * s + 1.0)
    kp, ki, kd, t_f = MOTOR
    law = kp + ki / s + kd * s / (t_f * s + 1.0)
    shaft = 1.0 / (p.inertia * s**2 + (p.friction + p.constant**2 / p.resistance) * s)
    whole = shaft / (1.0 + shaft * p.constant / p.resistance * late * law)
    loop = closed_loop(PlantAxis(system, MOTOR, "angle", "torque"))
    w = np.geomspace(0.01, 3000.0, 40)
    np.testing.assert_allclose(loop.at(1j * w)[:, 0, 1], whole(1j * w), rtol=1e-6)


@pytest.mark.parametrize(("law", "gains"), [("ladrc", (6.0, 1.0, 10.0)), ("hybrid", (10.0, 5.0, 6.0, 5.0, 0.1))])
def test_a_free_body_is_the_double_integrator_of_quadrotors(law, gains):
    h, b0 = 0.004, 50.0
    channel = Channel("angle", LAWS[law], "angle", "torque", b0=b0, rate_output="speed")
    system = body([channel], [Actuator("torque", delay=h, lag=0.02)], Timing(h, h), 1.0 / b0)
    plant = PlantAxis(system, gains, "angle", "push")
    theirs = AxisLoop(law, LAWS[law].Gains(*gains), RotorLag(0.02, 1.5 * h, lag_aware=False, order=2))
    s = 1j * np.geomspace(0.1, 300.0, 20)
    mine, reference = closed_loop(plant).at(s), closed_loop(theirs).at(s)
    # A push of one N m is an acceleration of b0, and a command is in N m.
    mine[:, :, INPUTS.index("disturbance")] /= b0
    mine[:, OUTPUTS.index("command")] *= b0
    np.testing.assert_allclose(mine, reference, rtol=1e-8, atol=1e-10)
    assert plant.gain == pytest.approx(1.0)
    if law == "hybrid":
        kept = [circle_criterion.run(axis).value for axis in (plant, theirs)]
        assert kept[0] == pytest.approx(kept[1], rel=1e-3)


def test_an_outer_channel_acts_through_the_inner_one():
    """Angle over speed of the free body: the outer loop closed around the inner one, from transfer functions."""
    h, s = 0.002, variable()
    channels = [pid("angle", "angle", "speed"), pid("speed", "speed", "torque")]
    system = body(channels, [Actuator("torque", lag=0.004)], Timing(h, h), 0.02)
    outer, inner = (4.0, 1.0, 0.0, 0.01), (0.5, 2.0, 0.0, 0.01)
    loop = closed_loop(PlantAxis(system, (*outer, *inner), "angle", "push"))
    late, around = control.tf(*control.pade(0.5 * h, 2)) / (0.004 * s + 1.0), 1.0 / (0.02 * s)
    speed_law, angle_law = inner[0] + inner[1] / s, outer[0] + outer[1] / s
    force = around / (1.0 + around * late * speed_law)
    goal = late * speed_law * force
    whole = force / s / (1.0 + goal * angle_law / s)
    w = np.geomspace(0.05, 500.0, 30)
    np.testing.assert_allclose(loop.at(1j * w)[:, 0, 1], whole(1j * w), rtol=1e-6)


def test_no_flight_as_sampled_leaves_the_bound_and_the_worst_comes_near():
    """The sign of the impulse response run backwards is the worst torque there is."""
    system, size = motor(), 0.01
    axis = PlantAxis(system, MOTOR, "angle", "torque")
    loop = disturbed(axis)
    bound, h = smallest_sum(loop), system.timing.control_period
    assert bound is not None
    t = h * np.arange(1500)
    drawn = system.sample(PlantScenario("worst", 1.5), 1, SEARCH, range(1))
    worst = size * np.sign(impulse(loop, t)[::-1])
    pushed = replace(drawn, disturbances=worst[None, :, None, None])
    body, _ = stepped(system, np.array(MOTOR), pushed)
    reached = np.abs(body[:, 0]).max(axis=0)
    assert 0.9 * size * exact(loop, np.linspace(0.0, 1.5, 30_001)) < reached < size * bound
    assert bound < 1.5 * exact(loop, np.linspace(0.0, 30.0, 300_001))


def test_slow_modes_apart_add_up_to_the_loop():
    loop = disturbed(PlantAxis(motor(), MOTOR, "angle", "torque"))
    t = np.linspace(0.0, 2.0, 500)
    parts = list(with_modes_apart(loop))
    assert len(parts) > 1
    (none, whole), (apart, rest) = parts[:2]
    gone = impulse(whole, t) - impulse(rest, t)
    slowest = np.linalg.eigvals(loop.a).real.max(axis=0)
    assert none == 0.0
    np.testing.assert_allclose(gone, gone[0] * np.exp(slowest * t), rtol=1e-6, atol=1e-9 * abs(gone[0]))
    assert apart == pytest.approx(abs(gone[0] / slowest), rel=1e-8)


def test_what_no_output_feels_is_left_out():
    """Under speed control alone nobody asks where the shaft stands, whose angle drifts."""
    system = body([pid("speed", "speed", "torque")], [], Timing(0.002, 0.002))
    assert is_stable(PlantAxis(system, (0.5, 2.0, 0.0, 0.01), "speed", "push").closed(Factors()).a)


def test_the_assumption_that_fails_is_named():
    row = np.ones(7)
    assert "several rates" in PlantAxis(cascade(), tuple(row), "angle", "push").refused(1.5)
    wild = Channel("angle", LAWS["supertwisting"], "angle", "torque", rate_output="speed")
    single = body([wild], [], Timing(0.002, 0.002))
    assert "no continuous form" in PlantAxis(single, (5.0, 2.0, 2.0), "angle", "push").refused(1.5)
    both = body(
        [pid("angle", "angle", "torque"), Channel("other", LAWS["hybrid"], "angle", "torque")],
        [],
        Timing(0.002, 0.002),
    )
    mixed = PlantAxis(both, (20.0, 1.0, 5.0, 0.01, 10.0, 5.0, 6.0, 5.0, 0.1), "angle", "push")
    assert "'other' acts on it" in mixed.refused(1.5)
    axis = PlantAxis(motor(), MOTOR, "angle", "torque")
    assert "not stable" in axis.refused(np.inf)
    sampled = PlantMargins(motor(), np.array(MOTOR), np.array(MOTOR)).evaluate(np.array([MOTOR]))
    assert axis.refused(float(sampled.sensitivity.value[0, 0])) == ""
    assert "too far apart" in axis.refused(1.5 * float(sampled.sensitivity.value[0, 0]))
