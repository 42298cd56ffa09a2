"""What every firmware promises; a new entry of the registry is tested by all of this."""

import inspect
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from plant.backends.lanes import compiled
from plant.errors import InputError, UnknownNameError
from plant.law_registry import law
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.gains import default_row
from plant.quadrotor.rigid_body import rotor_torque
from plant.vectors import Rotors
from tests.clients import program
from tests.clients.crazyflie_firmware import build
from tests.clients.firmware_sources import checkout
from tests.tuner.exchange.controllers import controller
from tuner.exchange.registry import exporter, settings_of
from tuner.exchange.run import bundle_of, check_laws
from tuner.exchange.target import Request
from tuner.extensions.ardupilot import bench as ardupilot
from tuner.extensions.autopilots.firmware import Bench
from tuner.extensions.autopilots.flying import throttle_for, thrusts_of
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.autopilots.piloted import angle, pilot_of
from tuner.extensions.autopilots.registry import firmware_of, firmwares
from tuner.extensions.px4 import bench as px4
from tuner.study.targets import TARGETS

AIRFRAMES = ("racer5", "crazyflie-pybullet")
EVERY = pytest.mark.parametrize("entry", firmwares().values(), ids=firmwares())


def flown(entry):
    """The first airframe that the target's mixing takes, at the rates of a study for it."""
    usual = TARGETS[entry.target]
    for name in AIRFRAMES:
        plain = controller("pid", entry.law, name, period=usual.control_period, every=usual.position_every)
        with suppress(InputError):
            exported(entry, plain)
            return plain
    raise AssertionError(f"{entry.name}: no airframe")


def exported(entry, plain=None):
    plain = plain or flown(entry)
    period = plain.control_period
    row = tuple(default_row(plain.cascade, plain.airframe.vehicle))
    request = Request(
        type(plain)(plain.airframe, plain.cascade, plain.options, period, period, row),
        "0" * 64,
        settings_of(exporter(entry.target), entry.options),
        None,
    )
    check_laws(exporter(entry.target), request)
    return bundle_of(exporter(entry.target), request)


@EVERY
def test_its_gains_come_from_our_exporter(entry):
    """The target takes its law, and writes the file that it loads."""
    assert firmwares()[entry.name] is entry
    assert entry.file in exported(entry).files


@EVERY
def test_it_says_what_is_lost(entry):
    assert entry.loses and all(sentence.endswith(".") and "\n" not in sentence for sentence in entry.loses)


@EVERY
def test_its_pilot_closes_the_heading_loop_of_the_law(entry):
    """A pilot asks for no rate where the heading is right, for more the further it is off, and the kernel asks for the same."""
    own, period = law(entry.law), TARGETS[entry.target].control_period
    constants = own.prepare(own.Gains(*[own.span(gain, "yaw", "attitude").default for gain in own.gains]), period)
    if entry.heading is None:
        pytest.skip("it closes the heading itself")
    asked = [entry.heading(constants, Setpoint(goal, 0.0, 0.0), Measured(0.1, 0.0)) for goal in (0.1, 0.2, 0.3)]
    assert asked[0] == 0.0 and 0.0 < asked[1] < asked[2]
    assert entry.heading(constants, Setpoint(0.1, 0.7, 0.0), Measured(0.1, 0.0)) == pytest.approx(0.7)
    step = compiled(entry.heading)
    assert step(constants, Setpoint(0.2, 0.0, 0.0), Measured(0.1, 0.0)) == pytest.approx(asked[1])
    assert pilot_of(own, entry.heading).prepare is own.prepare


@EVERY
def test_who_closes_the_heading_is_who_the_law_says(entry):
    """Without a pilot's rate, the law itself turns the vehicle towards a heading just where the firmware does."""
    own, period = law(entry.law), TARGETS[entry.target].control_period
    gains = own.Gains(*[own.span(gain, "yaw", "attitude").default for gain in own.gains])
    constants, seen = own.prepare(gains, period), Measured(0.1, 0.0)
    goal = Setpoint(0.3, 0.0, 0.0)
    wish = angle(constants, goal, seen) if entry.heading is None else entry.heading(constants, goal, seen)
    assert (wish == 0.3) == (entry.heading is None)
    turned, _ = own.step(
        own.start(constants, seen, 0.0), constants, Channel(1.0, 0.0), goal, seen, Applied(0.0, 0.0), period
    )
    assert turned > 0.0


@EVERY
def test_a_period_of_its_loops_is_named_where_it_is_impossible(entry):
    entry.check(TARGETS[entry.target].control_period)
    with pytest.raises(InputError, match="ms"):
        entry.check(0.0033333)


@EVERY
def test_a_program_that_is_none_is_refused_in_one_line(entry, tmp_path):
    program("gcc")
    plain = flown(entry)
    rotors = actuation(plain.airframe.vehicle, entry.curve)
    bench = Bench(entry.program(tmp_path / "missing"), tmp_path / "bench", rotors, plain.control_period)
    with pytest.raises(InputError, match="cannot be run") as caught:
        entry.install(bench, exported(entry).files[entry.file])
    assert "\n" not in str(caught.value)


PRESENT = {
    "ardupilot": lambda: checkout(ardupilot.LIBRARIES),
    "crazyflie": build,
    "px4": lambda: checkout(px4.LIBRARIES),
}
"""Values of --binary by firmware; each skips the test where it is not there."""
# About x, y and z: what is asked for with a tilt, and of the heading as an angle or as a rate.
WISHES = ({"tilt": (0.05, 0.0)}, {"tilt": (0.0, 0.05)}, {"yaw": 0.05})
LEVEL = Instant((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0)


@pytest.mark.slow
@EVERY
def test_where_it_is_present_it_turns_as_it_is_asked_and_again_the_same(entry, tmp_path):
    """With the gains of our file: towards a tilt and a heading, and a second flight is the first to the last bit."""
    if entry.name not in PRESENT:
        pytest.skip("its sticks and motors have steps as large as this; the tests of its board fly it")
    binary, plain = entry.program(PRESENT[entry.name]()), flown(entry)
    vehicle, rotors = plain.airframe.vehicle, actuation(plain.airframe.vehicle, entry.curve)
    power_up = entry.install(Bench(binary, tmp_path, rotors, plain.control_period), exported(entry).files[entry.file])
    hover = rotors.hover_command
    for axis, wish in enumerate(WISHES):
        flights = []
        for _ in range(2):
            board = power_up()
            try:
                board.arm(LEVEL, hover, (hover, hover, hover, hover))
                flights.append(
                    [board.step(replace(LEVEL, **wish), hover) for _ in range(round(0.1 / plain.control_period))]
                )
            finally:
                board.close()
        assert flights[0] == flights[1]
        thrusts = Rotors(*thrusts_of(flights[0][-1], rotors, entry))
        torque = rotor_torque(thrusts, vehicle.rotor_x, vehicle.rotor_y, vehicle.spin, vehicle.torque_ratio)
        assert torque[axis] > 10.0 * max(abs(part) for k, part in enumerate(torque) if k != axis)


def test_an_unknown_name_is_told_with_those_that_are_known():
    with pytest.raises(UnknownNameError, match="betaflight"):
        firmware_of("betafligth")


@EVERY
def test_the_thrust_curve_is_undone(entry):
    rotors = actuation(load("racer5").vehicle, entry.curve)
    lifts = np.linspace(1.1 * rotors.thrust_min, 0.99 * rotors.thrust_max, 7)
    throttles = [throttle_for(lift, rotors) for lift in lifts.tolist()]
    back = [thrusts_of((u, u, u, u), rotors, entry)[0] for u in throttles]
    np.testing.assert_allclose(back, lifts, rtol=1e-12)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 1.5, -0.2])
def test_motor_commands_that_are_none_are_refused(bad):
    rotors = actuation(load("racer5").vehicle)
    with pytest.raises(InputError, match="allowed: 0 to 1"):
        thrusts_of((0.5, bad, 0.5, 0.5), rotors, firmwares()["betaflight"])


def test_every_field_of_the_seam_is_told():
    """The docstring names each field, as docs/how_to/confirm.md asks of whoever adds a firmware."""
    kind = type(firmwares()["betaflight"])
    told = inspect.getdoc(kind) or ""
    assert [name for name in kind.__dataclass_fields__ if name not in told] == []
