"""Design rules against what their authors print, and the command that applies them."""

import numpy as np
import pytest
from scipy.special import gammainc, gammaincinv

import tuner
from plant.errors import InputError
from plant.model.plan import Actuator
from tests.tuner.extensions.textbook_laws.loops import answer, loop_of, with_actuator
from tuner.extensions.design_rules.gains import pid_gains
from tuner.extensions.design_rules.methods import damping_warning
from tuner.extensions.design_rules.process import NoProcessError, half_rule, process_of
from tuner.extensions.design_rules.rules import (
    IdealPid,
    amigo,
    herbst,
    lambda_,
    simc,
    ultimate_point,
    ziegler_nichols,
)

H = 1e-4


def process(numerator, denominator, dead_time=0.0, h=H, law="pid_ideal", **rest):
    system = loop_of(numerator, denominator, law, h, **rest)
    if dead_time:
        system = with_actuator(system, Actuator("u", delay=dead_time))
    return process_of(system, system.plan.channels[0])


def lags(*constants):
    product = np.array([1.0])
    for each in constants:
        product = np.polymul(product, [each, 1.0])
    return product.tolist()


def test_a_lag_with_dead_time_is_found_as_it_is():
    found = process([1.8], [23.0, 1.0], 2.0, h=0.01)
    assert (found.gain, found.time_constant, found.dead_time) == pytest.approx((1.8, 23.0, 2.005), rel=1e-3)


def test_an_integrator_with_a_lag_is_found_by_its_asymptote():
    """0.3/(s (4 s + 1)) answers to a step, in the end, as 0.3 (t - 4)."""
    found = process([0.3], [4.0, 1.0, 0.0])
    assert found.is_integrating and (found.gain, found.dead_time) == pytest.approx((0.3, 4.0), rel=1e-3)


def test_four_equal_lags_have_the_process_of_their_gamma_function_and_the_printed_amigo_gains():
    """1/(s + 1)^4 answers as the incomplete gamma function, steepest at 3 s; Astrom, Hagglund 2006, section 7.4: K = 1.12, Ti = 2.40."""
    found = process([1.0], lags(1.0, 1.0, 1.0, 1.0))
    tangent = 3.0 - gammainc(4, 3.0) / (27.0 / 6.0 * np.exp(-3.0))
    sixty_three = gammaincinv(4, 1.0 - np.exp(-1.0))
    assert (found.dead_time, found.time_constant) == pytest.approx((tangent, sixty_three - tangent), rel=1e-3)
    design = amigo(found, None)
    assert (design.k, design.t_i, design.t_d, design.b) == pytest.approx((1.12, 2.40, 0.619, 0.0), rel=0.01)


def test_three_equal_lags_have_the_printed_ultimate_point():
    """1/(s + 1)^3 oscillates under a gain of 8 with the period 2 pi/sqrt 3."""
    found = process([1.0], lags(1.0, 1.0, 1.0))
    assert ultimate_point(found.path) == pytest.approx((8.0, 2.0 * np.pi / np.sqrt(3.0)), rel=1e-3)
    design = ziegler_nichols(found, None)
    assert (design.k, design.t_i, design.t_d) == pytest.approx((4.8, 1.81, 0.453), rel=3e-3)


def test_the_half_rule_gives_skogestads_printed_models():
    assert half_rule((1.0, 0.2), 0.0, 1) == ((1.1,), pytest.approx(0.1))
    (first, second), late = half_rule((1.0, 0.2, 0.04, 0.008), 0.0, 2)
    assert (first, second, late) == pytest.approx((1.0, 0.22, 0.028))


@pytest.mark.parametrize(
    ("constants", "order", "k", "t_i", "t_d"),
    [((1.0, 0.2, 0.04, 0.008), 2, 17.9, 0.224, 0.22)],
)
def test_simc_gives_skogestads_printed_gains(constants, order, k, t_i, t_d):
    """Skogestad 2003, table 4, in the series form; the law `pid_series` gets them back."""
    system = loop_of([1.0], lags(*constants), "pid_series", 1e-5)
    found = process_of(system, system.plan.channels[0])
    gains = pid_gains(system.plan.channels[0].law, simc(found, None), 1.0)
    assert (gains["k"], gains["t_i"], gains["t_d"]) == pytest.approx((k, t_i, t_d), rel=4e-3)


@pytest.mark.parametrize(("damping", "is_warned"), [(0.5, True), (0.8, False), (1.5, False)])
def test_poles_that_swing_are_named_with_their_damping_ratio(damping, is_warned):
    found = process([1.0], [1.0, 2.0 * damping, 1.0])
    assert found.damping == pytest.approx(min(damping, 1.0))
    assert (damping_warning(found.damping) != "") is is_warned


def test_simc_of_an_integrator_has_eight_dead_times():
    design = simc(process([0.5], [1.0, 0.0], 2.0, h=0.01), None)
    assert (design.k, design.t_i) == pytest.approx((1.0 / (0.5 * 2.0 * 2.005), 8.0 * 2.005), rel=1e-3)


def test_lambda_tuning_answers_as_a_lag_of_lambda():
    """With the zero on the lag, the loop is a dead time and an integrator: 63 % of a step are reached near lambda + L."""
    system = with_actuator(loop_of([2.0], [3.0, 1.0], "pid_ideal", 0.01), Actuator("u", delay=0.2))
    design = lambda_(process_of(system, system.plan.channels[0]), 4.0)
    flown = answer(system, 30.0, k=design.k, t_i=design.t_i, t_d=0.0)
    assert flown.t[np.argmax(flown.y > 1.0 - np.exp(-1.0))] == pytest.approx(4.2, abs=0.1)
    assert flown.overshoot < 0.1


def test_herbst_settles_in_the_time_that_was_asked_for():
    system = loop_of([2.0], [3.0, 1.0], "adrc1", 0.01, b0=2.0 / 3.0)
    found = herbst(process_of(system, system.plan.channels[0]), 2.0)
    assert (found.omega_c, found.b0) == pytest.approx((2.0, 2.0 / 3.0), rel=1e-3)
    flown = answer(system, 8.0, omega_c=found.omega_c, omega_o=found.omega_o)
    assert flown.settling() == pytest.approx(2.0, abs=0.25)


@pytest.mark.parametrize(
    ("numerator", "denominator", "rest", "reason"),
    [
        ([1.0], [1.0, 0.0, 0.0], {}, "integrates twice"),
        ([1.0], [1.0, -1.0], {}, "not stable"),
        ([-1.0], [1.0, 1.0], {}, "b0 = 1 has the other sign"),
    ],
)
def test_a_plant_that_no_rule_takes_is_refused_with_the_reason(numerator, denominator, rest, reason):
    with pytest.raises(NoProcessError, match=reason):
        process(numerator, denominator, **rest)


def test_a_negative_plant_gets_positive_gains():
    system = loop_of([-2.0], [3.0, 1.0], "pid_ideal", 0.01, b0=-5.0)
    found = process_of(system, system.plan.channels[0])
    mirrored = loop_of([2.0], [3.0, 1.0], "pid_ideal", 0.01)
    k = pid_gains(system.plan.channels[0].law, simc(found, 1.0), -5.0)["k"]
    alike = simc(process_of(mirrored, mirrored.plan.channels[0]), 1.0).k
    assert k == pytest.approx(5.0 * alike, rel=1e-9)


def test_complex_zeros_have_no_series_form():
    system = loop_of([1.0], [1.0, 1.0], "pid_series", 0.01)
    with pytest.raises(NoProcessError, match="use pid_ideal"):
        pid_gains(system.plan.channels[0].law, IdealPid(1.0, 1.0, 0.5), 1.0)


@pytest.fixture(scope="module")
def heater():
    return tuner.load_study("heater")


def test_a_study_is_designed_by_rule_with_margins_and_a_table_to_start_from(heater):
    designed = tuner.design(heater, method="amigo")
    (loop,) = designed.document["design"]
    assert loop["designed"] and 1.2 < loop["ms"] < 1.7
    assert "taken for gain 1.8" in designed.warnings[0]
    assert designed.toml.startswith("[gains]")


def test_ziegler_nichols_comes_with_its_warning(heater):
    assert "quarter-amplitude" in tuner.design(heater, method="ziegler-nichols").warnings[0]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "smic"}, "did you mean 'simc'"),
        ({"time": 3.0}, "--time: needs a rule"),
        ({"method": "simc", "time": -1.0}, "allowed: a finite number above 0"),
    ],
)
def test_options_that_do_not_fit_are_refused(heater, options, message):
    with pytest.raises(InputError, match=message):
        tuner.design(heater, **options)


def test_a_rule_for_a_quadrotor_is_refused():
    with pytest.raises(InputError, match="--method: a rule designs channels of a plant"):
        tuner.design("quickstart", method="simc")


def test_a_time_for_a_rule_without_one_leaves_the_channel_as_it_is(heater):
    designed = tuner.design(heater, method="amigo", time=3.0)
    assert "has no closed-loop time" in designed.warnings[0] and not designed.document["design"][0]["designed"]
