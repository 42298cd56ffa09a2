"""PX4's own control libraries against our law, sample by sample, and what is refused on the way."""

from dataclasses import replace

import numpy as np
import pytest

from plant.backends.instants import Instant
from plant.law_registry import LAWS
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.nominal import yaw_smoothing
from tests.clients.firmware_sources import checkout
from tests.tuner.engines.firmware.in_double import built_in_double
from tests.tuner.engines.firmware.laws_beside import AXES, board_torques, law_torques, motion, random_gains
from tests.tuner.exchange.px4.test_px4 import bundle
from tests.tuner.exchange.px4.test_px4_own_loops import own
from tuner.engines.firmware.firmware import Bench
from tuner.engines.firmware.flying import throttle_for, thrusts_of
from tuner.engines.firmware.px4.bench import LIBRARIES, PX4_FIRMWARE
from tuner.exchange.px4.export import FILE

# Largest difference over the largest torque of an axis; measured over the 40 runs: 4.4e-7 and 4.3e-5.
DOUBLE, SINGLE = 1e-6, 1e-4
# An X, a rectangle, another X and a plus.
AIRFRAMES = ("f450", "iris", "hummingbird", "hummingbird-rotors")


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """PX4's control libraries in both precisions."""
    folder, sources = tmp_path_factory.mktemp("px4"), checkout(LIBRARIES)
    return {
        "single": LIBRARIES.compile(sources, folder / "in_single"),
        "double": built_in_double(LIBRARIES, sources, folder),
    }


def flown(program, folder, given, instants):
    made = bundle(given)
    rotors = actuation(given.airframe.vehicle, PX4_FIRMWARE.curve)
    board = PX4_FIRMWARE.install(Bench(program, folder, rotors, given.control_period), made.files[FILE])()
    try:
        return board_torques(board, PX4_FIRMWARE, given, instants)
    finally:
        board.close()


def controllers():
    """Yield 40 controllers of four airframes with random gains; each second has a notch, two of three a low-pass on yaw's torque."""
    for seed in range(40):
        rng = np.random.default_rng([44, seed])
        notch = rng.uniform(30.0, 120.0) if seed % 2 else 0.0
        given = own(AIRFRAMES[seed % 4], **random_gains(LAWS["px4"], rng, {f"{axis}.notch": notch for axis in AXES}))
        cutoff = float(rng.uniform(0.5, 8.0)) if seed % 3 else 0.0
        yield replace(given, options=replace(given.options, yaw_torque_cutoff=cutoff)), motion(rng, seed % 3)


@pytest.mark.slow
def test_its_libraries_turn_the_vehicle_as_our_law_does(programs, tmp_path):
    """In double precision; what float32 adds is the libraries' own rounding, for their two builds differ by the same."""
    apart, rounding, left = [], [], []
    for given, instants in controllers():
        held = bundle(given).held
        ours = law_torques(held, instants, yaw_smoothing(held.options.yaw_torque_cutoff, held.control_period))
        single, double = (flown(programs[name], tmp_path, given, instants) for name in ("single", "double"))
        size = np.abs(ours).max(axis=0)
        apart.append(np.abs(double - ours).max(axis=0) / size)
        rounding.append(np.abs(single - double).max(axis=0) / size)
        left.append(np.abs(np.abs(single - ours).max(axis=0) / size - rounding[-1]))
    assert len(apart) == 40 and np.max(apart) < DOUBLE
    assert np.max(rounding) < SINGLE and np.max(left) < DOUBLE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("airframe", "linear"), [("f450", 0.0), ("f450", 0.4), ("iris", 0.0), ("hummingbird-rotors", 0.0)]
)
def test_armed_it_holds_the_motors_that_hold_the_vehicle(programs, tmp_path, airframe, linear):
    """Also a rectangular frame, and thrust that is no square of the command."""
    given = own(airframe)
    vehicle = given.airframe.vehicle._replace(thrust_linear=linear)
    given = replace(given, airframe=replace(given.airframe, vehicle=vehicle))
    rotors = actuation(given.airframe.vehicle, PX4_FIRMWARE.curve)
    held = (0.52, 0.49, 0.47, 0.505)
    throttle = throttle_for(sum(thrusts_of(held, rotors, PX4_FIRMWARE)) / 4.0, rotors)
    board = PX4_FIRMWARE.install(
        Bench(programs["single"], tmp_path, rotors, given.control_period), bundle(given).files[FILE]
    )()
    begin = Instant((0.02, -0.03, 1.1), (0.0, 0.0, 0.0), (0.02, -0.03), 1.1, 0.0)
    try:
        board.arm(begin, throttle, held)
        assert board.step(begin, throttle) == pytest.approx(held, abs=3e-6)
    finally:
        board.close()
