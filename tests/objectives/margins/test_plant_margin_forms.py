"""Margins of plants of one's own against closed forms, against the same plant in another unit of time, and what has none."""

from math import acos, exp, sqrt

import numpy as np
import pytest

from objectives.margins.plant_margins import PlantMargins
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.plan import Actuator, Channel
from plant.own_code import run_own_code
from tests.plant.model.plants import pid, system_of
from tests.plant.own_files import LAW


def first_order(h, lag=1.0, periods=0):
    """A first-order plant under a PI controller."""
    system = system_of(
        "dead_time", [pid("level", "level", "valve")], [Actuator("valve", delay=periods * h)], Timing(h, h)
    )
    object.__setattr__(system, "parameters", system.plant.Parameters(lag=lag))
    return system


@pytest.mark.parametrize(("kp", "ki"), [(3.0, 2.0), (1.0, 15.0), (0.5, 0.05), (8.0, 1.0)])
def test_second_order_closed_form(kp, ki):
    """L = b (kp (z - 1) + h ki)/((z - a) (z - 1)): Jury's conditions and a quadratic in cos(wh) give every margin exactly."""
    h = 0.1
    a = exp(-h)
    b, q = 1.0 - a, h * ki - kp
    gains = np.array([[kp, ki, 0.0, 0.01]])
    margins = PlantMargins(first_order(h), 0.9 * gains[0], 1.1 * gains[0]).evaluate(gains)
    # Closed loop z^2 + (b g kp - a - 1) z + a + b g q: the product of its roots and its value at -1 limit the factor g.
    product, at_minus_1 = ((1.0 - a) / (b * q) if q > 0.0 else np.inf), 2.0 * (1.0 + a) / (b * (kp - q))
    assert margins.stable[0, 0] == (min(product, at_minus_1) > 1.0)
    if not margins.stable[0, 0]:
        return
    assert margins.gain_up.value[0, 0] == pytest.approx(min(product, at_minus_1), rel=1e-9)
    # |L| = 1: b^2 (kp^2 + q^2 + 2 kp q c) = (1 + a^2 - 2 a c) (2 - 2 c), c = cos(wh).
    roots = np.roots([4.0 * a, -2.0 * (1.0 + a) ** 2 - 2.0 * b**2 * kp * q, 2.0 * (1.0 + a**2) - b**2 * (kp**2 + q**2)])
    crossings = [acos(c.real) / h for c in roots if abs(c.imag) < 1e-12 and -1.0 < c.real < 1.0]
    z = np.exp(1j * np.array(crossings) * h)
    lag = np.mod(np.angle(b * (kp * z + q) / ((z - a) * (z - 1.0))) + np.pi, 2.0 * np.pi)
    assert margins.phase.value[0, 0] == pytest.approx(min(np.minimum(lag, 2.0 * np.pi - lag)), rel=1e-8)
    assert margins.delay.value[0, 0] == pytest.approx(min(lag / crossings), rel=1e-8)


def test_a_double_integrator_tends_to_its_textbook_margin():
    """PD on a rigid mass, damping ratio 1/sqrt(2): w_c^2 = wn^2 (1 + sqrt 2), phase margin atan(sqrt(2) w_c/wn)."""
    wn, found = 2.0, []
    for h in (0.002, 0.001):
        channel = Channel("angle", LAWS["pid"], "angle", "voltage", b0=1.0)
        system = system_of("dc_motor", [channel], [], Timing(h, h))
        free = system.plant.Parameters(inertia=0.0274 / 4.0, friction=-(0.0274**2) / 4.0)
        object.__setattr__(system, "parameters", free)
        gains = np.array([wn**2, 0.0, sqrt(2.0) * wn, 0.0])
        margins = PlantMargins(system, 0.9 * gains, 1.1 * gains + 1e-9).evaluate(gains[None])
        found.append((margins.crossover.value[0, 0], margins.phase.value[0, 0]))
    exact = wn * sqrt(1.0 + sqrt(2.0)), np.arctan(sqrt(2.0 * (1.0 + sqrt(2.0))))
    # Sampling costs in proportion to the period.
    assert 2.0 * np.array(found[1]) - found[0] == pytest.approx(exact, rel=1e-4)


def test_a_law_that_is_given_its_rate_has_the_margins_of_one_that_differences_by_itself():
    gains, found = [20.0, 1.0, 6.0, 0.0], []
    for law in (run_own_code(LAW).names["LAW"], LAWS["pid"]):
        system = system_of("dc_motor", [Channel("angle", law, "angle", "voltage", b0=2100.0)], [], Timing(0.01, 0.005))
        row = np.array(gains[: len(law.gains)])
        found.append(PlantMargins(system, 0.9 * row, 1.1 * row + 1e-9).evaluate(row[None]))
    for name in ("gain_up", "phase", "delay", "sensitivity", "crossover"):
        given, own = (getattr(margins, name).value[0, 0] for margins in found)
        assert given == pytest.approx(own, rel=1e-6), name


@pytest.mark.parametrize("scale", [1e-4, 1e4])
@pytest.mark.parametrize("periods", [0, 10])
def test_margins_do_not_depend_on_the_unit_of_time(scale, periods):
    """A plant of hours has the margins of a plant of milliseconds, in its own time."""
    gains, slow = np.array([2.0, 1.5, 0.1, 0.02]), np.array([2.0, 1.5 / scale, 0.1 * scale, 0.02 * scale])
    near = PlantMargins(first_order(0.02, 1.0, periods), 0.9 * gains, 1.1 * gains).evaluate(gains[None])
    far = PlantMargins(first_order(0.02 * scale, scale, periods), 0.9 * slow, 1.1 * slow).evaluate(slow[None])
    for name in ("gain_up", "phase", "sensitivity", "complementary", "disk"):
        assert getattr(far, name).value[0, 0] == pytest.approx(getattr(near, name).value[0, 0], rel=1e-6), name
    assert far.delay.value[0, 0] == pytest.approx(near.delay.value[0, 0] * scale, rel=1e-6)
    assert far.crossover.value[0, 0] * scale == pytest.approx(near.crossover.value[0, 0], rel=1e-6)


def test_the_worst_of_several_plants_is_reported():
    system, gains = first_order(0.05, 1.0, 4), np.array([[2.0, 2.0, 0.0, 0.01]])
    corners = [system.plant.Parameters(gain=factor) for factor in (0.7, 1.4)]
    each = [PlantMargins(system, gains[0], gains[0]), PlantMargins(system, gains[0], gains[0], others=corners)]
    alone, worst = [model.evaluate(gains) for model in each]
    # A gain 1.4 times as large leaves as much less of the gain margin.
    assert worst.gain_up.value[0, 0] == pytest.approx(alone.gain_up.value[0, 0] / 1.4, rel=1e-9)
    assert worst.gain_up.vehicle[0, 0] == 2


def test_rates_that_never_meet_are_refused_with_what_to_do():
    slow, fast = pid("angle", "angle", "speed", every=81), pid("speed", "speed", "torque", every=27)
    other = pid("wobble", "angle", "torque", every=2)
    system = system_of("pendulum", [slow, fast, other], [], Timing(0.002, 0.001))
    row = np.ones(12)
    with pytest.raises(
        InputError, match=r"step every 81, 27, 2 periods step together every 162 periods; margins are known up to 64"
    ):
        PlantMargins(system, row, row)
