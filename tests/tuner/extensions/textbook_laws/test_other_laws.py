"""First-order ADRC, reference model, Smith predictor and lead-lag against closed forms and against loops without dead time."""

import numpy as np
import pytest

from objectives.margins.plant_margins import PlantMargins
from plant.law_registry import LAWS
from plant.laws.channel import Channel
from plant.model.plan import Actuator
from plant.model.signals import Step
from tests.objectives.margins.test_plant_margin_control import check, single_loop
from tests.plant.axis import continuous_feedback, linearised
from tests.tuner.extensions.textbook_laws.loops import answer, loop_of, row_of, with_actuator

ADRC = LAWS["adrc1"]


def test_the_observer_of_first_order_adrc_has_both_poles_where_they_are_placed():
    """The command changes nothing of an estimate's error, so its poles are those of the memory without what is delivered."""
    matrices = linearised(ADRC, ADRC.Gains(4.0, 40.0), Channel(1.0, 1.0), 0.01)
    np.testing.assert_allclose(np.poly(matrices.a), np.poly([np.exp(-0.4)] * 2), atol=1e-12)


@pytest.mark.parametrize("omega", [0.1, 1.0, 10.0, 100.0])
def test_first_order_adrc_has_the_printed_transfer_function(omega):
    """Herbst, Control Theory and Technology 19 (2021), table 1: ((kp l1 + l2) s + kp l2)/(s (s + l1 + kp)), l1 = 2 wo, l2 = wo^2."""
    s, kp, l1, l2 = 1j * omega, 4.0, 80.0, 1600.0
    printed = ((kp * l1 + l2) * s + kp * l2) / (s * (s + l1 + kp))
    assert continuous_feedback(ADRC, ADRC.Gains(4.0, 40.0), True, s) == pytest.approx(printed, rel=1e-3)


def herbst(gain, lag, h=0.005, limits=None):
    """Herbst, Electronics 2013: a plant K/(T s + 1) under ADRC for K = T = 1 that settles in 1 s: kp = 4, observer at -40."""
    return answer(loop_of([gain], [lag, 1.0], "adrc1", h, limits, b0=1.0), 6.0, omega_c=4.0, omega_o=40.0)


def test_first_order_adrc_settles_in_the_time_that_it_was_designed_for():
    nominal = herbst(1.0, 1.0)
    assert nominal.settling() == pytest.approx(1.0, abs=0.1) and nominal.overshoot < 0.5


@pytest.mark.parametrize(("gain", "lag"), [(0.5, 1.0), (2.0, 1.0), (5.0, 1.0), (1.0, 0.5), (1.0, 2.0)])
def test_first_order_adrc_hardly_feels_another_plant(gain, lag):
    """Their figures 5 and 6: the answers for K and T off by factors lie on one another; none overshoots by 5 %, all settle in 2 s."""
    other = herbst(gain, lag)
    assert other.overshoot < 5.0 and other.settling() < 2.0 and other.y[-1] == pytest.approx(1.0, abs=1e-3)


def test_first_order_adrc_does_not_wind_up():
    """An input limited to just what the set point needs twice over: the answer is that of full power, then of the loop."""
    assert herbst(1.0, 1.0, limits=(-1.5, 1.5)).overshoot < 1.0


MODEL = {"omega_m": 1.5, "zeta_m": 0.7, "a2": 1.0, "a1": 0.5, "a0": 0.1}


def second_order_step(t, w, zeta):
    """Answer of w^2/(s^2 + 2 zeta w s + w^2) to a step of 1."""
    damped = w * np.sqrt(1.0 - zeta * zeta)
    return 1.0 - np.exp(-zeta * w * t) * (np.cos(damped * t) + zeta * w / damped * np.sin(damped * t))


@pytest.mark.parametrize(
    "feedback", [{"kp": 0.1, "ki": 0.0, "kd": 0.1}, {"kp": 4.0, "ki": 2.0, "kd": 3.0}], ids=["weak", "strong"]
)
def test_with_the_plant_known_the_answer_is_that_of_the_reference_model(feedback):
    system = loop_of([1.0], [1.0, 0.5, 0.1], "model_following", 0.002)
    flown = answer(system, 8.0, **MODEL, **feedback, t_f=0.0)
    assert np.abs(flown.y - second_order_step(flown.t, 1.5, 0.7)).max(axis=0) < 4e-3


def test_feedback_of_the_reference_model_rejects_a_load_as_pid_does():
    """Without a set point the law is a PID: the same answer to a load, to the last bits."""
    gains = {"kp": 4.0, "ki": 2.0, "kd": 3.0, "t_f": 0.01}
    still, load = Step(0.0, 1.0), Step(0.5, 0.1)
    follows, pid = (
        answer(loop_of([1.0], [1.0, 0.5, 0.1], law, 0.005), 8.0, still, load, **gains, **more)
        for law, more in (("model_following", MODEL), ("pid_parallel", {}))
    )
    np.testing.assert_allclose(follows.y, pid.y, rtol=0.0, atol=1e-12)
    assert np.abs(pid.y).max(axis=0) > 0.05


PI = {"k": 2.0, "t_i": 1.2}


@pytest.mark.parametrize("periods", [0, 1, 7, 8, 40, 64])
def test_a_smith_predictor_answers_as_the_loop_without_dead_time_but_later(periods):
    """The model is sampled exactly, the plant moves by Runge-Kutta steps: 1e-8 apart."""
    h, plant = 0.05, ([0.8], [1.2, 1.0])
    alone = answer(loop_of(*plant, "pid_ideal", h), 8.0, **PI, t_d=0.0)
    late = with_actuator(loop_of(*plant, "smith", h), Actuator("u", delay=periods * h))
    predicted = answer(late, 8.0, **PI, k_m=0.8, t_m=1.2, l_m=periods * h)
    count = len(alone.y)
    np.testing.assert_allclose(predicted.y[periods:count], alone.y[: count - periods], rtol=0.0, atol=1e-6)


def test_margins_of_a_smith_predictor_are_those_of_python_control():
    system = with_actuator(loop_of([0.8], [1.2, 1.0], "smith", 0.05), Actuator("u", delay=0.8))
    gains = row_of(system, **PI, k_m=0.9, t_m=1.1, l_m=0.7)
    model = PlantMargins(system, 0.99 * gains, 1.01 * gains)
    check(single_loop(system, gains), model, model.evaluate(gains[None]), gains, "y")


def test_margins_hold_the_longest_dead_time_of_a_searched_model():
    """The states that only the upper end of a range uses are in the loop."""
    system = with_actuator(loop_of([0.8], [1.2, 1.0], "smith", 0.05), Actuator("u", delay=0.8))
    low, high = (row_of(system, **PI, k_m=0.8, t_m=1.2, l_m=l_m) for l_m in (0.1, 1.6))
    wide, narrow = (PlantMargins(system, *ends).evaluate(high[None]) for ends in ((low, high), (high, high)))
    assert wide.sensitivity.value[0, 0] == pytest.approx(narrow.sensitivity.value[0, 0], rel=1e-6)


def printed_lead_lag(s):
    centre, width = 2.0 * np.pi * 8.0, 2.0 * np.pi * 3.0
    notch = (s * s + centre**2) / (s * s + width * s + centre**2)
    return 45.0 * (1.0 + 1.0 / (2.0 * s)) * (1.0 + s / 3.0) / (1.0 + s / 60.0) * notch


@pytest.mark.parametrize("omega", [0.1, 1.0, 10.0, 40.0, 60.0, 100.0])
def test_a_lead_lag_has_its_printed_transfer_function(omega):
    law = LAWS["lead_lag"]
    found = continuous_feedback(law, law.Gains(45.0, 2.0, 3.0, 60.0, 8.0, 3.0), True, 1j * omega)
    assert found == pytest.approx(printed_lead_lag(1j * omega), rel=2e-3)


def test_a_notch_takes_a_resonance_out_of_the_loop():
    """The proportional part passes nothing of the notch's centre, whatever the period."""
    law = LAWS["lead_lag"]
    matrices = linearised(law, law.Gains(45.0, 0.0, 3.0, 60.0, 8.0, 3.0), Channel(1.0, 1.0), 0.01)
    assert abs(matrices.feedback(2j * np.pi * 8.0, 0.01)) < 1e-9
