"""PX4 parameter files: PX4's law on the real rotors flies our feedback; pyulog writes the same file; traps refused by name."""

import re
import struct
from dataclasses import replace

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.nominal import ControlOptions
from tests.clients import ask
from tests.tuner.exchange.controllers import controller, pid
from tests.tuner.exchange.flying_autopilots import (
    attitude_feedback,
    attitude_gains,
    by_address,
    px4_acceleration_slopes,
    px4_torque,
)
from tuner.exchange.registry import settings_of
from tuner.exchange.target import Request
from tuner.extensions.px4.export import FILE, TARGET

DIGEST = "ab" * 32


def bundle(given, *settings, previous=None):
    return TARGET.export(Request(given, DIGEST, settings_of(TARGET, settings), previous))


def firm(airframe="hummingbird", **gains):
    """Gains in PX4's ranges for any thrust curve."""
    return pid(
        airframe, **{"z__kp": 7.0, "z__ki": 1.5, "z__kd": 6.0, "yaw__kp": 9.0, "yaw__ki": 3.0, "yaw__kd": 4.0, **gains}
    )


def columns(content):
    """The five columns as QGroundControl splits them."""
    rows = [line.split("\t") for line in content.decode("ascii").split("\n") if line and not line.startswith("#")]
    assert all(len(row) == 5 for row in rows)
    return rows


def values_of(content):
    return {row[2]: float(row[3]) for row in columns(content)}


@pytest.mark.parametrize("airframe", ["hummingbird", "iris", "hummingbird-rotors"])
@pytest.mark.parametrize(
    "settings", [(), ("thrust_model=local",), ("thrust_curve=0.4",), ("thrust_curve=0.3", "thrust_model=local")]
)
def test_px4_flies_our_attitude_feedback(airframe, settings):
    """Angles, rates and integrals moved one by one through PX4's cascade, allocation, thrust curve and the rotors' places."""
    given = firm(airframe)
    curve = float(dict(entry.split("=") for entry in settings).get("thrust_curve", 1.0))
    values = values_of(bundle(given, *settings).files[FILE])
    vehicle = given.airframe.vehicle
    found, coupling = attitude_feedback(lambda *motion: px4_torque(values, vehicle, curve, *motion), vehicle)
    assert found == pytest.approx(attitude_gains(given), rel=1e-6)
    assert coupling < 1e-6 * found.max(axis=(0, 1))


@pytest.mark.parametrize("settings", [(), ("thrust_model=local",), ("thrust_curve=0.3", "thrust_model=local")])
def test_px4_flies_our_position_feedback(settings):
    """The velocity loops' acceleration becomes tilt and thrust; what the vehicle then does closes our loops."""
    given = firm()
    curve = float(dict(entry.split("=") for entry in settings).get("thrust_curve", 1.0))
    values = values_of(bundle(given, *settings).files[FILE])
    horizontal, vertical = px4_acceleration_slopes(values, given.airframe.vehicle, curve)
    gains = by_address(given)
    for axis, name, slope in (("x", "XY", horizontal), ("y", "XY", horizontal), ("z", "Z", vertical)):
        outer, p, i = (values[f"MPC_{name}{part}"] for part in ("_P", "_VEL_P_ACC", "_VEL_I_ACC"))
        assert slope * p == pytest.approx(gains[f"{axis}.kd"], rel=1e-6)
        assert slope * (p * outer + i) == pytest.approx(gains[f"{axis}.kp"], rel=1e-6)
        assert slope * i * outer == pytest.approx(gains[f"{axis}.ki"], rel=1e-6)


def test_the_curve_of_the_airframe_is_that_of_the_setting():
    """An airframe with thrust_linear = 0.4 is told as thrust_curve = 0.6; PX4 can undo none beyond the square."""

    def bent(linear):
        given = firm()
        vehicle = given.airframe.vehicle._replace(thrust_linear=linear)
        return replace(given, airframe=replace(given.airframe, vehicle=vehicle))

    told, by_file = bundle(firm(), "thrust_curve=0.6"), bundle(bent(0.4))
    assert values_of(by_file.files[FILE]) == values_of(told.files[FILE])
    assert values_of(by_file.files[FILE])["THR_MDL_FAC"] == pytest.approx(0.6, rel=1e-6)
    beyond = values_of(bundle(bent(-0.3)).files[FILE])
    assert beyond["THR_MDL_FAC"] == 1.0
    found, _ = attitude_feedback(
        lambda *motion: px4_torque(beyond, firm().airframe.vehicle, 1.3, *motion), firm().airframe.vehicle
    )
    assert found == pytest.approx(attitude_gains(firm()), rel=1e-6)


def test_the_file_is_what_ground_stations_read():
    made = bundle(pid(), "vehicle=7")
    text = made.files[FILE].decode("ascii")
    assert text.endswith("\n") and "\r" not in text and DIGEST in text and "gainproof" in text and "hummingbird" in text
    names = [row[2] for row in columns(made.files[FILE])]
    assert len(set(names)) == len(names) and all(len(name) <= 16 for name in names)
    for vehicle, component, _, value, kind in columns(made.files[FILE]):
        assert (vehicle, component, kind) == ("7", "1", "9")
        assert re.fullmatch(r"-?\d+\.\d+", value), value
    assert made.files == bundle(pid(), "vehicle=7").files


def test_everything_in_the_loops_is_written():
    values = values_of(bundle(pid(options=ControlOptions(tilt_limit=np.radians(35.0)))).files[FILE])
    for axis, limit in (("ROLL", "RR"), ("PITCH", "PR"), ("YAW", "YR")):
        assert [values[f"MC_{axis}RATE_{term}"] for term in ("K", "D", "FF")] == [1.0, 0.0, 0.0]
        assert values[f"MC_{limit}_INT_LIM"] == 1.0
    assert (values["MC_YAW_TQ_CUTOFF"], values["MC_YAW_WEIGHT"], values["THR_MDL_FAC"]) == (0.0, 1.0, 1.0)
    assert values["MPC_TILTMAX_AIR"] == pytest.approx(35.0, rel=1e-6)
    vehicle = firm().airframe.vehicle
    hover_speed = np.sqrt(vehicle.mass * vehicle.gravity / 4.0 / vehicle.thrust_coefficient)
    assert values["MPC_THR_HOVER"] == pytest.approx((hover_speed / vehicle.speed_max) ** 2, rel=1e-6)
    local = values_of(bundle(firm(), "thrust_model=local").files[FILE])
    assert local["THR_MDL_FAC"] == 0.0 and local["MPC_THR_HOVER"] == pytest.approx(
        np.sqrt(values["MPC_THR_HOVER"]), rel=1e-6
    )


def test_held_is_within_float32_of_what_was_asked():
    given = pid("iris")
    made = bundle(given)
    assert np.allclose(made.held.gains, given.gains, rtol=1e-6)
    assert made.held.gains != given.gains
    assert all(parameter.held == float(np.float32(parameter.unrounded)) for parameter in made.parameters)
    assert {parameter.name: parameter.held for parameter in made.parameters} == {
        name: float(np.float32(value)) for name, value in values_of(made.files[FILE]).items()
    }


REFUSED = [
    ({"y__kd": 2.7}, "y.kd: given 2.7, and x.kd = 2.6; PX4 1.16 has one set"),
    (
        {"roll__kd": 500.0, "roll__kp": 4000.0},
        "MC_ROLLRATE_P: works out at .* 0.01 to 0.5 normalised torque per rad/s: change roll.kd",
    ),
    ({"pitch__kp": 400.0, "pitch__ki": 0.0}, "MC_PITCH_P: works out at 26.6"),
    ({"yaw__kd": 0.0}, "yaw.kd: given 0 1/s"),
    ({"roll__ki": 200.0}, "roll.ki: given 200 s.-3; .* at most kp.2/.4 kd. = 135"),
    ({"z__ki": 0.0}, "MPC_Z_VEL_I_ACC: works out at 0"),
]


@pytest.mark.parametrize(("gains", "words"), REFUSED)
def test_what_px4_cannot_hold_is_refused_by_name(gains, words):
    with pytest.raises(InputError, match=words):
        bundle(pid(**gains))


@pytest.mark.parametrize(
    ("settings", "words"),
    [(("thrust_curve=2",), "thrust_curve"), (("vehicle=1.5",), "vehicle: given 1.5"), (("vehicle=0",), "vehicle")],
)
def test_wrong_options_are_refused(settings, words):
    with pytest.raises(InputError, match=words):
        bundle(pid(), *settings)


def test_a_tilt_limit_below_px4s_range():
    with pytest.raises(InputError, match="MPC_TILTMAX_AIR: .* change controller.tilt_limit"):
        bundle(pid(options=ControlOptions(tilt_limit=0.2)))


def test_what_differs_is_said_with_numbers():
    made = bundle(pid(options=ControlOptions(attitude_rate="observer")))
    text = "\n".join(made.differences)
    for word in (
        "observer",
        "setpoint",
        "IMU_GYRO_CUTOFF",
        "400 deg/s",
        "Anti-windup",
        "MC_YAW_TQ_CUTOFF",
        "4 ms",
        "MPC_USE_HTE",
        "roll 5 ms",
    ):
        assert word in text.replace("share of the reference", "setpoint"), word
    assert made.held.options.attitude_rate == "measured"
    assert all(sentence.endswith(".") and "\n" not in sentence for sentence in made.differences)
    # Reference through P a instead of kp: 15 * 5.236 of 90.
    assert "roll 87 %" in text


def test_rollback_brings_back_exactly_what_was_written(tmp_path):
    made = bundle(pid())
    usual = values_of(made.rollback[FILE])
    assert usual.keys() == values_of(made.files[FILE]).keys()
    assert (usual["MC_ROLLRATE_P"], usual["MC_YAW_TQ_CUTOFF"], usual["MPC_XY_P"]) == (0.15, 2.0, 0.95)
    before = tmp_path / "before.params"
    before.write_text("# Onboard\n1\t1\tMC_ROLLRATE_P\t0.1234\t9\n1\t1\tCOM_RC_IN_MODE\t2\t6\n")
    beside = bundle(firm(), previous=before)
    back = beside.rollback[FILE]
    # What the file does not tell and our loops do not carry is left alone.
    written = values_of(beside.files[FILE]).keys()
    assert values_of(back) == {name: usual[name] for name in written} | {"MC_ROLLRATE_P": 0.1234}
    assert "MC_ROLLRATE_D" not in written and "MC_ROLLRATE_I" in written
    comment = next(line for line in back.decode().splitlines() if "lacks" in line)
    assert "MC_PITCHRATE_P" in comment and "MC_ROLLRATE_P" not in comment
    assert (
        bundle(pid(), previous=_written(tmp_path, made)).rollback[FILE].splitlines()[-30:]
        == made.files[FILE].splitlines()[-30:]
    )


def _written(folder, made):
    file = folder / FILE
    file.write_bytes(made.files[FILE])
    return file


def ulog(values):
    """A ULog with nothing but initial parameters, as a vehicle logs them."""
    content = bytearray(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0))
    content += struct.pack("<HB", 40, ord("B")) + bytes(40)
    for name, value in values.items():
        key = f"float {name}".encode()
        body = struct.pack("<B", len(key)) + key + struct.pack("<f", value)
        content += struct.pack("<HB", len(body), ord("P")) + body
    return bytes(content)


WRITER = """
import io, json, sys, contextlib
from pyulog import params
sys.argv = ["ulog_params", "-f", "qgc", sys.argv[1]]
text = io.StringIO()
with contextlib.redirect_stdout(text):
    params.main()
print(json.dumps(text.getvalue()))
"""


def test_px4s_own_tool_writes_the_same_file(tmp_path):
    """pyulog turns a log that holds our values into QGroundControl's format: same columns, same numbers as float32."""
    content = bundle(pid("iris")).files[FILE]
    log = tmp_path / "flight.ulg"
    log.write_bytes(ulog(values_of(content)))
    theirs = {row[2]: row for row in columns(ask("autopilots", WRITER, str(log)).encode())}
    ours = {row[2]: row for row in columns(content)}
    assert theirs.keys() == ours.keys()
    for name, row in ours.items():
        assert [*row[:3], row[4]] == [*theirs[name][:3], theirs[name][4]]
        assert np.float32(row[3]) == np.float32(theirs[name][3])


def test_another_law_is_no_pid():
    assert (TARGET.position_laws, TARGET.attitude_laws) == (("pid", "px4_position"), ("pid", "px4"))
    given = controller("pid", "pid")
    assert bundle(replace(given, airframe=load("iris"))).held.airframe.name == "iris"
