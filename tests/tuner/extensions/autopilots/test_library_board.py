"""Control libraries compiled from a checkout that is played: our reading of PX4's loops, and checkouts that are none."""

import shutil
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from tests.clients import program
from tests.tuner.extensions.autopilots.laws_beside import AXES, board_torques, law_torques, motion
from tests.tuner.extensions.autopilots.played import CHECKOUT, LIBRARIES
from tests.tuner.extensions.px4.test_px4 import bundle
from tests.tuner.extensions.px4.test_px4_own_loops import own
from tuner.extensions.autopilots import process
from tuner.extensions.autopilots.firmware import Bench
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.autopilots.libraries import building
from tuner.extensions.autopilots.libraries.board import LibraryBoard, frame, tilt_at_goal
from tuner.extensions.px4.bench import PX4_FIRMWARE, geometry, parameters_of
from tuner.extensions.px4.export import FILE

AIRFRAME, PERIOD = "f450", 0.0025
LEVEL = Instant((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0)
PLAIN = {"gyro_cutoff": 0.0, "notch": 0.0, "d": 0.0, "ff": 0.0}
UNFILTERED = {f"{axis}.{name}": value for axis in AXES for name, value in PLAIN.items()}


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """The program of the played checkout."""
    program("g++")
    return LIBRARIES.compile(CHECKOUT, tmp_path_factory.mktemp("played") / "program")


def bench(binary, folder):
    return Bench(binary, folder, actuation(load(AIRFRAME).vehicle, PX4_FIRMWARE.curve), PERIOD)


def test_a_played_checkout_turns_the_vehicle_as_our_law_does(played, tmp_path):
    """Through file, parameters, frames, axes, motors and rotors."""
    given = own(AIRFRAME, **UNFILTERED)
    made = bundle(given)
    for axis in range(3):
        instants = motion(np.random.default_rng(axis), axis)
        board = PX4_FIRMWARE.install(bench(played, tmp_path / str(axis)), made.files[FILE])()
        try:
            flown = board_torques(board, PX4_FIRMWARE, given, instants)
        finally:
            board.close()
        np.testing.assert_allclose(flown, law_torques(made.held, unturned(instants)), atol=1e-6 * np.abs(flown).max())


def unturned(instants):
    """Return instants without a rate of the heading, which the played loops do not hear."""
    return [replace(asked, yaw_rate=0.0) for asked in instants]


def test_armed_it_holds_the_motors_that_hold_the_vehicle(played, tmp_path):
    held = (0.52, 0.49, 0.47, 0.505)
    board = PX4_FIRMWARE.install(bench(played, tmp_path), bundle(own(AIRFRAME, **UNFILTERED)).files[FILE])()
    try:
        throttle = float(np.sqrt(np.mean(np.square(held))))
        board.arm(LEVEL, throttle, held)
        assert board.step(LEVEL, throttle) == pytest.approx(held, rel=1e-12)
    finally:
        board.close()


def test_a_frame_is_in_the_axes_of_the_firmware():
    asked = Instant((0.1, 0.2, -0.3), (1.0, 2.0, 3.0), (-0.1, -0.2), -0.3, 9.0, 0.7)
    expected = (1.0, -2.0, -3.0, 0.1, -0.2, 0.3, -0.1, 0.2, 0.3, -0.7, 0.5)
    assert frame(asked, 0.5) == pytest.approx(expected, rel=1e-12)


def test_the_thrust_is_asked_for_in_its_direction_whatever_the_heading():
    """The tilt is that of the measured heading, and the firmware's set point has the heading that is asked for."""
    asked = Instant((0.0, 0.0, 0.4), (0.0, 0.0, 0.0), (0.3, -0.2), 1.1, 9.0)
    up = np.array([0.0, 0.0, 1.0])
    wanted = body_to_earth(0.3, -0.2, 0.4) @ up
    np.testing.assert_allclose(body_to_earth(*tilt_at_goal(asked), 1.1) @ up, wanted, atol=1e-12)


def body_to_earth(roll, pitch, yaw):
    """Return the rotation matrix of roll, pitch and yaw."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(angle), np.sin(angle)) for angle in (roll, pitch, yaw))
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    return np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]]) @ about_y @ about_x


def test_parameters_of_the_file_go_before_defaults(tmp_path):
    parameters = parameters_of(bench("", tmp_path), bundle(own(AIRFRAME)).files[FILE])
    assert parameters["IMU_GYRO_NF0_FRQ"] == 85.0 and parameters["IMU_GYRO_NF1_FRQ"] == 0.0
    assert parameters["IMU_GYRO_RATEMAX"] == pytest.approx(400.0)
    assert not [name for name in parameters if name.startswith("MPC_")]


def test_the_geometry_is_what_the_file_says_in_its_comment(tmp_path):
    """Rotors in our order: front left stands ahead and to the left, y below 0, and turns clockwise: KM below 0."""
    values = geometry(actuation(load(AIRFRAME).vehicle))
    assert values["CA_ROTOR0_PX"] > 0.0 > values["CA_ROTOR0_PY"] and values["CA_ROTOR0_KM"] < 0.0
    text = bundle(own(AIRFRAME)).files[FILE].decode()
    assert f"(front left) PX {values['CA_ROTOR0_PX']:.4g} m, PY {values['CA_ROTOR0_PY']:.4g} m" in text


def test_a_line_of_the_file_that_holds_no_parameter_is_refused(tmp_path):
    with pytest.raises(InputError, match="which stores no parameter"):
        parameters_of(bench("", tmp_path), b"# Stack: PX4 Pro\n1\t1\tMC_ROLLRATE_P\t0.1\n")


def test_a_parameter_that_is_missing_is_told(played):
    with pytest.raises(InputError, match=r"cannot be run: the firmware reads IMU_GYRO_RATEMAX, which has no value"):
        LibraryBoard(played, {})


def test_a_parameter_that_nothing_reads_is_told(tmp_path):
    program("g++")
    text = (LIBRARIES.source).read_text().replace("bench::unread.clear();", "")
    source = tmp_path / "loops.cpp"
    source.write_text(text)
    made = replace(LIBRARIES, source=source).compile(CHECKOUT, tmp_path / "program")
    names = (
        "IMU_GYRO_RATEMAX",
        "THR_MDL_FAC",
        *(f"MC_{axis}{end}" for axis in ("ROLL", "PITCH", "YAW") for end in ENDS),
    )
    with pytest.raises(InputError, match="cannot be run: nothing here reads MC_BAT_SCALE_EN, MC_ROLLRATE_K;"):
        LibraryBoard(made, dict.fromkeys((*names, "MC_ROLLRATE_K", "MC_BAT_SCALE_EN"), 1.0))


ENDS = ("_P", "RATE_P", "RATE_I")
WAYS = {
    "silent": ("exec sleep 60", "does not answer within 2 s"),
    "dies": ("exit 3", "ended by itself, with exit code 3"),
    "killed": ("kill -9 $$", "ended by itself, with exit code -9"),
}


@pytest.mark.parametrize(("text", "problem"), WAYS.values(), ids=WAYS)
def test_a_program_that_misbehaves_is_told_in_one_line(tmp_path, monkeypatch, text, problem):
    monkeypatch.setattr(process, "PATIENCE", 2.0)
    script = tmp_path / "program"
    script.write_text(f"#!/bin/sh\n{text}\n")
    script.chmod(0o755)
    with pytest.raises(InputError, match=problem) as caught:
        LibraryBoard(script, {})
    assert "\n" not in str(caught.value) and "docs/how_to/confirm.md" in str(caught.value)


def test_a_program_that_dies_in_flight_is_told(played, tmp_path):
    board: Any = PX4_FIRMWARE.install(bench(played, tmp_path), bundle(own(AIRFRAME)).files[FILE])()
    try:
        board._process._process.kill()
        with pytest.raises(InputError, match="ended by itself, with exit code -9"):
            for _ in range(3):
                board.step(LEVEL, 0.5)
    finally:
        board.close()


@pytest.mark.slow
def test_a_checkout_is_compiled_into_a_folder_of_this_user(tmp_path, monkeypatch):
    program("g++")
    monkeypatch.setenv("TUNER_CACHE_DIR", str(tmp_path / "cache"))
    made = LIBRARIES.program(CHECKOUT)
    assert made.parent == tmp_path / "cache" / "firmware" and made.parent.stat().st_mode & 0o077 == 0
    assert [path.name for path in made.parent.iterdir()] == [made.name] and LIBRARIES.program(CHECKOUT) == made
    assert LIBRARIES.program(made) == made


def test_a_folder_that_is_no_checkout_is_told(tmp_path):
    with pytest.raises(InputError, match=r"holds no loops.hpp; give the folder of the played sources"):
        LIBRARIES.program(tmp_path)


def test_sources_that_cannot_be_compiled_are_told_in_one_line(tmp_path):
    program("g++")
    shutil.copytree(CHECKOUT, tmp_path / "sources")
    with (tmp_path / "sources" / "loops.hpp").open("a") as header:
        header.write("\nint broken = nothing;\n")
    with pytest.raises(InputError, match="cannot be compiled: .*nothing") as caught:
        LIBRARIES.compile(tmp_path / "sources", tmp_path / "program")
    assert "\n" not in str(caught.value)


def test_a_machine_without_a_compiler_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(building.shutil, "which", lambda _: None)
    with pytest.raises(InputError, match="no C\\+\\+ compiler"):
        LIBRARIES.compile(CHECKOUT, tmp_path / "program")
