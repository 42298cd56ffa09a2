"""PX4 parameter files read back: what was exported, K and D of the rate loops, defaults, and files that are none."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plant.errors import InputError, UnknownNameError
from plant.quadrotor.nominal import ControlOptions
from tests.tuner.exchange.controllers import pid
from tests.tuner.exchange.flying_autopilots import attitude_feedback, attitude_gains, by_address, px4_torque
from tests.tuner.exchange.reading import exported, read, same_flight, write
from tuner.exchange.registry import importer, importers
from tuner.extensions.px4.export import FILE, TARGET

STIFF: dict[str, Any] = {"z__kp": 7.0, "z__ki": 1.5, "z__kd": 6.0}


def line(name, value, kind=9, vehicle=1):
    return f"{vehicle}\t1\t{name}\t{value}\t{kind}\n"


@pytest.mark.parametrize("airframe", ["hummingbird", "iris", "hummingbird-rotors"])
@pytest.mark.parametrize("settings", [(), ("thrust_model=local",), ("thrust_curve=0.4",)])
def test_an_export_comes_back_as_what_it_holds(airframe, settings, tmp_path):
    given = replace(pid(airframe, **STIFF), options=ControlOptions(tilt_limit=0.7))
    made = exported(TARGET, given, *settings)
    curve = [setting for setting in settings if setting.startswith("thrust_curve")]
    back = read("px4", write(tmp_path, made.files[FILE]), *curve, airframe=airframe)
    assert same_flight(back.controller, made.held)
    assert back.controller.control_period == 0.0025
    assert not any("Not in the file" in note for note in back.notes)


def test_k_scales_p_and_i(tmp_path):
    """K = 2 with half of P, I is the same loop; K = 2 with P, I as they were is another."""
    made = exported(TARGET, pid(**STIFF))
    text = made.files[FILE].decode()
    values = {row.split("\t")[2]: float(row.split("\t")[3]) for row in text.splitlines() if not row.startswith("#")}
    halved = {
        **values,
        "MC_ROLLRATE_K": 2.0,
        **{f"MC_ROLLRATE_{term}": 0.5 * values[f"MC_ROLLRATE_{term}"] for term in "PI"},
    }
    content = "".join(line(name, repr(value)) for name, value in halved.items())
    back = read("px4", write(tmp_path, content))
    assert np.allclose(back.controller.gains, made.held.gains, rtol=1e-12)
    assert any("MC_ROLLRATE_K = 2" in note for note in back.notes)
    doubled = "".join(line(name, value) for name, value in {**values, "MC_YAWRATE_K": 2.0}.items())
    there, here = by_address(read("px4", write(tmp_path, doubled)).controller), by_address(made.held)
    assert there["yaw.kd"] == pytest.approx(2.0 * here["yaw.kd"], rel=1e-6)
    assert there["yaw.ki"] == pytest.approx(2.0 * here["yaw.ki"], rel=1e-6)
    assert there["roll.kd"] == pytest.approx(here["roll.kd"], rel=1e-6)


@pytest.mark.parametrize(
    ("version", "cutoff"), [("1.14.3", 0.0), ("1.15.4", 0.0), ("1.16.0", 2.0), ("1.17.0", 2.0), ("", 2.0)]
)
def test_a_version_without_the_filter_of_yaw_flies_without_it(version, cutoff, tmp_path):
    """PX4 1.14 with yaw gains times 1.8 was "better" behind a filter that it does not have."""
    head = "# Stack: PX4 Pro\n" + (f"# Version: {version}\n" if version else "")
    rates = "".join(line(f"MC_{axis}RATE_P", 0.15) for axis in ("ROLL", "PITCH", "YAW"))
    back = read("px4", write(tmp_path, head + rates))
    assert back.controller.options.yaw_torque_cutoff == cutoff
    assert any("MC_YAW_TQ_CUTOFF = 0" in note for note in back.notes) == (cutoff == 0.0)
    given = read("px4", write(tmp_path, head + rates + line("MC_YAW_TQ_CUTOFF", 3.0)))
    assert given.controller.options.yaw_torque_cutoff == 3.0


def test_a_vehicles_own_file_flies_as_px4_would(tmp_path):
    """PX4's defaults but for a few, on the Iris, whose curve the vehicle does not undo; D left out."""
    values = {
        "MC_ROLLRATE_P": 0.15,
        "MC_ROLLRATE_I": 0.2,
        "MC_ROLLRATE_K": 1.3,
        "MC_ROLL_P": 6.5,
        "MC_PITCHRATE_P": 0.15,
        "MC_PITCHRATE_I": 0.2,
        "MC_PITCHRATE_K": 1.0,
        "MC_PITCH_P": 6.5,
        "MC_YAWRATE_P": 0.2,
        "MC_YAWRATE_I": 0.1,
        "MC_YAWRATE_K": 1.0,
        "MC_YAW_P": 2.8,
        "THR_MDL_FAC": 0.0,
    }
    content = (
        line("MC_ROLLRATE_K", 1.3)
        + line("MC_ROLL_P", 6.5)
        + line("MC_PITCH_P", "6.5e0")
        + line("SYS_AUTOSTART", 4001, 6)
    )
    back = read("px4", write(tmp_path, content), airframe="iris")
    vehicle = back.controller.airframe.vehicle
    flown, _ = attitude_feedback(lambda *motion: px4_torque(values, vehicle, 1.0, *motion), vehicle)
    assert attitude_gains(back.controller) == pytest.approx(flown, rel=1e-6)
    notes = "\n".join(back.notes)
    assert "MC_PITCHRATE_P = 0.15" in notes and "MPC_XY_P = 0.95" in notes and "MC_ROLL_P =" not in notes
    assert "MC_ROLLRATE_D (" in notes and "left out" in notes and "MC_YAW_TQ_CUTOFF = 2" in notes
    assert "MPC_THR_HOVER is not in the file" in notes
    assert back.controller.options.tilt_limit == pytest.approx(np.radians(45.0))


def test_derivative_counted_as_inertia(tmp_path):
    """J w' = G (P e - D w') is (J + G D) w' = G P e: every gain of the axis falls by the same factor."""
    content = line("MC_ROLLRATE_D", 0.002)
    dropped = by_address(read("px4", write(tmp_path, content), airframe="iris").controller)
    counted = by_address(read("px4", write(tmp_path, content), "rate_derivative=inertia", airframe="iris").controller)
    # The Iris: 2 sqrt 2 times the short arm and the slope of thrust at hover, over J.
    slope = 7.0664 * 2.0 * np.sqrt(1.545 * 9.81 / 4.0 / 7.0664)
    share = 0.002 * 2.0 * np.sqrt(2.0) * 0.13 * slope / 0.029125
    for gain in ("kp", "ki", "kd"):
        assert dropped[f"roll.{gain}"] / counted[f"roll.{gain}"] == pytest.approx(1.0 + share, rel=1e-4)
    assert dropped["yaw.kp"] == counted["yaw.kp"]
    assert dropped["x.kd"] == pytest.approx(counted["x.kd"] * (1.0 + 0.2 * 9.81 / 9.80665))


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (line("MC_ROLL_P", "nan"), "MC_ROLL_P: given 'nan'; this must be a finite number"),
        (line("MC_ROLL_P", 4) + line("MC_ROLL_P", 5), "MC_ROLL_P: given twice, as 4 and as 5"),
        (line("MC_ROLL_P", 4) + line("MC_ROLL_P", 4, vehicle=2), "holds vehicles 1, 2"),
        ("MC_ROLL_P,4.0\n", "line 1: must be five columns"),
        ("1\t1\tMC_ROLL_P\t4.0\t2\n", "line 1: must be five columns"),
        ("# nothing\n", "holds no parameter"),
        ("# Stack: ArduPilot\n" + line("MC_ROLL_P", 4), "# Stack: is a file of ArduPilot, not of PX4"),
        (line("MC_ROLLRATE_P", 0.0) + line("MC_ROLLRATE_I", 0.0), "roll.kp: "),
    ],
)
def test_what_is_no_such_file_is_refused(content, words, tmp_path):
    with pytest.raises(InputError, match=rf"vehicle.txt: .*{words}|vehicle.txt: {words}"):
        read("px4", write(tmp_path, content))


def test_the_same_number_twice_and_windows_line_ends_are_read(tmp_path):
    content = (line("MC_ROLL_P", 4) + line("MC_ROLL_P", "4.0") + line("MPC_TILTMAX_AIR", 80)).replace("\n", "\r\n")
    back = read("px4", write(tmp_path, "\ufeff" + content))
    assert any("MPC_TILTMAX_AIR = 80 deg is cut to 60.2 deg" in note for note in back.notes)
    assert back.controller.options.tilt_limit == 1.05


def test_another_version_and_no_heading_loop_are_said(tmp_path):
    content = "# Stack: PX4 Pro\n# Version: 1.12.3\n" + line("MC_YAW_WEIGHT", 0)
    notes = "\n".join(read("px4", write(tmp_path, content), airframe="iris").notes)
    assert "The file is of version 1.12.3" in notes and "MC_YAW_WEIGHT = 0" in notes
    plain = "# Version: 1.16.2\n" + line("MC_YAW_WEIGHT", 0.4)
    assert "The file says" not in "\n".join(read("px4", write(tmp_path, plain), airframe="iris").notes)


def test_options_reach_the_controller(tmp_path):
    file = write(tmp_path, line("MC_ROLL_P", 4))
    back = read("px4", file, "control_period=0.004", "attitude_filter=0.003", "position_filter=0.02").controller
    gains = by_address(back)
    assert (back.control_period, back.plant_step) == (0.004, 0.004)
    assert (gains["roll.t_f"], gains["z.t_f"]) == (0.003, 0.02)
    assert read("px4", file, airframe="hummingbird-rotorpy").controller.plant_step <= 0.0025
    with pytest.raises(InputError, match="control_period"):
        read("px4", file, "control_period=1")


@pytest.mark.parametrize("loops", ["own", "pid"])
def test_the_rate_of_the_loops_is_the_control_period(loops, tmp_path):
    file = write(tmp_path, line("MC_ROLL_P", 4) + line("IMU_GYRO_RATEMAX", 800, kind=6))
    advice = "IMU_GYRO_RATEMAX = 800: import with --set control_period=0.00125"
    notes = "\n".join(read("px4", file, f"loops={loops}").notes)
    assert advice in notes and "cannot carry these" not in notes
    back = read("px4", file, f"loops={loops}", "control_period=0.00125")
    assert "IMU_GYRO_RATEMAX" not in "\n".join(back.notes) and "our control period" not in "\n".join(back.notes)
    usual = write(tmp_path, line("IMU_GYRO_RATEMAX", 400, kind=6), "usual.params")
    assert "IMU_GYRO_RATEMAX" not in "\n".join(read("px4", usual, f"loops={loops}").notes)


def test_an_export_names_the_rate_on_the_vehicle(tmp_path):
    file = write(tmp_path, line("MC_ROLL_P", 4) + line("IMU_GYRO_RATEMAX", 800, kind=6))
    text = "\n".join(exported(TARGET, read("px4", file, "loops=own").controller).differences)
    assert "IMU_GYRO_RATEMAX = 800 Hz on the vehicle" in text and "default 400 Hz" not in text


def test_importers_by_name():
    assert set(importers()) == {"px4", "ardupilot", "betaflight", "crazyflie"}
    assert all(importer(name).name == name for name in importers())
    with pytest.raises(UnknownNameError, match="--from: unknown source 'px5'; did you mean 'px4'"):
        importer("px5")
