"""Order of motors and sign of the yaw rate, learnt from boards that mix as a quadrotor must to work against a rate."""

from itertools import permutations
from pathlib import Path

import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.betaflight.wiring import STILL, Motors, Wiring, learn_wiring

ROTORS = actuation(load("f450").vehicle).rotors
SPINS = [mount.spin for mount in ROTORS]
PERIOD = 0.001


class Mixing:
    """A board whose motors make torques against rates and tilt: thrusts T with x T, y T and spin T of the signs asked for."""

    def __init__(self, order, yaw=1.0, level=4.0, every=1, passed=0.3):
        self.order, self.yaw, self.level, self.every, self.passed = order, yaw, level, every, passed
        self.is_on, self.filtered, self.count, self.sent = True, [0.0, 0.0, 0.0], 0, STILL

    def arm(self, initial, throttle, held):
        pass

    def step(self, setpoints: Instant, throttle: float) -> Motors:
        self.count += 1
        if self.count % self.every:
            return self.sent
        # A low-pass, as firmwares have before their loops.
        self.filtered = [
            old + self.passed * (new - old) for old, new in zip(self.filtered, setpoints.rate, strict=True)
        ]
        p, q, r = self.filtered
        roll, pitch, _ = setpoints.angles
        torque_x, torque_y, torque_z = -p - self.level * roll, -q - self.level * pitch, -self.yaw * r
        # A rotor at (x, y) with thrust T turns the body by (y T, -x T), and by its reaction with the sign of its spin.
        thrust = [
            throttle + 0.1 * (torque_x * (mount.y > 0) - torque_x * (mount.y < 0))
            - 0.1 * (torque_y * (mount.x > 0) - torque_y * (mount.x < 0)) + 0.1 * mount.spin * torque_z
            for mount in ROTORS
        ]  # fmt: skip
        sent = [0.0] * 4
        for rotor, place in enumerate(self.order):
            sent[place] = round(thrust[rotor], 3)
        first, second, third, fourth = sent
        self.sent = (first, second, third, fourth)
        return self.sent

    def close(self):
        self.is_on = False


@pytest.mark.parametrize("yaw", [1.0, -1.0])
def test_every_order_of_the_motors_is_learnt(yaw):
    for order in permutations(range(4)):
        made = Mixing(order, yaw)
        # A build that works with a yaw rate of this sign, not against it, reads it with the other sign.
        assert learn_wiring(lambda _, made=made: made, SPINS, PERIOD, Path("sitl")) == Wiring(
            (order[0], order[1], order[2], order[3]), -yaw
        )
        assert not made.is_on


def test_a_build_that_estimates_its_attitude_is_named_with_the_option():
    with pytest.raises(InputError, match="-DSITL_ATTITUDE_DIRECT in EXTRA_FLAGS"):
        learn_wiring(lambda _: Mixing((0, 1, 2, 3), level=0.2), SPINS, PERIOD, Path("sitl"))


def test_a_build_with_slower_loops_is_named_with_the_option():
    """Its noise was twice the model's, for D and filters ran at 500 Hz in place of 4 kHz."""
    for every in (2, 8):
        with pytest.raises(InputError, match="-DVIRTUAL_GYRO_SAMPLE_RATE_HZ=8000"):
            learn_wiring(lambda _, every=every: Mixing((0, 1, 2, 3), every=every), SPINS, PERIOD, Path("sitl"))


def test_a_file_that_switches_filters_off_is_no_slower_loop():
    """Betaflight 4.6 without filters of the gyro answers a pulse of the rate within three periods."""
    board = Mixing((0, 1, 2, 3), passed=0.98)
    assert learn_wiring(lambda _: board, SPINS, PERIOD, Path("sitl")).places == (0, 1, 2, 3)


def test_motors_of_no_x_are_named_with_the_expected_versions():
    class Coaxial(Mixing):
        def step(self, setpoints: Instant, throttle: float) -> Motors:
            front = 0.1 * setpoints.rate[1]
            return (throttle + front, throttle + front, throttle - front, throttle - front)

    with pytest.raises(InputError, match=r"those of no X.*expected is Betaflight 2025\.12 to 2026\.12"):
        learn_wiring(lambda _: Coaxial((0, 1, 2, 3)), SPINS, PERIOD, Path("sitl"))
