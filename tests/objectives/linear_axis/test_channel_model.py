"""The channel model against published transfer functions, the laws as sampled, and an axis flown period by period."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from objectives.design.frequency import actuator_response
from objectives.linear_axis.channel_model import (
    MODELLED,
    OUTPUTS,
    WITH_SECTOR,
    AxisLoop,
    Factors,
    RotorLag,
    StateSpace,
    TiltLoop,
    closed_loop,
    controller,
    is_stable,
    sector,
)
from plant.law_registry import LAWS
from plant.laws import hybrid, ladrc, pid
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.seeds import generator
from tests.objectives.linear_axis.cases import HYBRID, LADRC, PID, ROTORS, transfer
from tests.plant.axis import continuous_feedback, defaults

FREQUENCIES = [0.03, 0.4, 2.0, 9.0, 60.0, 400.0]
KP, KD, WO = 16.0, 6.4, 15.0
B1, B2, B3 = 3 * WO, 3 * WO**2, WO**3
GAINS = ladrc.Gains(omega_c=4.0, zeta=0.8, omega_o=WO)


def feedback(model: StateSpace, s: complex, known: complex = 1.0) -> complex:
    """-u/y where the law knows that share of its own command."""
    _, y, v, own = model.at(np.array([s]))[0, 0]
    return complex(-(y + s * v) / (1.0 - own * known))


@pytest.mark.parametrize("omega", FREQUENCIES)
def test_ladrc_on_estimates_is_the_published_transfer_function(omega: float) -> None:
    """T4: C_fb = ((kp b1 + kd b2 + b3) s^2 + (kp b2 + kd b3) s + kp b3)/(s (s^2 + (b1 + kd) s + b2 + kd b1 + kp))."""
    s = 1j * omega
    top = (KP * B1 + KD * B2 + B3) * s**2 + (KP * B2 + KD * B3) * s + KP * B3
    expected = top / (s * (s**2 + (B1 + KD) * s + B2 + KD * B1 + KP))
    assert abs(feedback(ladrc_model(True), s) / expected - 1.0) < 1e-12


@pytest.mark.parametrize("omega", FREQUENCIES)
def test_prefilter_of_ladrc_on_estimates(omega: float) -> None:
    """u = C_fb (F r - y): F = kp (s + wo)^3/numerator of C_fb; facts 2.3."""
    s = 1j * omega
    top = (KP * B1 + KD * B2 + B3) * s**2 + (KP * B2 + KD * B3) * s + KP * B3
    r, _, _, own = ladrc_model(True).at(np.array([s]))[0, 0]
    expected = KP * (s + WO) ** 3 / top * feedback(ladrc_model(True), s)
    assert abs(r / (1.0 - own) / expected - 1.0) < 1e-12


@pytest.mark.parametrize("lag", [0.0, 0.02])
@pytest.mark.parametrize("omega", FREQUENCIES)
def test_ladrc_on_measured_rate_and_known_lag(omega: float, lag: float) -> None:
    """C = (Q s^2 + kd s + kp)/(1 - Q G_a), Q = b3/(s + wo)^3; facts 2.3."""
    s = 1j * omega
    known = 1.0 / (lag * s + 1.0)
    q = B3 / (s + WO) ** 3
    expected = (q * s**2 + KD * s + KP) / (1.0 - q * known)
    # 1 - Q cancels to 3 s/wo at low frequency: 1e-12 of 1 is 2e-10 of it at s = 0.03j.
    assert abs(feedback(ladrc_model(False), s, known) / expected - 1.0) < 1e-12 / min(1.0, abs(1.0 - q * known))


def ladrc_model(from_observer: bool) -> StateSpace:
    return controller("ladrc", GAINS, from_observer)


@pytest.mark.parametrize("from_observer", [False, True])
@pytest.mark.parametrize("name", sorted(MODELLED))
@pytest.mark.parametrize("omega", [0.3, 3.0, 30.0])
def test_models_are_the_sampled_laws_in_the_limit(name: str, from_observer: bool, omega: float) -> None:
    """The law as it flies, linearised at ever shorter periods. The sliding term is taken at k1 = 0: k2 alone."""
    law = LAWS[name]
    gains = defaults(law, "attitude")
    if name in WITH_SECTOR:
        gains = gains._replace(k1=0.0)
    found = feedback(controller(name, gains, from_observer), 1j * omega)
    # Extrapolated from h = 1e-4: error of order (omega h)^2; a law that differences y has one of order h omega/2 in that part.
    assert found == pytest.approx(continuous_feedback(law, gains, from_observer, 1j * omega), rel=3e-4)


def test_pid_without_integral_has_no_state_for_it() -> None:
    gains = pid.Gains(60.0, 0.0, 14.0, 0.005)
    assert len(controller("pid", gains, False).a) == 1
    assert is_stable(closed_loop(replace(PID, gains=gains)).a)
    s = np.array([2j])
    _, y, v, _ = controller("pid", gains, False).at(s)[0, 0]
    assert -(y + s[0] * v) == pytest.approx(60.0 + 14.0 * 2j / (1.0 + 0.005 * 2j), rel=1e-12)


@pytest.mark.parametrize("name", sorted(WITH_SECTOR))
def test_the_sliding_variable_and_what_it_adds(name: str) -> None:
    """phi enters the command with a minus, S = y' + lambda (y - r): with phi = k S the law is the one with k2 + k."""
    loop = closed_loop(AxisLoop(name, HYBRID.gains, ROTORS))
    a, b, s = loop.channel("power", "sliding")
    stronger = closed_loop(AxisLoop(name, HYBRID.gains._replace(k2=HYBRID.gains.k2 + 4.0), ROTORS))
    np.testing.assert_allclose(a + 4.0 * b @ s, stronger.a, rtol=1e-12)
    for output, factor in (("value", HYBRID.gains.lambda_), ("rate", 1.0)):
        alone = np.zeros(len(a))
        alone[OUTPUTS.index(output)] = 1.0
        assert (s @ alone).item() == pytest.approx(factor)


def test_sector_is_the_largest_secant() -> None:
    gains = hybrid.Gains(10.0, 5.0, 3.0, 2.0, 0.16)
    constants = hybrid.LAW.prepare(gains, 0.004)
    s = np.geomspace(1e-3, 10.0, 20001)
    secants = np.array([hybrid.sliding_term(x, constants) / x for x in s.tolist()]) - gains.k2
    # The secant falls with half a power of S on one side of its peak: 2.3e-4 over one step of the grid.
    assert sector(AxisLoop("hybrid", gains, ROTORS)) == pytest.approx(float(secants.max(axis=0)), rel=2.3e-4)
    assert sector(AxisLoop("hybrid", gains, ROTORS)) >= secants.max(axis=0)
    assert sector(LADRC) == 0.0


@pytest.mark.parametrize(("order", "power"), [(1, 3), (2, 5)])
def test_dead_time_is_right_to_its_order(order: int, power: int) -> None:
    """A Pade approximant of order n has the phase to (w T)^(2n + 1): halving w divides the error by that power of two."""
    rotors = RotorLag(0.02, 0.006, True, order)
    model = rotors.model(Factors())
    errors = []
    for omega in (80.0, 40.0):
        s = 1j * omega
        exact = np.exp(-0.006 * s) / (0.02 * s + 1.0)
        delivered, known = model.at(np.array([s]))[0, :, 0]
        assert delivered == pytest.approx(known, rel=1e-12)
        errors.append(abs(delivered - exact) / abs(exact))
    assert math.log2(errors[0] / errors[1]) == pytest.approx(power, abs=0.1)


def test_true_and_modelled_lag_are_two_things() -> None:
    s = np.array([30j])
    dead = RotorLag(1e-9, 0.006, False).model(Factors()).at(s)[0, 1, 0]
    delivered, known = RotorLag(0.02, 0.006).model(Factors(lag=1.5)).at(s)[0, :, 0]
    assert delivered == pytest.approx(dead / (0.03 * s[0] + 1.0), rel=1e-9)
    assert known == pytest.approx(dead / (0.02 * s[0] + 1.0), rel=1e-9)
    delivered, known = RotorLag(0.02, 0.006, lag_aware=False).model(Factors()).at(s)[0, :, 0]
    assert known == pytest.approx(dead, rel=1e-9)
    assert delivered == pytest.approx(dead / (0.02 * s[0] + 1.0), rel=1e-9)
    assert RotorLag(0.02, 0.0).model(Factors()).at(s)[0, 0, 0] == pytest.approx(1.0 / (0.02 * s[0] + 1.0), rel=1e-12)


@pytest.mark.parametrize("lag_aware", [True, False])
def test_lead_and_low_pass_of_yaw(lag_aware: bool) -> None:
    """The law knows what passed the low-pass, with the lag if it is aware of it, and nothing of the lead."""
    s = np.array([30j])
    rotors = RotorLag(0.02, 0.006, lag_aware, lead=0.6, smoothing=0.5)
    delivered, known = rotors.model(Factors(lag=1.5)).at(s)[0, :, 0]
    asked = RotorLag(0.02, 0.006, lag_aware).model(Factors()).at(s)[0, 1, 0] / (0.5 * s[0] + 1.0)
    dead = asked * (0.02 * s[0] + 1.0) if lag_aware else asked
    assert known == pytest.approx(asked, rel=1e-12)
    assert delivered == pytest.approx(dead * (0.6 * s[0] + 1.0) / (0.03 * s[0] + 1.0), rel=1e-12)
    exact = np.stack(actuator_response(rotors, s))[:, 0]
    fine = RotorLag(0.02, 0.006, lag_aware, 2, 0.6, 0.5).model(Factors()).at(s)[0, :, 0]
    np.testing.assert_allclose(exact, fine, rtol=1e-6)


@pytest.mark.parametrize("axis", [LADRC, PID, HYBRID], ids=lambda axis: axis.law)
def test_closed_loop_by_hand(axis: AxisLoop) -> None:
    """y = (G/m K_r r + w)/(s^2 (1 - K_e G_k) + ...): the feedback equations solved at one frequency."""
    factors = Factors(inertia=1.3, lag=0.8)
    s = 7j
    delivered, known = ROTORS.model(factors).at(np.array([s]))[0, :, 0]
    r, y, v, own = controller(axis.law, axis.gains, False).at(np.array([s]))[0, 0]
    plant = delivered / (1.3 * s**2)
    command = np.array([r, (y + s * v) / s**2]) / (1.0 - own * known - (y + s * v) * plant)
    loop = closed_loop(axis, factors)
    assert transfer(loop.channel("reference", "command"), s) + command_feedthrough(axis) == pytest.approx(command[0])
    assert transfer(loop.channel("reference", "value"), s) == pytest.approx(plant * command[0])
    assert transfer(loop.channel("disturbance", "command"), s) == pytest.approx(command[1])
    assert transfer(loop.channel("disturbance", "rate"), s) == pytest.approx(s * (plant * command[1] + 1.0 / s**2))


def command_feedthrough(axis: AxisLoop) -> float:
    return float(controller(axis.law, axis.gains, False).d[0, 0])


def test_mass_scales_a_position_axis_and_inertia_an_attitude_axis() -> None:
    heavy, position = Factors(mass=2.0), replace(LADRC, loop="position")
    np.testing.assert_array_equal(closed_loop(LADRC, heavy).a, closed_loop(LADRC).a)
    np.testing.assert_array_equal(closed_loop(position, Factors(inertia=2.0)).a, closed_loop(LADRC).a)
    np.testing.assert_array_equal(closed_loop(position, heavy).a, closed_loop(LADRC, Factors(inertia=2.0)).a)


@pytest.mark.parametrize("lag_aware", [True, False])
def test_the_attitude_loop_as_an_actuator(lag_aware: bool) -> None:
    tilt = TiltLoop(LADRC, lag_aware)
    s = 3j
    delivered, known = tilt.model(Factors()).at(np.array([s]))[0, :, 0]
    angle = transfer(closed_loop(LADRC).channel("reference", "value"), s)
    assert delivered == pytest.approx(angle, rel=1e-12)
    assert known == pytest.approx(angle if lag_aware else 1.0, rel=1e-12)
    outer = AxisLoop("ladrc", ladrc.Gains(1.0, 1.0, 3.0), tilt, "position")
    heavy = closed_loop(outer, Factors(mass=1.2, inertia=0.8))
    assert len(heavy.a) == 2 + 8 + 3
    assert is_stable(heavy.a)


def fly(law: Any, gains: Any, rotors: RotorLag, h: float, duration: float) -> np.ndarray:
    """y(t) at each period under a unit disturbance from t = 0; the law as sampled, the axis exact, delay whole periods."""
    constants = law.prepare(gains, h)
    channel, measured = Channel(1.0, 0.0), Measured(0.0, 0.0)
    memory = law.start(constants, measured, 0.0)
    wait = round(rotors.delay / h)
    waiting = [0.0] * wait
    e = math.exp(-h / rotors.lag)
    m = np.array(
        [[0.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 1.0], [0.0, 0.0, -1.0 / rotors.lag, 1.0 / rotors.lag, 0.0]]
    )
    step = expm(h * np.vstack([m, np.zeros((2, 5))]))
    x, applied, values = np.zeros(3), Applied(0.0, 0.0), []
    for _ in range(round(duration / h)):
        command, memory = law.step(
            memory, constants, channel, Setpoint(0.0, 0.0, 0.0), Measured(x[0], x[1]), applied, h
        )
        waiting.append(command)
        held = waiting.pop(0)
        values.append(x[0])
        mean = held + (x[2] - held) * rotors.lag / h * (1.0 - e)
        applied = Applied(mean if rotors.lag_aware else held, 0.0)
        x = (step @ np.append(x, [held, 1.0]))[:3]
    return np.array(values)


@pytest.mark.parametrize("lag_aware", [True, False])
@pytest.mark.parametrize("name", ["pid", "ladrc", "hybrid"])
def test_the_loop_is_that_of_the_law_as_sampled(name: str, lag_aware: bool) -> None:
    """At a short period: response to a step of the disturbance, flown by the law's own step, and from the matrices."""
    law, h, duration = LAWS[name], 2.5e-4, 1.5
    gains = defaults(law, "attitude")
    gains = gains._replace(k1=0.0) if name == "hybrid" else gains
    rotors = RotorLag(0.02, 0.004, lag_aware, order=2)
    flown = fly(law, gains, rotors, h, duration)
    model = RotorLag(0.02, 0.004 + 0.5 * h, lag_aware, order=2)
    a, b, c = closed_loop(AxisLoop(name, gains, model)).channel("disturbance", "value")
    n = len(a)
    step = expm(h * np.block([[a, b], [np.zeros((1, n + 1))]]))
    x, expected = np.append(np.zeros(n), 1.0), []
    for _ in flown:
        expected.append((c @ x[:n]).item())
        x = step @ x
    # What is left of sampling is of order h: some h/0.1 s of the peak.
    np.testing.assert_allclose(flown, expected, atol=4e-3 * np.abs(flown).max(axis=0), rtol=0.0)


def test_stability_has_an_edge() -> None:
    assert is_stable(np.diag([-1.0, -2.0]))
    assert not is_stable(np.diag([0.0, -2.0]))
    assert not is_stable(np.diag([-1e-12, -2.0]))
    rng = generator(1, "tests/stability", 0)
    a = rng.standard_normal((5, 5))
    shift = np.linalg.eigvals(a).real.max(axis=0)
    assert is_stable(a - (shift + 0.01) * np.eye(5))
    assert not is_stable(a - (shift - 0.01) * np.eye(5))
