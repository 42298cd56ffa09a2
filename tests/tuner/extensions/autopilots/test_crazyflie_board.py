"""The Crazyflie's board around a module that is played, which is our reading of its loops, and around modules that misbehave."""

import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant.errors import InputError
from plant.law_registry import LAWS
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.rigid_body import rotor_torque
from plant.records import pack
from plant.vectors import Rotors
from tests.clients import program
from tests.clients.crazyflie_firmware import build
from tests.tuner.extensions.autopilots.played import PLAYED, played_in
from tests.tuner.extensions.crazyflie.test_crazyflie_own_loops import own
from tests.tuner.extensions.crazyflie.test_crazyflie_parameters import request
from tuner.extensions.autopilots import process
from tuner.extensions.autopilots.firmware import Bench
from tuner.extensions.autopilots.flying import thrusts_of
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.crazyflie import board
from tuner.extensions.crazyflie.bench import CRAZYFLIE, install, interpreter_for, module_in, parameters_of
from tuner.extensions.crazyflie.board import CrazyflieBoard, frame
from tuner.extensions.crazyflie.export import FILE, TARGET
from tuner.extensions.crazyflie.map import TABLE
from tuner.extensions.crazyflie.stabilizer import FILTERS, SETTERS

AIRFRAME, PERIOD, AXES = "crazyflie-pybullet", 0.002, ("roll", "pitch", "yaw")
LEVEL = Instant((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0)
HOVER = (0.5, 0.5, 0.5, 0.5)
UNFILTERED: dict[str, Any] = {f"{axis}__gyro_cutoff": 0.0 for axis in AXES}


@pytest.fixture
def module(tmp_path):
    """A folder with the played module, as a build leaves its own."""
    return played_in(tmp_path)


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    """Nobody waits long in a test."""
    monkeypatch.setattr(process, "PATIENCE", 2.0)


def file_of(given):
    return TARGET.export(request(given)).files[FILE]


def bench(module, folder):
    return Bench(module, folder, actuation(load(AIRFRAME).vehicle, CRAZYFLIE.curve), PERIOD)


def powered(module, folder, given):
    return install(bench(module, folder), file_of(given))()


def misbehaving(module, text):
    """A module of which the Python does something else, beside the library."""
    module.with_name("cffirmware.py").write_text(text)
    return module


def law_torques(given, instants):
    """Torques [N m] that our law answers to instants, axis by axis."""
    ours, gains, vehicle = LAWS["crazyflie"], pack(given.cascade.Gains, given.gains), given.airframe.vehicle
    found = np.zeros((len(instants), 3))
    for i, axis in enumerate(AXES):
        constants = ours.prepare(getattr(gains, axis)._replace(i_limit=1e9), PERIOD)
        memory = ours.start(constants, Measured(instants[0].angles[i], 0.0), 0.0)
        for k, asked in enumerate(instants):
            goal = Setpoint((*asked.tilt, asked.yaw)[i], 0.0, 0.0)
            seen, channel = Measured(asked.angles[i], asked.rate[i]), Channel(1.0 / vehicle.inertia[i], 0.0)
            found[k, i], memory = ours.step(memory, constants, channel, goal, seen, Applied(0.0, 0.0), PERIOD)
    return found


def board_torques(powered_board, given, instants):
    """Torques [N m] of the rotors that a board commands at instants, armed where they begin."""
    vehicle, rotors = given.airframe.vehicle, actuation(given.airframe.vehicle, CRAZYFLIE.curve)
    powered_board.arm(instants[0], 0.5, HOVER)
    found = []
    for asked in instants:
        thrusts = Rotors(*thrusts_of(powered_board.step(asked, 0.5), rotors, CRAZYFLIE))
        found.append(rotor_torque(thrusts, vehicle.rotor_x, vehicle.rotor_y, vehicle.spin, vehicle.torque_ratio))
    return np.array(found)


def wandering(turning, count=200):
    """Instants of angles, rates and set points that wander about all axes."""
    sizes = [*[2e-4] * 3, *[turning] * 3, *[2e-4] * 3]
    paths = np.cumsum(np.random.default_rng(7).normal(0.0, sizes, (count, 9)), axis=0).tolist()
    return [Instant(tuple(row[:3]), tuple(row[3:6]), tuple(row[6:8]), row[8], 0.0) for row in paths]


def counts_of_torque(given, counts):
    """Torques [N m] of so many counts of one motor."""
    vehicle = given.airframe.vehicle
    lever = (abs(vehicle.rotor_y[0]), abs(vehicle.rotor_x[0]), vehicle.torque_ratio)
    return counts * actuation(vehicle).thrust_max / 65535.0 * np.array(lever)


def assert_it_turns_as_our_law_does(program, bench, turning):
    """Torques of a module beside those of our law, over wandering instants that turn so fast."""
    given = own(**UNFILTERED)
    instants = wandering(turning=turning)
    made = powered(program, bench, given)
    try:
        found = board_torques(made, given, instants)
    finally:
        made.close()
    expected = law_torques(given, instants)
    assert np.all(np.abs(found - expected).max(axis=0) < counts_of_torque(given, 12.0))
    assert np.all(np.abs(expected).max(axis=0) > counts_of_torque(given, 400.0))


def test_a_played_module_turns_the_vehicle_as_our_law_does(module, tmp_path):
    """Through file, degrees, signs, frames, counts, motors and rotors; what is left are whole counts of outputs and motors."""
    assert_it_turns_as_our_law_does(module, tmp_path / "bench", turning=1e-3)


@pytest.mark.slow
def test_the_firmware_turns_the_vehicle_as_our_law_does(tmp_path):
    """As above at rates of 0, for its gyro is filtered."""
    assert_it_turns_as_our_law_does(module_in(build()), tmp_path / "bench", turning=0.0)


@pytest.mark.slow
def test_parameters_are_those_that_the_firmwares_source_ties_to_these_objects():
    source = build().parent / "src/modules/src/controller/attitude_pid_controller.c"
    if not source.is_file():
        pytest.skip(f"{source} is not there: the build stands without its sources")
    text, group, found = source.read_text(), "", {}
    for line in text.splitlines():
        if start := re.match(r"PARAM_GROUP_START\((\w+)\)", line):
            group = start[1]
        if entry := re.match(r"PARAM_ADD\([^,]+, (\w+), &(pid\w+)\.(k\w+)\)", line):
            found[f"{group}.{entry[1]}"] = (entry[2], f"pidSetK{entry[3][1:]}")
    assert found == SETTERS


@pytest.mark.parametrize("where", ["played", pytest.param("firmware", marks=pytest.mark.slow)])
def test_armed_it_holds_the_motors_that_hold_the_vehicle(where, module, tmp_path):
    """Its integrals are filled by hand: with no error left, the motors are those that were given, to a few counts."""
    held, angles = (0.52, 0.49, 0.47, 0.505), (0.02, -0.03, 1.1)
    begin = Instant(angles, (0.1, 0.2, 0.3), (0.3, 0.3), 0.0, 0.0)
    still = Instant(angles, (0.0, 0.0, 0.0), (angles[0], angles[1]), angles[2], 0.0)
    made = powered(module if where == "played" else module_in(build()), tmp_path / "bench", own())
    try:
        throttle = sum(held) / 4.0
        made.arm(begin, throttle, held)
        assert made.step(still, throttle) == pytest.approx(held, abs=5.0 / 65535.0)
    finally:
        made.close()


def test_equal_flights_are_equal_to_the_last_bit(module, tmp_path):
    given, instants = own(), wandering(turning=1e-2, count=50)
    flown = []
    for _ in range(2):
        made = powered(module, tmp_path / "bench", given)
        try:
            flown.append(board_torques(made, given, instants))
        finally:
            made.close()
    np.testing.assert_array_equal(*flown)


def test_a_frame_is_in_the_firmwares_units():
    asked = Instant((0.1, 0.2, 0.3), (1.0, 2.0, 3.0), (-0.1, -0.2), -0.3, 9.0)
    expected = (1.0, 2.0, 3.0, 0.1, -0.2, 0.3, -0.1, 0.2, -0.3)
    assert frame(asked, 0.5) == pytest.approx((*np.degrees(expected), 32767.5))


def test_the_file_sets_all_of_the_attitude_loops():
    given = own(roll__d_cutoff=45.0, pitch__d_cutoff=50.0, yaw__d_cutoff=55.0)
    found = parameters_of(file_of(given))
    assert found.keys() == {name for name in TABLE if not name.startswith(("posCtlPid", "velCtlPid"))}
    assert found["pid_rate.rateFiltEn"] == 1.0 and [found[name] for name in FILTERS] == [45.0, 50.0, 55.0]
    assert found["pid_rate.roll_kp"] == 310.0 and found["pid_attitude.yaw_kd"] == pytest.approx(0.2)


def test_a_parameter_that_nothing_sets_is_refused():
    text = "params:\n  pid_attitude.yawMaxDelta: {is_stored: true, default_value: 0.0, stored_value: 5.0}\n"
    with pytest.raises(InputError, match="pid_attitude.yawMaxDelta: .*nothing that sets"):
        parameters_of(text.encode())


def test_a_line_that_stores_nothing_is_refused():
    with pytest.raises(InputError, match="which stores no parameter"):
        parameters_of(b"params:\n  pid_rate.roll_kp: 250\n")


WAYS = {
    "absent": (
        "raise ModuleNotFoundError('No module named numpy')",
        "cannot be run: ModuleNotFoundError: No module named numpy",
    ),
    "dies": ("raise SystemExit(3)", f"ended by itself, with exit code 3, under {re.escape(sys.executable)}"),
    "killed": ("import os; os.kill(os.getpid(), 9)", "ended by itself, with exit code -9"),
    "silent": ("import threading; threading.Event().wait()", "does not answer within 2 s"),
    "another": ("_cffirmware = __import__('os')", "cannot be run: "),
}


@pytest.mark.parametrize(("text", "said"), WAYS.values(), ids=WAYS)
def test_a_module_that_is_none_is_told_in_one_line(module, tmp_path, text, said):
    begin = time.monotonic()
    with pytest.raises(InputError, match=said) as caught:
        powered(misbehaving(module, text), tmp_path / "bench", own())
    assert "\n" not in str(caught.value) and "docs/how_to/confirm.md" in str(caught.value)
    assert time.monotonic() - begin < 10.0


def test_answers_that_are_none_are_told(module, tmp_path, monkeypatch):
    monkeypatch.setattr(board, "STABILIZER", tmp_path / "babbles.py")
    board.STABILIZER.write_text("print('hello')\n")
    with pytest.raises(InputError, match="answers with nonsense") as caught:
        powered(module, tmp_path / "bench", own())
    assert "\n" not in str(caught.value)


def test_a_library_without_the_firmwares_functions_is_told(module, tmp_path):
    source = tmp_path / "empty.c"
    source.write_text("int nothing;\n")
    subprocess.run([program("gcc"), "-shared", "-fPIC", "-o", str(module), str(source)], check=True)
    text = f"from types import SimpleNamespace\n_cffirmware = SimpleNamespace(__file__={str(module)!r})\n"
    with pytest.raises(InputError, match=r"cannot be run: AttributeError: .*lpf2pApply"):
        powered(misbehaving(module, text), tmp_path / "bench", own())


def test_a_process_that_dies_in_flight_is_told(module, tmp_path):
    made = powered(module, tmp_path / "bench", own())
    try:
        made.arm(LEVEL, 0.5, HOVER)
        running: Any = made._process
        running._process.kill()
        with pytest.raises(InputError, match="ended by itself, with exit code -9"):
            for _ in range(3):
                made.step(LEVEL, 0.5)
    finally:
        made.close()


def test_a_module_whose_motors_turn_without_thrust_is_told(module, tmp_path):
    text = (
        PLAYED / "cffirmware.py"
    ).read_text() + "\n\ndef powerDistributionCap(asked, given):\n    given.motors.m2 = 99\n"
    made = powered(misbehaving(module, text), tmp_path / "bench", own())
    try:
        with pytest.raises(InputError, match="turns its motors at no thrust"):
            made.arm(LEVEL, 0.5, HOVER)
    finally:
        made.close()


def test_the_module_of_a_build_is_found(module, tmp_path):
    assert module_in(tmp_path) == module == module_in(module)
    assert module_in(tmp_path / "missing") == tmp_path / "missing"
    shutil.copy(module, tmp_path / "_cffirmware.cpython-311-x86_64-linux-gnu.so")
    with pytest.raises(InputError, match="one _cffirmware.* is needed"):
        module_in(tmp_path)
    module.unlink()
    (tmp_path / "_cffirmware.cpython-311-x86_64-linux-gnu.so").unlink()
    with pytest.raises(InputError, match="holds none"):
        module_in(tmp_path)


def test_a_module_runs_under_the_python_that_it_was_built_for(tmp_path, monkeypatch):
    major, minor = sys.version_info[:2]
    own_tag, other = f"_cffirmware.cpython-{major}{minor}-x86_64-linux-gnu.so", "_cffirmware.cpython-36m-darwin.so"
    assert interpreter_for(Path("_cffirmware.so")) == interpreter_for(Path(own_tag)) == Path(sys.executable)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match=r"cannot be run: it was built for Python 3.6, and there is no python3.6"):
        interpreter_for(Path(other))
    python = tmp_path / "python3.6"
    python.write_text("#!/bin/sh\n")
    python.chmod(0o755)
    assert interpreter_for(Path(other)) == python


def test_a_python_that_cannot_be_run_is_told(module, tmp_path):
    with pytest.raises(InputError, match="cannot be run: "):
        CrazyflieBoard(tmp_path / "no_python", module, {})


def test_an_axis_without_an_integral_is_not_turned():
    x, y, z = board.turning((0.51, 0.48, 0.51, 0.52), {"pid_rate.roll_ki": 500.0, "pid_rate.pitch_ki": 0.0})
    assert x < 0.0 and y == z == 0.0
