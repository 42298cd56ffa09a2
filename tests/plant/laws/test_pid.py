"""PID: the paper's straw man, the transfer function, and what anti-windup does to the integral."""

from math import exp, log

import numpy as np
import pytest

from plant.laws import pid
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.pid import LAW, Gains
from tests.plant.axis import REST, Axis, H, continuous_feedback, linearised

STRAW_MAN = Gains(kp=2.0, ki=0.0, kd=5.0, t_f=0.0)


def closed_loop_poles(h: float) -> list[float]:
    """The two poles near 0 of the straw man on a sampled double integrator, mapped back to continuous time."""
    law = linearised(LAW, STRAW_MAN, Channel(1.0, 0.0), h)
    y, v = law.b[:, 3], law.b[:, 4]
    plant, push = np.array([[1.0, h], [0.0, 1.0]]), np.array([h * h / 2.0, h])
    matrix = np.block(
        [
            [plant + np.outer(push, law.d[3:5]), np.outer(push, law.c)],
            [np.stack([y, v], axis=1), law.a],
        ]
    )
    poles = np.linalg.eigvals(matrix)
    return sorted((log(pole) / h for pole in poles.real.tolist() if 0.5 < pole < 1.0 - 1e-9), reverse=True)


def test_straw_man_has_the_poles_of_its_polynomial() -> None:
    # T5: s^2 + 5 s + 2. The hold acts as half a period of delay, which moves a pole by order h; extrapolated from two
    # periods, by h^2.
    coarse, fine = (np.array(closed_loop_poles(h)) for h in (1e-3, 5e-4))
    np.testing.assert_allclose(2.0 * fine - coarse, [-0.4384, -4.5616], atol=1e-4)


def test_straw_man_settles_in_nine_seconds() -> None:
    """Its slow pole stays outside 2 % of a step until ln(4.5616/(0.02 4.1231))/0.4384 = 9.15 s."""
    flown = Axis().fly(LAW, STRAW_MAN, round(15.0 / H), lambda t: Setpoint(1.0, 0.0, 0.0))
    outside = np.nonzero(np.abs(flown.value - 1.0) > 0.02)[0]
    assert outside[-1] * H == pytest.approx(log(4.5616 / (0.02 * 4.1231)) / 0.4384, abs=0.02)
    assert flown.value.max(axis=0) <= 1.0


@pytest.mark.parametrize("omega", [0.1, 1.0, 10.0, 100.0])
@pytest.mark.parametrize("from_observer", [False, True])
def test_transfer_function_is_the_textbook_one(omega: float, from_observer: bool) -> None:
    """C(s) = kp + ki/s + kd s/(Tf s + 1), whether the rate is measured or differenced."""
    s, gains = 1j * omega, Gains(60.0, 80.0, 14.0, 0.02)
    expected = 60.0 + 80.0 / s + 14.0 * s / (0.02 * s + 1.0)
    # Extrapolated from h = 1e-4: error of order (omega h)^2 and (h/Tf)^2.
    assert continuous_feedback(LAW, gains, from_observer, s) == pytest.approx(expected, rel=1e-3)


def test_integral_of_a_loop_held_at_its_limit_stops_at_the_limit() -> None:
    """With e held and the command clipped at a, I' = ki e + (ki/kp)(a - kp e - I) rests at I = a: no windup however long."""
    gains, limit, error = Gains(2.5, 0.6, 2.6, 0.01), 0.8, 4.0
    constants = LAW.prepare(gains, H)
    memory, excess = LAW.start(constants, Measured(0.0, 0.0), 0.0), 0.0
    for _ in range(round(100.0 / H)):
        goal, applied = Setpoint(error, 0.0, 0.0), Applied(limit, excess)
        asked, memory = LAW.step(memory, constants, Channel(1.0, 0.0), goal, Measured(0.0, 0.0), applied, H)
        excess = min(asked, limit) - asked
    # One period of the integral itself is in the memory: h ki e, and the rest decays at ki/kp = 0.24 1/s.
    assert memory.integral == pytest.approx(limit, abs=1.1 * H * gains.ki * error)


def test_filter_passes_a_constant_rate_and_lags_a_step_by_its_time_constant() -> None:
    constants = LAW.prepare(Gains(1.0, 0.0, 1.0, 0.05), H)
    memory = pid.Memory(0.0, 0.0, 0.0)
    for _ in range(round(0.1 / H)):
        _, memory = LAW.step(memory, constants, Channel(1.0, 0.0), REST, Measured(0.0, 1.0), Applied(0.0, 0.0), H)
    assert memory.rate == pytest.approx(1.0 - exp(-0.1 / 0.05), rel=1e-12)
