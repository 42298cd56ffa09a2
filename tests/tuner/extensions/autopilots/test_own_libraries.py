"""Control libraries of PX4 and ArduPilot themselves against our laws, sample by sample."""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from plant.law_registry import LAWS
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions, yaw_smoothing
from tests.clients.firmware_sources import checkout
from tests.tuner.extensions.ardupilot import test_ardupilot as of_ardupilot
from tests.tuner.extensions.autopilots.in_double import built_in_double
from tests.tuner.extensions.autopilots.laws_beside import AXES, board_torques, law_torques, motion, random_gains
from tests.tuner.extensions.px4 import test_px4 as of_px4
from tests.tuner.extensions.px4.test_px4_own_loops import own as own_px4
from tuner.extensions.ardupilot import bench as ardupilot
from tuner.extensions.autopilots.firmware import Bench, Firmware
from tuner.extensions.autopilots.flying import throttle_for, thrusts_of
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.autopilots.libraries.building import ControlLibraries
from tuner.extensions.px4 import bench as px4
from tuner.gains import Controller

PARTS = [
    f"libraries/{name}"
    for name in ("AC_AttitudeControl", "AC_PID", "AP_Common", "AP_Math", "AP_Motors", "AP_Vehicle", "Filter")
]
# Largest difference over the largest torque of an axis; measured over the 40 runs: 4.4e-7 and 4.6e-5.
DOUBLE, SINGLE = 1e-6, 1e-4
# An X, a rectangle, another X and a plus.
AIRFRAMES = ("f450", "iris", "hummingbird", "hummingbird-rotors")
POSITION = {"kp": 3.0, "ki": 0.15, "kd": 2.5}
VERTICAL = {"z.kp": 5.2, "z.ki": 0.4, "z.kd": 4.0}


def own_ardupilot(airframe="f450", **changes):
    """ArduPilot's own attitude loops with our position loops where its parameters can hold them."""
    frame = load(airframe)
    cascade = close_cascade(LAWS["pid"], LAWS["ardupilot"])
    row = default_row(cascade, frame.vehicle)
    chosen = {f"{axis}.{name}": value for axis in "xy" for name, value in POSITION.items()} | VERTICAL | changes
    for gain in gain_addresses(cascade):
        row[gain.column] = chosen.get(gain.address, row[gain.column])
    return Controller(frame, cascade, ControlOptions(), 0.0025, 0.00125, tuple(row))


def random_px4(rng, seed):
    """Random gains; each second has a notch, two of three a low-pass on yaw's torque."""
    notch = rng.uniform(30.0, 120.0) if seed % 2 else 0.0
    given = own_px4(AIRFRAMES[seed % 4], **random_gains(LAWS["px4"], rng, {f"{axis}.notch": notch for axis in AXES}))
    cutoff = float(rng.uniform(0.5, 8.0)) if seed % 3 else 0.0
    return replace(given, options=replace(given.options, yaw_torque_cutoff=cutoff))


def random_ardupilot(rng, seed):
    return own_ardupilot(AIRFRAMES[seed % 4], **random_gains(LAWS["ardupilot"], rng, {}))


class Case(NamedTuple):
    """A firmware: parts of its sources, its loops with default and random gains, their file, what float32 leaves at rest.

    Attributes:
        has_steps: whether axes without an error are left out of the rounding: ArduPilot's arc cosine near 1 has errors of
            tilt in steps of 0.35 mrad.
    """

    firmware: Firmware
    libraries: ControlLibraries
    parts: list[str]
    own: Callable[..., Controller]
    random: Callable[..., Controller]
    seed: int
    rest: float
    has_steps: bool

    def bundle(self, given):
        """Return the exported file and the controller that it holds."""
        made = of_px4.bundle(given) if self.firmware is px4.PX4_FIRMWARE else of_ardupilot.bundle(given, "4.7")
        return made.files[self.firmware.file], made.held

    def board(self, program, folder, given):
        """Return a board with the gains of a controller, powered up."""
        rotors = actuation(given.airframe.vehicle, self.firmware.curve)
        bench = Bench(program, folder, rotors, given.control_period)
        return self.firmware.install(bench, self.bundle(given)[0])()

    def flown(self, program, folder, given, instants):
        """Return torques of a program (n, 3)."""
        board = self.board(program, folder, given)
        try:
            return board_torques(board, self.firmware, given, instants)
        finally:
            board.close()


CASES = {
    "px4": Case(px4.PX4_FIRMWARE, px4.LIBRARIES, [], own_px4, random_px4, 44, 3e-6, False),
    "ardupilot": Case(ardupilot.ARDUPILOT, ardupilot.LIBRARIES, PARTS, own_ardupilot, random_ardupilot, 45, 1e-3, True),
}


@pytest.fixture(scope="module", params=CASES.values(), ids=[*CASES])
def case(request):
    return request.param


@pytest.fixture(scope="module")
def programs(case, tmp_path_factory):
    """The control libraries in both precisions."""
    folder, sources = tmp_path_factory.mktemp(case.firmware.name), checkout(case.libraries)
    return {
        "single": case.libraries.compile(sources, folder / "in_single"),
        "double": built_in_double(case.libraries, sources, folder, case.parts),
    }


@pytest.mark.slow
def test_its_libraries_turn_the_vehicle_as_our_law_does(case, programs, tmp_path):
    """In double precision; what float32 adds is the libraries' own rounding, for their two builds differ by the same.

    Of 40 controllers with random gains on four airframes.
    """
    apart, rounding, left = [], [], []
    for seed in range(40):
        rng = np.random.default_rng([case.seed, seed])
        given, instants = case.random(rng, seed), motion(rng, seed % 3)
        _, held = case.bundle(given)
        ours = law_torques(held, instants, yaw_smoothing(held.options.yaw_torque_cutoff, held.control_period))
        single, double = (case.flown(programs[name], tmp_path, given, instants) for name in ("single", "double"))
        size = np.abs(ours).max(axis=0)
        apart.append(np.abs(double - ours).max(axis=0) / size)
        rounding.append(np.abs(single - double).max(axis=0) / size)
        left.append(np.abs(np.abs(single - ours).max(axis=0) / size - rounding[-1]))
        if case.has_steps and seed % 3 < 2:
            rounding[-1][seed % 3] = 0.0
    assert np.max(apart) < DOUBLE
    assert np.max(rounding) < SINGLE and np.max(left) < DOUBLE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("airframe", "linear"), [("f450", 0.0), ("f450", 0.4), ("iris", 0.0), ("hummingbird-rotors", 0.0)]
)
def test_armed_it_holds_the_motors_that_hold_the_vehicle(case, programs, tmp_path, airframe, linear):
    """Also a rectangular frame, a plus, and thrust that is no square of the command."""
    given = case.own(airframe)
    vehicle = given.airframe.vehicle._replace(thrust_linear=linear)
    given = replace(given, airframe=replace(given.airframe, vehicle=vehicle))
    rotors, held = actuation(vehicle, case.firmware.curve), (0.52, 0.49, 0.47, 0.505)
    throttle = throttle_for(sum(thrusts_of(held, rotors, case.firmware)) / 4.0, rotors)
    board = case.board(programs["single"], tmp_path, given)
    begin = Instant((0.02, -0.03, 1.1), (0.0, 0.0, 0.0), (0.02, -0.03), 1.1, 0.0)
    try:
        board.arm(begin, throttle, held)
        assert board.step(begin, throttle) == pytest.approx(held, abs=case.rest)
    finally:
        board.close()
