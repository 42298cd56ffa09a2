"""ArduPilot's own control libraries against our law, sample by sample."""

from dataclasses import replace

import numpy as np
import pytest

from plant.backends.instants import Instant
from plant.law_registry import LAWS
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions
from tests.clients.firmware_sources import checkout
from tests.tuner.engines.firmware.in_double import built_in_double
from tests.tuner.engines.firmware.laws_beside import board_torques, law_torques, motion, random_gains
from tests.tuner.exchange.ardupilot.test_ardupilot import bundle
from tuner.engines.firmware.ardupilot.bench import ARDUPILOT, LIBRARIES
from tuner.engines.firmware.firmware import Bench
from tuner.engines.firmware.flying import throttle_for, thrusts_of
from tuner.exchange.ardupilot.export import FILE
from tuner.gains import Controller

PARTS = [
    f"libraries/{name}"
    for name in ("AC_AttitudeControl", "AC_PID", "AP_Common", "AP_Math", "AP_Motors", "AP_Vehicle", "Filter")
]
# Largest difference over the largest torque of an axis; measured over the 40 runs: 8.9e-8 and 4.6e-5.
DOUBLE, SINGLE = 1e-6, 1e-4
# An X, a rectangle, another X and a plus.
AIRFRAMES = ("f450", "iris", "hummingbird", "hummingbird-rotors")
POSITION = {"kp": 3.0, "ki": 0.15, "kd": 2.5}
VERTICAL = {"z.kp": 5.2, "z.ki": 0.4, "z.kd": 4.0}


def own(airframe="f450", **changes):
    """ArduPilot's own attitude loops with our position loops where its parameters can hold them."""
    frame = load(airframe)
    cascade = close_cascade(LAWS["pid"], LAWS["ardupilot"])
    row = default_row(cascade, frame.vehicle)
    chosen = {f"{axis}.{name}": value for axis in "xy" for name, value in POSITION.items()} | VERTICAL | changes
    for gain in gain_addresses(cascade):
        row[gain.column] = chosen.get(gain.address, row[gain.column])
    return Controller(frame, cascade, ControlOptions(), 0.0025, 0.00125, tuple(row))


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """ArduPilot's control libraries in both precisions."""
    folder, sources = tmp_path_factory.mktemp("ardupilot"), checkout(LIBRARIES)
    return {
        "single": LIBRARIES.compile(sources, folder / "in_single"),
        "double": built_in_double(LIBRARIES, sources, folder, PARTS),
    }


def flown(program, folder, given, instants):
    made = bundle(given, "4.7")
    rotors = actuation(given.airframe.vehicle, ARDUPILOT.curve)
    board = ARDUPILOT.install(Bench(program, folder, rotors, given.control_period), made.files[FILE])()
    try:
        return board_torques(board, ARDUPILOT, given, instants)
    finally:
        board.close()


def controllers():
    """Yield 40 controllers of four airframes with random gains."""
    for seed in range(40):
        rng = np.random.default_rng([45, seed])
        yield own(AIRFRAMES[seed % 4], **random_gains(LAWS["ardupilot"], rng, {})), motion(rng, seed % 3)


@pytest.mark.slow
def test_its_libraries_turn_the_vehicle_as_our_law_does(programs, tmp_path):
    """In double precision; what float32 adds is the libraries' own rounding, for their two builds differ by the same.

    Most of it is an arc cosine near 1, which gives errors of tilt in steps of 0.35 mrad; axes without an error have none.
    """
    apart, rounding, left = [], [], []
    for number, (given, instants) in enumerate(controllers()):
        ours = law_torques(bundle(given, "4.7").held, instants)
        single, double = (flown(programs[name], tmp_path, given, instants) for name in ("single", "double"))
        size = np.abs(ours).max(axis=0)
        apart.append(np.abs(double - ours).max(axis=0) / size)
        rounding.append(np.abs(single - double).max(axis=0) / size)
        left.append(np.abs(np.abs(single - ours).max(axis=0) / size - rounding[-1]))
        if number % 3 < 2:
            rounding[-1][number % 3] = 0.0
    assert len(apart) == 40 and np.max(apart) < DOUBLE
    assert np.max(rounding) < SINGLE and np.max(left) < DOUBLE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("airframe", "linear"), [("f450", 0.0), ("f450", 0.4), ("iris", 0.0), ("hummingbird-rotors", 0.0)]
)
def test_armed_it_holds_the_motors_that_hold_the_vehicle(programs, tmp_path, airframe, linear):
    """Also a rectangular frame, a plus, and thrust that is no square of the command."""
    given = own(airframe)
    vehicle = given.airframe.vehicle._replace(thrust_linear=linear)
    given = replace(given, airframe=replace(given.airframe, vehicle=vehicle))
    rotors = actuation(given.airframe.vehicle, ARDUPILOT.curve)
    held = (0.52, 0.49, 0.47, 0.505)
    throttle = throttle_for(sum(thrusts_of(held, rotors, ARDUPILOT)) / 4.0, rotors)
    board = ARDUPILOT.install(
        Bench(programs["single"], tmp_path, rotors, given.control_period), bundle(given, "4.7").files[FILE]
    )()
    begin = Instant((0.02, -0.03, 1.1), (0.0, 0.0, 0.0), (0.02, -0.03), 1.1, 0.0)
    try:
        board.arm(begin, throttle, held)
        assert board.step(begin, throttle) == pytest.approx(held, abs=1e-3)
    finally:
        board.close()
