"""Metrics of a step against closed forms, and against python-control's step_info on the same answers."""

from typing import Any

import control
import numpy as np
import pytest

from tests.objectives.flying import fly, score, target, targets
from tests.tuner.conftest import QUICKSTART
from tests.tuner.extensions.textbook_laws.loops import answer, loop_of
from tuner.analysis.judged_metrics import shown_metrics
from tuner.api.studies import load_study
from tuner.study.plant_study import PlantStudy

H = 0.002


def stepped(t0, duration, response, h=H):
    """A function that judges an axis by a metric: it steps from 0 to 1 at t0 and answers by response(t - t0)."""
    aims = targets(x=target(0.0, 1.0, time=t0))
    flown = fly({"x": lambda t: (float(t >= t0), response(t - t0) if t >= t0 else 0.0)}, aims, duration, h)
    return lambda name: score(f"{name}.x", flown, aims, duration, h)


def judged(name, t0, duration, response):
    """A metric of such an axis."""
    return stepped(t0, duration, response)(name)


@pytest.mark.parametrize("t0", [0.0, 3.0])
def test_the_itae_of_a_first_order_step_is_the_square_of_its_time_constant(t0):
    """The integral of t e^(-t/T) is T^2, whenever the step comes."""
    assert judged("step_itae", t0, 18.0, lambda t: 1.0 - np.exp(-t / 0.8)) == pytest.approx(0.64, rel=1e-5)


def test_the_integrals_of_an_axis_are_those_of_textbooks():
    """The integral of e^(-t/T) is T, that of its square T/2."""
    duration, aims = 12.0, targets(x=target(0.0, 1.0))
    flown = fly({"x": lambda t: (1.0, 1.0 - np.exp(-t / 0.8))}, aims, duration, H)
    assert score("iae.x", flown, aims, duration, H) == pytest.approx(0.8, rel=2e-3)
    assert score("ise.x", flown, aims, duration, H) == pytest.approx(0.4, rel=3e-3)


def test_a_steady_error_hides_no_overshoot_past_the_final_value():
    """k/(s^2 + 2 d s + 1) settles at k and goes past it by exp(-pi d/sqrt(1 - d^2)), set point or not."""
    d, k = 0.28, 0.94
    w = np.sqrt(1.0 - d * d)

    def response(t):
        return k * (1.0 - np.exp(-d * t) * (np.cos(w * t) + d / w * np.sin(w * t)))

    share = 100.0 * np.exp(-np.pi * d / w)
    # Samples of 10 ms miss the peak by 0.001 %, and 44 s leave e^(-12) of the oscillation.
    found = stepped(1.0, 45.0, response, 0.01)
    assert found("final_overshoot") == pytest.approx(share, abs=0.01)
    assert found("overshoot") == pytest.approx(k * (100.0 + share) - 100.0, abs=0.01)


def test_it_is_what_step_info_of_the_same_answer_gives():
    h = 0.01
    flown = answer(loop_of([1.0], [1.0, 0.6, 1.0], "pid_parallel", h), 30.0, kp=9.0, ki=0.0, kd=0.5, t_f=0.0)
    info: Any = control.step_info(flown.y, flown.t)
    duration = h * (len(flown.t) - 1)
    y = stepped(0.0, duration + h, lambda t: flown.y[round(t / h)], h)("final_overshoot")
    assert info["Overshoot"] > 20.0 and y == pytest.approx(info["Overshoot"], rel=1e-9)


def test_a_step_that_goes_nowhere_counts_by_a_tenth_of_the_step():
    assert judged("final_overshoot", 0.0, 4.0, lambda t: 0.3 if t < 2.0 else 0.0) == pytest.approx(300.0)


def test_flights_show_it_where_the_study_names_it():
    motor = str(QUICKSTART.with_name("dc_motor.toml"))
    study = load_study(motor, {"objective.0.metric": "step_itae.angle"}, kind=PlantStudy)
    spec = study.scenarios[0].spec
    shown = [each.text for each in shown_metrics(study.system, spec, study.judged_metrics)]
    assert "step_itae.angle" in shown and "final_overshoot.angle" not in shown
    assert "step_itae.angle" not in [each.text for each in shown_metrics(study.system, spec)]
