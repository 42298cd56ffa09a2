"""Our PID as a proportional loop around a loop on the rate, and back; the feedback is the same."""

import numpy as np
import pytest

from plant.errors import InputError
from plant.laws.pid import Gains
from tuner.extensions.autopilots.pid import RateLoop, parallel, rate_loop


@pytest.mark.parametrize(
    "gains", [Gains(90.0, 60.0, 15.0, 0.01), Gains(2.5, 0.3, 2.6, 0.02), Gains(50.0, 0.0, 10.0, 0.005)]
)
def test_both_forms_feed_back_the_same(gains):
    """Both controllers' responses from y to u, as written, at many frequencies."""
    loop = rate_loop(gains, "roll")
    s = 1j * np.logspace(-2, 3, 200)
    theirs = loop.p * (loop.outer + s) + loop.i * (loop.outer + s) / s
    ours = gains.kp + gains.ki / s + gains.kd * s
    np.testing.assert_allclose(theirs, ours, rtol=1e-12)


@pytest.mark.parametrize(
    "gains", [Gains(90.0, 60.0, 15.0, 0.01), Gains(2.5, 0.3, 2.6, 0.02), Gains(50.0, 0.0, 10.0, 0.005)]
)
def test_back_again(gains):
    np.testing.assert_allclose(parallel(rate_loop(gains, "x"), gains.t_f), gains, rtol=1e-14)


def test_setpoint_weight_is_the_dc_share_of_the_reference():
    gains = Gains(90.0, 60.0, 15.0, 0.01)
    loop = rate_loop(gains, "roll")
    assert loop.setpoint_weight == pytest.approx(loop.p * loop.outer / gains.kp, rel=1e-12)
    assert RateLoop(6.0, 15.0, 0.0).setpoint_weight == 1.0


def test_double_root_is_the_most_integral_action():
    rate_loop(Gains(90.0, 90.0**2 / 60.0, 15.0, 0.01), "roll")
    with pytest.raises(InputError, match=r"roll\.ki.*at most.*135"):
        rate_loop(Gains(90.0, 136.0, 15.0, 0.01), "roll")


def test_without_damping_there_is_no_rate_loop():
    with pytest.raises(InputError, match=r"yaw\.kd"):
        rate_loop(Gains(90.0, 0.0, 0.0, 0.01), "yaw")


def test_a_vehicles_own_form_is_kept_and_its_root_is_taken():
    """An integral faster than the angle loop is the smaller root; a double root and a loop without P come back as they are."""
    for own in (
        RateLoop(4.0, 15.0, 150.0),
        RateLoop(4.0, 15.0, 60.0),
        RateLoop(0.0, 15.0, 30.0),
        RateLoop(2.0, 0.0, 9.0),
    ):
        assert rate_loop(parallel(own, 0.01), "roll", own) == own
    own = RateLoop(4.0, 15.0, 150.0)
    gains = parallel(own, 0.01)
    assert rate_loop(gains, "roll").outer == pytest.approx(10.0)
    near = rate_loop(gains._replace(kp=1.001 * gains.kp), "roll", own)
    assert near.outer == pytest.approx(4.0, rel=0.01)
    np.testing.assert_allclose(parallel(near, 0.01), gains._replace(kp=1.001 * gains.kp), rtol=1e-13)
