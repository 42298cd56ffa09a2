"""Examples that textbooks and manuals print, flown and judged: overshoot, settling, margins, peaks."""

import numpy as np
import pytest

from objectives.margins.plant_margins import PlantMargins
from tests.tuner.extensions.textbook_laws.loops import answer, loop_of, row_of

MOTOR = [0.01], [0.005, 0.06, 0.1001]
CRUISE = [1.0], [1000.0, 50.0]
PITCH = [1.151, 0.1774], [1.0, 0.739, 0.921, 0.0]
THIRD_ORDER = [1.0], [1.0, 3.0, 3.0, 1.0]
FOUR_LAGS = [1.0], np.polymul(np.polymul([1.0, 1.0], [0.2, 1.0]), np.polymul([0.04, 1.0], [0.008, 1.0])).tolist()


def margins_of(system, **gains):
    row = row_of(system, **gains)
    return PlantMargins(system, 0.99 * row, 1.01 * row).evaluate(row[None])


@pytest.mark.parametrize(("c", "overshoot"), [(1.0, 1.0), (0.0, 11.6)], ids=["D on the error", "D on the measurement"])
def test_the_speed_of_a_motor_overshoots_as_the_control_tutorials_print_it(c, overshoot):
    """Control Tutorials for MATLAB and Simulink, DC motor speed: kp = 100, ki = 200, kd = 10."""
    system = loop_of(*MOTOR, "pid_parallel", 0.002)
    assert answer(system, 4.0, kp=100.0, ki=200.0, kd=10.0, t_f=0.0, c=c).overshoot == pytest.approx(
        overshoot, abs=0.05
    )


def test_a_cruise_control_that_cancels_the_pole_answers_as_one_lag():
    """Control Tutorials, cruise: 1/(1000 s + 50) under 800 + 40/s is 0.8/s, a lag of 1.25 s: ln 9 of it from 10 to 90 %."""
    system = loop_of(*CRUISE, "pid_parallel", 0.01)
    flown = answer(system, 15.0, kp=800.0, ki=40.0, kd=0.0, t_f=0.0)
    assert flown.rise == pytest.approx(1.25 * np.log(9.0), abs=0.02)
    assert flown.settling() == pytest.approx(1.25 * np.log(50.0), abs=0.02)
    assert flown.overshoot == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("kp", "ki", "kd"), [(9.0, 0.0, 4.0), (1.74 * 2.98, 1.74, 1.74 * 1.716)], ids=["PD", "PID of the newer page"]
)
def test_the_pitch_of_an_aircraft_meets_the_printed_requirements(kp, ki, kd):
    """Control Tutorials, pitch: both print less than 2 s of rise, less than 10 % of overshoot and settling within 10 s."""
    system = loop_of(*PITCH, "pid_parallel", 0.01)
    flown = answer(system, 20.0, kp=kp, ki=ki, kd=kd, t_f=0.0, c=1.0)
    assert flown.rise < 2.0 and 0.0 < flown.overshoot < 10.0 and flown.settling() < 10.0


@pytest.mark.parametrize(
    ("plant", "k", "t_i", "peak"),
    [
        (THIRD_ORDER, 0.633, 1.95, 1.4),
        (THIRD_ORDER, 1.22, 1.78, 2.0),
        (FOUR_LAGS, 1.93, 0.745, 1.4),
        (FOUR_LAGS, 4.13, 0.59, 2.0),
    ],
)
def test_the_batch_of_astrom_and_hagglund_has_the_printed_peaks(plant, k, t_i, peak):
    """Astrom, Panagopoulos, Hagglund, Design of PI controllers based on non-convex optimization, Automatica 34 (1998), table 1."""
    numerator, denominator = plant
    system = loop_of(numerator, denominator, "pid_ideal", 0.001)
    found = margins_of(system, k=k, t_i=t_i, t_d=0.0)
    assert found.sensitivity.value[0, 0] == pytest.approx(peak, abs=0.01)


@pytest.mark.parametrize(
    ("kp", "ki", "crossover", "phase"), [(1.14, 0.454, 0.5205, 60.0), (2.83, 0.0495, 1.0, 43.9973)]
)
def test_a_pi_of_a_toolbox_has_the_printed_crossover_and_phase_margin(kp, ki, crossover, phase):
    """MathWorks, PID Controller Design at the Command Line: PI for 1/(s + 1)^3, gains printed to three digits."""
    found = margins_of(loop_of(*THIRD_ORDER, "pid_parallel", 0.001), kp=kp, ki=ki, kd=0.0, t_f=0.0)
    assert found.crossover.value[0, 0] == pytest.approx(crossover, rel=5e-3)
    assert np.degrees(found.phase.value[0, 0]) == pytest.approx(phase, abs=0.3)


def test_a_pid_of_a_toolbox_has_the_printed_crossover_and_phase_margin():
    """MathWorks, the same page: PIDF with a target of 1 rad/s, whose phase margin is 60 deg again."""
    found = margins_of(loop_of(*THIRD_ORDER, "pid_parallel", 0.0005), kp=2.72, ki=0.985, kd=1.72, t_f=0.00875)
    assert found.crossover.value[0, 0] == pytest.approx(1.0, rel=5e-3)
    assert np.degrees(found.phase.value[0, 0]) == pytest.approx(60.0, abs=0.1)


def test_a_two_degree_of_freedom_pid_crosses_where_it_was_designed_to_and_its_weight_takes_the_overshoot():
    """MathWorks, Tune 2-DOF PID Controller: 1/(s^2 + 0.5 s + 0.1), target 1.5 rad/s, b = 0.665, c = 0.

    The page prints these numbers alone; its overshoots are curves, and words: the weights take the overshoot away.
    """
    system = loop_of([1.0], [1.0, 0.5, 0.1], "pid_parallel", 0.005)
    gains = {"kp": 1.26, "ki": 0.255, "kd": 1.38, "t_f": 0.0}
    assert margins_of(system, **gains).crossover.value[0, 0] == pytest.approx(1.5, rel=5e-3)
    one, two = (answer(system, 40.0, **gains, b=b, c=c) for b, c in ((1.0, 1.0), (0.665, 0.0)))
    assert one.overshoot > 8.0 and two.overshoot == pytest.approx(0.0, abs=0.01)
