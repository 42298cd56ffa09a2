"""The board against programs that misbehave, and its packets against our own attitude: one line, no hang, nothing left behind."""

import math
import os
import stat
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load as load_airframe
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.attitude import euler_angles
from plant.vectors import Quaternion
from tests.clients import program
from tuner.extensions.autopilots.firmware import Bench
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.betaflight import board, command_line
from tuner.extensions.betaflight.bench import install
from tuner.extensions.betaflight.board import BetaflightBoard, Sticks, attitude, shim_in
from tuner.extensions.betaflight.command_line import load
from tuner.extensions.betaflight.wiring import PACKET_WIRING

STICKS = Sticks(30.0, 100.0)
LEVEL = Instant((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0)
# Ways to be no firmware, in Python: what the program does with sockets where the firmware has its own.
DIES = "raise SystemExit(3)"
SILENT = "import threading; threading.Event().wait()"
BABBLES = """
import socket
door = socket.socket()
door.bind(("127.0.0.1", 5761))
door.setblocking(True)
line = door.accept()[0]
while True:
    line.sendall(b"\\xff\\x00garbage" * 9)
"""


@pytest.fixture(autouse=True)
def soon(monkeypatch):
    """Nobody waits long in a test."""
    monkeypatch.setattr(board, "PATIENCE", 2.0)
    monkeypatch.setattr(board, "WAKING", 0.01)
    monkeypatch.setattr(board, "SETTLING", 0.01)
    for name, value in {"OPENING": 0.3, "MOMENT": 0.05, "PAUSE": 0.02, "PATIENCE": 0.3, "STARTS": 2}.items():
        monkeypatch.setattr(command_line, name, value)


@pytest.fixture(scope="module")
def shim(tmp_path_factory):
    program("gcc")
    return shim_in(tmp_path_factory.mktemp("shim"))


def fake(folder, text):
    """A program of Python that stands for the firmware, with settings to copy."""
    file = folder / "firmware"
    file.write_text(f"#!{sys.executable} -S\n{text}\n")
    file.chmod(file.stat().st_mode | stat.S_IXUSR)
    (folder / "eeprom.bin").write_bytes(b"settings")
    return file


def compiled(folder, name, *options):
    """A program in C that stands for the firmware, with settings to copy."""
    made, source = fake(folder, ""), Path(__file__).with_name(name)
    subprocess.run([program("gcc"), *options, "-o", str(made), str(source), "-lpthread"], check=True)
    return made


def speaks(folder, size):
    """A program with the firmware's sockets and threads, that answers with so many bytes."""
    return compiled(folder, "speaks.c", f"-DSIZE={size}")


@pytest.mark.parametrize(
    ("text", "said"),
    [(DIES, "exit code 3"), (SILENT, "does not answer within")],
    ids=["dies", "silent"],
)
def test_a_program_that_does_not_fly_is_told_in_one_line(tmp_path, shim, monkeypatch, text, said):
    temporary, begin = tmp_path / "temporary", time.monotonic()
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    with pytest.raises(InputError, match=said) as caught:
        BetaflightBoard(fake(tmp_path, text), tmp_path, shim, STICKS, 0.00025, PACKET_WIRING)
    assert "\n" not in str(caught.value)
    assert time.monotonic() - begin < 10.0
    assert not os.listdir(temporary)


def test_motors_of_another_size_are_told(tmp_path, shim):
    with pytest.raises(InputError, match="answered with 7 bytes, four motors are 16"):
        BetaflightBoard(speaks(tmp_path, 7), tmp_path, shim, STICKS, 0.00025, PACKET_WIRING)


def test_a_program_that_dies_in_flight_is_told(tmp_path, shim):
    made = BetaflightBoard(speaks(tmp_path, 16), tmp_path, shim, STICKS, 0.00025, PACKET_WIRING)
    try:
        assert made.step(LEVEL, 0.5) == (0.0, 0.0, 0.0, 0.0)
        process: Any = made._process
        process.kill()
        with pytest.raises(InputError, match="ended by itself, with exit code -9"):
            for _ in range(3):
                made.step(LEVEL, 0.5)
    finally:
        made.close()


def test_sticks_count_in_the_period_that_they_were_given_for(tmp_path, shim):
    """On a busy machine too: a packet that a thread has in hand, but is not done with, is waited for."""
    made = BetaflightBoard(
        compiled(tmp_path, "slow_sticks.c", "-rdynamic"), tmp_path, shim, STICKS, 0.00025, PACKET_WIRING
    )
    throttles = (0.2, 0.7, 0.3, 0.9)
    try:
        found = [made.step(LEVEL, throttle)[0] for throttle in throttles]
    finally:
        made.close()
    assert found == pytest.approx(throttles, abs=1e-6)


def test_a_program_that_does_not_arm_is_told(tmp_path, shim):
    made = BetaflightBoard(speaks(tmp_path, 16), tmp_path, shim, STICKS, 0.00025, PACKET_WIRING)
    try:
        with pytest.raises(InputError, match="does not arm"):
            made.arm(LEVEL, 0.5, (0.5, 0.5, 0.5, 0.5))
    finally:
        made.close()


@pytest.mark.parametrize("text", [DIES, SILENT, BABBLES], ids=["dies", "silent", "babbles"])
def test_a_command_line_that_is_none_is_told_in_one_line(tmp_path, shim, text):
    with pytest.raises(InputError, match="no command line answers after 2 starts"):
        load(fake(tmp_path, text), tmp_path, shim, ["save"])


@pytest.mark.parametrize("angles", [(0.3, -0.2, 0.9), (-0.5, 0.4, -2.8), (0.0, 0.0, 0.0)])
def test_the_attitude_is_ours_with_nose_up_and_clockwise_positive(angles):
    w, x, y, z = attitude(angles)
    np.testing.assert_allclose(euler_angles(Quaternion(w, x, -y, -z)), angles, atol=1e-12)


def test_sticks_are_set_points():
    asked = Instant(LEVEL.angles, LEVEL.rate, (math.radians(15.0), math.radians(-60.0)), math.radians(10.0), 1.0)
    assert STICKS.channels(asked, 0.321) == (1750, 1000, 1321, 1450)


def test_the_library_that_keeps_step_warns_of_nothing(tmp_path):
    source = board.__file__.replace("board.py", "lockstep.c")
    command = [program("gcc"), "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-o", str(tmp_path / "l.so"), source]
    subprocess.run([*command, "-ldl"], check=True)


def test_a_path_that_no_loader_takes_is_refused(tmp_path):
    program("gcc")
    folder = tmp_path / "a b"
    folder.mkdir()
    with pytest.raises(InputError, match="set TMPDIR to another"):
        shim_in(folder)


def test_rotors_in_a_plus_are_refused(tmp_path):
    bench = Bench(
        tmp_path / "program", tmp_path / "bench", actuation(load_airframe("hummingbird-rotors").vehicle), 0.001
    )
    with pytest.raises(InputError, match="frame is a plus"):
        install(bench, b"set angle_limit = 30\n")
