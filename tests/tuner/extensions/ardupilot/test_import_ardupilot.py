"""ArduPilot parameter files read back: what was exported, the right dialect, defaults, and files that are none."""

import numpy as np
import pytest

from plant.errors import InputError
from tests.clients import CLIENTS, client
from tests.tuner.exchange.controllers import pid
from tests.tuner.exchange.flying_autopilots import ardupilot_torque, attitude_feedback, attitude_gains, by_address
from tests.tuner.exchange.reading import exported, read, same_flight, write
from tuner.exchange.registry import settings_of
from tuner.exchange.target import Request
from tuner.extensions.ardupilot.export import FILE, TARGET

FITTING = {
    "yaw__kp": 26.0,
    "yaw__ki": 10.0,
    "yaw__kd": 6.5,
    "z__kp": 7.4,
    "z__ki": 4.9,
    "z__kd": 3.4,
    "pitch__kp": 80.0,
}


@pytest.mark.parametrize("firmware", ["4.6", "4.7"])
@pytest.mark.parametrize(("airframe", "curve"), [("iris", "1"), ("f450", "0.4"), ("hummingbird-rotors", "1")])
def test_an_export_comes_back_as_what_it_holds(airframe, curve, firmware, tmp_path):
    made = exported(
        TARGET, pid(airframe, **FITTING), f"firmware={firmware}", f"thrust_curve={curve}", "separator=blank"
    )
    back = read(
        "ardupilot",
        write(tmp_path, made.files[FILE]),
        f"firmware={firmware}",
        f"thrust_curve={curve}",
        airframe=airframe,
    )
    assert same_flight(back.controller, made.held)
    assert back.controller.control_period == 0.0025
    assert not any("Not in the file" in note or "left out" in note for note in back.notes)


@pytest.mark.parametrize(("given", "name"), [("4.6", "PSC_D_ACC_P"), ("4.7", "PSC_ACCZ_P")])
def test_the_other_dialect_is_named(given, name, tmp_path):
    other = "4.7" if given == "4.6" else "4.6"
    with pytest.raises(
        InputError, match=f"vehicle.txt: {name}: is a name of Copter {other}, .* give --firmware {other}"
    ):
        read("ardupilot", write(tmp_path, f"{name},0.3\n"), f"firmware={given}")


def defaults_of(version):
    client("ardupilot")
    folder = next(
        (CLIENTS / "ardupilot/lib").glob("python3*/site-packages/ardupilot_methodic_configurator/vehicle_templates")
    )
    return folder / "ArduCopter" / version / "00_default.param"


@pytest.mark.parametrize(
    ("firmware", "version", "names"),
    [
        ("4.6", "diatone_taycan_mxc/4.6.x-params", ("PSC_POSZ_P", "PSC_VELZ_P", "PSC_ACCZ_P", "PSC_ACCZ_I", 0.1)),
        ("4.7", "empty_4.7.x", ("PSC_D_POS_P", "PSC_D_VEL_P", "PSC_D_ACC_P", "PSC_D_ACC_I", 1.0)),
    ],
)
def test_a_vehicles_own_file_flies_as_ardupilot_would(firmware, version, names):
    """All the defaults that a vehicle gave, on the Iris: attitude through its mixer, the vertical loop by its poles."""
    file = defaults_of(version)
    found = dict(row.split("#")[0].strip().split(",") for row in file.read_text().splitlines() if "," in row)
    values = {name: float(value) for name, value in found.items()}
    back = read("ardupilot", file, f"firmware={firmware}", airframe="iris").controller
    vehicle = back.airframe.vehicle
    flown, _ = attitude_feedback(lambda *motion: ardupilot_torque(values, vehicle, 1.0, *motion), vehicle)
    assert attitude_gains(back) == pytest.approx(flown, rel=1e-6)
    # Thrust per throttle at hover through MOT_THST_EXPO = 0.65, on rotors with the square of the command.
    hover = np.sqrt(vehicle.mass * vehicle.gravity / 4.0 / 7.0664)
    climb = 4.0 * 7.0664 * 2.0 * hover / (2.0 * 0.65 * hover + 0.35) / vehicle.mass
    q, p, accel, accel_i = (values[name] for name in names[:4])
    scale = names[4] * climb
    # s^2 z = -(K + Ki/s)(s^2 + p s + p q) z
    open_loop = np.polymul([scale * accel, scale * accel_i], [1.0, p, p * q])
    poles = np.roots(np.polyadd([1.0, 0.0, 0.0, 0.0], open_loop))
    gains = by_address(back)
    ours = np.roots([1.0, gains["z.kd"], gains["z.kp"], gains["z.ki"]])
    assert np.sort_complex(ours) == pytest.approx(np.sort_complex(poles), rel=1e-4)
    assert back.options.tilt_limit == pytest.approx(np.radians(30.0))


def test_defaults_and_what_is_left_out_are_said(tmp_path):
    notes = "\n".join(
        read("ardupilot", write(tmp_path, "ATC_RAT_RLL_P 2e-1 # mine\n"), "firmware=4.6", airframe="iris").notes
    )
    for word in ("ATC_RAT_PIT_P = 0.135", "ATC_RAT_YAW_FLTE = 2.5", "ATC_RAT_RLL_D (", "K = ", "PSC_VELXY_FLTE = 5"):
        assert word in notes, word
    assert "ATC_RAT_RLL_P =" not in notes


def test_derivative_counted_as_inertia(tmp_path):
    file = write(tmp_path, "ATC_RAT_PIT_D,0.003\nMOT_THST_EXPO,1\n")
    one, other = (
        by_address(read("ardupilot", file, "firmware=4.6", f"rate_derivative={how}", airframe="iris").controller)
        for how in ("drop", "inertia")
    )
    # G of pitch is 2 l_x T_max.
    assert one["pitch.kd"] / other["pitch.kd"] == pytest.approx(1.0 + 0.003 * 2.0 * 0.13 * 7.0664 / 0.029125, rel=1e-4)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("ATC_RAT_RLL_P,inf\n", "ATC_RAT_RLL_P: given 'inf'"),
        ("ATC_RAT_RLL_P,0.1\nATC_RAT_RLL_P 0.2\n", "ATC_RAT_RLL_P: given twice, as 0.1"),
        ("atc_rat_rll_p,0.1\n", "line 1: must be a name of at most 16"),
        ("ATC_RAT_RLL_P_LONG,0.1\n", "line 1: must be a name of at most 16"),
        ("ATC_RAT_RLL_P\n", "line 1: must be a name"),
        ("", "holds no parameter"),
    ],
)
def test_what_is_no_such_file_is_refused(content, words, tmp_path):
    with pytest.raises(InputError, match=f"vehicle.txt: {words}"):
        read("ardupilot", write(tmp_path, content), "firmware=4.7")


OLD = "RATE_RLL_P,0.15\nRATE_PIT_P,0.15\nSTB_RLL_P,5\nACCEL_Z_P,0.6\nTHR_MID,450\nHLD_LAT_P,1\n"


def test_names_from_before_4_0_are_read_and_said(tmp_path):
    """0.15 of 3.3 on a frame X is 0.135 since; on a plus frame 0.1905. A name that nobody knows is named, not dropped."""
    file = write(tmp_path, "# ArduCopter V3.3.3 (acf2e10c)\n" + OLD)
    found = read("ardupilot", file, "firmware=4.6", airframe="iris")
    now = "ATC_RAT_RLL_P,0.135\nATC_RAT_PIT_P,0.135\nATC_ANG_RLL_P,5\nPSC_ACCZ_P,0.6\nMOT_THST_HOVER,0.45\n"
    same = read("ardupilot", write(tmp_path, now, "now.param"), "firmware=4.6", airframe="iris")
    assert found.controller.gains == pytest.approx(same.controller.gains, rel=1e-6)
    notes = "\n".join(found.notes)
    for words in ("3.3.3", "RATE_RLL_P -> ATC_RAT_RLL_P = 0.135", "STB_RLL_P -> ATC_ANG_RLL_P = 5", "HLD_LAT_P"):
        assert words in notes, words
    assert found.controller.vehicle is not None and "older than 4.0" in found.controller.vehicle.target_version
    plus = read("ardupilot", write(tmp_path, OLD + "FRAME,0\n", "plus.param"), "firmware=4.6", airframe="iris")
    assert by_address(plus.controller)["roll.kd"] / by_address(found.controller)["roll.kd"] == pytest.approx(1.27 / 0.9)


@pytest.mark.parametrize(
    ("content", "firmware", "words"),
    [
        (OLD, "4.7", "RATE_RLL_P: is a name from before Copter 4.0; give --firmware 4.6"),
        (OLD + "ATC_RAT_RLL_P,0.2\n", "4.6", "ATC_RAT_RLL_P: stands there as RATE_RLL_P too"),
        ("# Version: 4.7.1\nATC_RAT_RLL_P,0.2\n", "4.6", "# Version: says 4.7.1, .* give --firmware 4.7"),
        ("# ArduCopter V4.5.7 (2a3dc4b7)\nATC_RAT_RLL_P,0.2\n", "4.7", "# Version: says 4.5.7, .* give --firmware 4.6"),
        ("# Stack: PX4 Pro\nATC_RAT_RLL_P,0.2\n", "4.7", "# Stack: is a file of PX4 Pro, not of ArduPilot"),
    ],
)
def test_a_file_of_another_version_is_refused(content, firmware, words, tmp_path):
    with pytest.raises(InputError, match=f"vehicle.txt: {words}"):
        read("ardupilot", write(tmp_path, content), f"firmware={firmware}")


def test_a_vehicle_with_an_older_firmware_gets_no_file(tmp_path):
    """As --previous it tells that the vehicle would ignore what is written; an import of it is said to be older."""
    with pytest.raises(InputError, match="RATE_RLL_P: is a name from before Copter 4.0, which ignores those of 4.6"):
        TARGET.export(
            Request(pid("iris", **FITTING), "0" * 64, settings_of(TARGET, ("firmware=4.6",)), write(tmp_path, OLD))
        )


def test_the_columns_of_qgroundcontrol_are_read(tmp_path):
    file = write(
        tmp_path, "# Stack: ArduPilot\n# Version: 4.6.1\n1\t1\tATC_RAT_RLL_P\t0.2\t9\n1\t1\tFRAME_CLASS\t1\t2\n"
    )
    found = read("ardupilot", file, "firmware=4.6", airframe="iris").controller.vehicle
    assert found is not None and found.parameters == {"ATC_RAT_RLL_P": pytest.approx(0.2), "FRAME_CLASS": 1.0}


@pytest.mark.parametrize(
    ("rate", "settings", "period", "words"),
    [
        (None, (), 0.0025, "our control period (taken as 0.0025 s)"),
        (800, (), 0.00125, "The control period is that of SCHED_LOOP_RATE = 800 Hz."),
        (800, ("control_period=0.0025",), 0.0025, "SCHED_LOOP_RATE = 800 Hz of the file is not"),
    ],
)
def test_the_loop_rate_of_the_file_is_the_control_period(rate, settings, period, words, tmp_path):
    text = "ATC_RAT_RLL_P,0.12\n" + ("" if rate is None else f"SCHED_LOOP_RATE,{rate}\n")
    back = read("ardupilot", write(tmp_path, text), "firmware=4.6", *settings, airframe="f450")
    assert back.controller.control_period == pytest.approx(period)
    assert words in " ".join(back.notes)


def test_a_loop_rate_that_is_none_is_refused(tmp_path):
    with pytest.raises(InputError, match="SCHED_LOOP_RATE"):
        read("ardupilot", write(tmp_path, "ATC_RAT_RLL_P,0.12\nSCHED_LOOP_RATE,0\n"), "firmware=4.6", airframe="f450")
