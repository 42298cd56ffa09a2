"""Units of gains of plants: those of the command over those of the error, or accelerations where b0 has a unit of its own."""

import pytest

from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.plan import Channel
from plant.model.units import gain_unit, per_time, times_time
from tests.plant.model.plants import cascade, pid, system_of


@pytest.mark.parametrize(
    ("unit", "rate"),
    [("rad", "rad/s"), ("m/s", "m/s2"), ("m/s2", "m/s3"), ("1", "1/s"), ("m/s/V", "m/s/V/s"), ("V/rad", "V/rad/s")],
)
def test_units_of_derivatives(unit, rate):
    assert per_time(unit) == rate


@pytest.mark.parametrize(
    ("unit", "integral"),
    [
        ("rad/s", "rad"),
        ("m/s2", "m/s"),
        ("1/s3", "1/s2"),
        ("1/s", "1"),
        ("1", "s"),
        ("V/rad", "V s/rad"),
        ("1/m", "s/m"),
    ],
)
def test_units_of_integrals(unit, integral):
    assert times_time(unit) == integral


@pytest.mark.parametrize(
    ("command", "output", "units"),
    [
        ("V", "rad", ["V s/rad", "V/rad", "V/rad/s"]),
        ("W", "degC", ["W s/degC", "W/degC", "W/degC/s"]),
        ("rad/s", "rad", ["1", "1/s", "1/s2"]),
        ("1", "m", ["s/m", "1/m", "1/m/s"]),
        ("1", "1", ["s", "1", "1/s"]),
        ("N", "m/s", ["N s/(m/s)", "N/(m/s)", "N/(m/s)/s"]),
        ("rad", "rad", ["s", "1", "1/s"]),
    ],
)
def test_units_of_gains_on_derivative_error_and_integral(command, output, units):
    assert [gain_unit(command, output, integrals) for integrals in (-1, 0, 1)] == units


def units_of(system):
    return [gain.unit for gain in system.gains]


@pytest.mark.parametrize("b0", [1.0, -1.0])
def test_gains_of_a_loop_without_b0_are_in_units_of_its_command(b0):
    """A volt for each radian is what kp = 1 does, which flights of the motor show; only where b0 = 1 is it that."""
    motor = system_of("dc_motor", [pid("angle", "angle", "voltage", b0=b0)], [], Timing(0.001, 0.001))
    assert units_of(motor) == ["V/rad", "V/rad/s", "V s/rad", "s"]
    assert motor.gains[0].info.meaning == "proportional gain, command per error"


def test_gains_of_a_loop_with_b0_are_accelerations():
    motor = system_of("dc_motor", [pid("angle", "angle", "voltage", b0=2122.0)], [], Timing(0.001, 0.001))
    assert units_of(motor) == ["s^-2", "s^-3", "s^-1", "s"]
    assert units_of(cascade())[:3] == ["rad/s", "1", "rad/s"]


def test_gains_of_other_laws_keep_their_units():
    channel = Channel("angle", LAWS["supertwisting"], "angle", "voltage")
    motor = system_of("dc_motor", [channel], [], Timing(0.001, 0.001))
    assert units_of(motor) == ["s^-1", "rad^(1/2) s^(-3/2)", "rad s^-3"]
