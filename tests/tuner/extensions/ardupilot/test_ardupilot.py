"""ArduPilot parameter files: its laws on the real rotors fly our feedback, in both dialects; its clients read the same numbers."""

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from plant.errors import InputError
from plant.laws.pid import Gains
from plant.quadrotor.nominal import ControlOptions
from tests.clients import CLIENTS, ask, client
from tests.tuner.exchange.controllers import pid
from tests.tuner.exchange.flying_autopilots import (
    G0,
    ardupilot_torque,
    attitude_feedback,
    attitude_gains,
    by_address,
    derivative,
    motor_command,
    thrust_of,
)
from tuner.exchange.registry import settings_of
from tuner.exchange.target import Request
from tuner.extensions.ardupilot.export import FILE, TARGET
from tuner.extensions.ardupilot.map import vertical_gains, vertical_loops
from tuner.extensions.ardupilot.ranges import DIALECTS, check_names, positive_names
from tuner.extensions.autopilots.parameters import MAX_VALUE, single

DIGEST = "cd" * 32
FIRMWARES = ("4.6", "4.7")


def bundle(given, firmware, *settings, previous=None):
    chosen = settings_of(TARGET, (f"firmware={firmware}", *settings))
    return TARGET.export(Request(given, DIGEST, chosen, previous))


def fitting(airframe="iris", **gains):
    """Gains in ArduPilot's documented ranges."""
    return pid(
        airframe,
        **{
            "yaw__kp": 26.0,
            "yaw__ki": 10.0,
            "yaw__kd": 6.5,
            "z__kp": 7.4,
            "z__ki": 4.9,
            "z__kd": 3.4,
            "pitch__kp": 80.0,
            "pitch__ki": 50.0,
            "pitch__kd": 14.0,
            **gains,
        },
    )


def values_of(content):
    rows = [re.split("[, ]", line) for line in content.decode("ascii").splitlines() if not line.startswith("#")]
    assert all(len(row) == 2 for row in rows)
    return {name: float(value) for name, value in rows}


@pytest.mark.parametrize("firmware", FIRMWARES)
@pytest.mark.parametrize(
    ("airframe", "curve"), [("iris", 1.0), ("iris", 0.4), ("hummingbird-rotors", 1.0), ("f450", 0.0)]
)
def test_ardupilot_flies_our_attitude_feedback(airframe, curve, firmware):
    """Angles, rates and integrals moved one by one through ArduPilot's cascade, mixer, thrust curve and the rotors' places."""
    given = fitting(airframe)
    values = values_of(bundle(given, firmware, f"thrust_curve={curve}").files[FILE])
    vehicle = given.airframe.vehicle
    found, coupling = attitude_feedback(lambda *motion: ardupilot_torque(values, vehicle, curve, *motion), vehicle)
    assert found == pytest.approx(attitude_gains(given), rel=1e-6)
    assert coupling < 1e-6 * found.max(axis=(0, 1))


@pytest.mark.parametrize(("firmware", "name"), [("4.6", "PSC_{}XY_{}"), ("4.7", "PSC_NE_{}_{}")])
def test_ardupilot_flies_our_horizontal_feedback(firmware, name):
    given = fitting()
    values, gains = values_of(bundle(given, firmware).files[FILE]), by_address(given)
    slope = derivative(lambda asked: given.airframe.vehicle.gravity * np.tan(np.arctan2(asked, G0)))
    outer, p, i = values[name.format("POS", "P")], values[name.format("VEL", "P")], values[name.format("VEL", "I")]
    found = (slope * (p * outer + i), slope * i * outer, slope * p)
    assert found == pytest.approx([gains[f"x.{gain}"] for gain in ("kp", "ki", "kd")], rel=1e-6)
    assert (
        values[name.format("VEL", "FLTE")] == values[name.format("VEL", "D")] == values[name.format("VEL", "FF")] == 0.0
    )


def throttle_46(values, z, v, integral, error):
    """AC_PosControl of 4.6: cm, cm/s, cm/s2, throttle in thousandths; a_target and throttle less hover."""
    target = values["PSC_VELZ_P"] * (values["PSC_POSZ_P"] * -100.0 * z - 100.0 * v)
    return target / 100.0, 0.001 * (values["PSC_ACCZ_P"] * 100.0 * error + values["PSC_ACCZ_I"] * 100.0 * integral)


def throttle_47(values, z, v, integral, error):
    """AC_PosControl of 4.7: m and whole throttle."""
    target = values["PSC_D_VEL_P"] * (values["PSC_D_POS_P"] * -z - v)
    return target, values["PSC_D_ACC_P"] * error + values["PSC_D_ACC_I"] * integral


@pytest.mark.parametrize(("firmware", "law"), [("4.6", throttle_46), ("4.7", throttle_47)])
@pytest.mark.parametrize("curve", [1.0, 0.5])
@pytest.mark.parametrize("accel_gain", ["1", "1.3"])
def test_the_vertical_loop_has_our_poles(firmware, law, curve, accel_gain):
    """States z, v and the integral of the acceleration error; the measured acceleration solved for in the loop."""
    given = fitting()
    values = values_of(bundle(given, firmware, f"thrust_curve={curve}", f"accel_gain={accel_gain}").files[FILE])
    vehicle, hover = given.airframe.vehicle, values["MOT_THST_HOVER"]

    def climb(more):
        lift = 4.0 * thrust_of(vehicle, motor_command(hover + more, values["MOT_THST_EXPO"]), curve)
        return lift / vehicle.mass - vehicle.gravity

    slope = derivative(climb)
    rows = []
    for z, v, integral in np.eye(3):
        target, at_rest = law(values, z, v, integral, 0.0)
        gain = law(values, 0.0, 0.0, 0.0, 1.0)[1]
        acceleration = slope * (at_rest + gain * target) / (1.0 + slope * gain)
        rows.append([v, acceleration, target - acceleration])
    gains = by_address(given)
    ours = np.roots([1.0, gains["z.kd"], gains["z.kp"], gains["z.ki"]])
    assert np.sort_complex(np.linalg.eigvals(np.array(rows).T)) == pytest.approx(np.sort_complex(ours), rel=1e-5)
    assert abs(climb(0.0)) < 1e-5


def test_every_form_of_the_vertical_loop_maps_back():
    gains = Gains(6.0, 2.0, 4.0, 0.01)
    found = vertical_loops(gains, 0.9)
    assert found
    for loop in found:
        assert vertical_gains(loop, 0.01) == pytest.approx(gains, rel=1e-12)


@pytest.mark.parametrize("separator", ["comma", "blank"])
@pytest.mark.parametrize("firmware", FIRMWARES)
def test_the_file_is_what_ground_stations_read(firmware, separator):
    made = bundle(fitting(), firmware, f"separator={separator}")
    text = made.files[FILE].decode("ascii")
    assert DIGEST in text and "gainproof" in text and f"Copter {firmware}" in text and text.endswith("\n")
    mark = "," if separator == "comma" else " "
    rows = [line for line in text.splitlines() if not line.startswith("#")]
    assert all(re.fullmatch(rf"[A-Z][A-Z0-9_]{{0,15}}{mark}-?\d+\.\d+", row) for row in rows)
    assert made.target_version == f"ArduPilot Copter {firmware}"


def test_the_dialects_differ_as_documented():
    """Acceleration gains times ten, limits from cm to m and from thousandths to the whole."""
    old, new = (values_of(bundle(fitting(), firmware).files[FILE]) for firmware in FIRMWARES)
    assert old["PSC_ACCZ_P"] == pytest.approx(10.0 * new["PSC_D_ACC_P"], rel=1e-6)
    assert old["PSC_ACCZ_I"] == pytest.approx(10.0 * new["PSC_D_ACC_I"], rel=1e-6)
    assert (old["PSC_VELXY_IMAX"], new["PSC_NE_VEL_IMAX"]) == (1000.0, 10.0)
    assert (old["PSC_ACCZ_IMAX"], new["PSC_D_ACC_IMAX"]) == (1000.0, 1.0)
    assert old["PSC_ACCZ_P"] == pytest.approx(old["MOT_THST_HOVER"], rel=1e-6)
    assert not {name for name in old if name.startswith("PSC_") and name != "PSC_ANGLE_MAX"} & set(new)
    assert {name: old[name] for name in old if name in new} == {name: new[name] for name in new if name in old}


def test_the_firmware_must_be_said():
    with pytest.raises(InputError, match="--firmware 4.6 or 4.7"):
        settings_of(TARGET, ())


REFUSED = [
    ({"y__ki": 0.31}, "y.ki: given 0.31, and x.ki = 0.3"),
    ({"yaw__kp": 9.0, "yaw__ki": 0.1}, "ATC_ANG_YAW_P: works out at 1.37.* 3 to 12 1/s: change yaw.kp"),
    ({"z__kp": 2.5, "z__ki": 0.3, "z__kd": 2.6}, "PSC_POSZ_P: works out at 0.848059 1/s, allowed 1 to 3 1/s"),
    ({"z__kp": 20.0, "z__ki": 20.0, "z__kd": 0.4}, "z.kd: kp, ki and kd of z have no form"),
    ({"x__kp": 40.0, "y__kp": 40.0, "x__kd": 15.0, "y__kd": 15.0}, "PSC_POSXY_P: works out at 2.6"),
]


@pytest.mark.parametrize(("gains", "words"), REFUSED)
def test_what_ardupilot_cannot_hold_is_refused_by_name(gains, words):
    with pytest.raises(InputError, match=words):
        bundle(fitting(**gains), "4.6")


def test_a_tilt_limit_beyond_ardupilots_range():
    with pytest.raises(InputError, match="PSC_ANGLE_MAX: works out at 51.56.*controller.tilt_limit"):
        bundle(fitting(options=ControlOptions(tilt_limit=0.9)), "4.6")


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_held_and_rollback(firmware, tmp_path):
    given = fitting()
    made = bundle(given, firmware)
    assert np.allclose(made.held.gains, given.gains, rtol=2e-6) and made.held.gains != given.gains
    usual = values_of(made.rollback[FILE])
    assert usual.keys() == values_of(made.files[FILE]).keys()
    assert usual["ATC_RAT_YAW_FLTE"] == 2.5 and usual["ATC_RAT_RLL_P"] == 0.135
    before = tmp_path / "before.param"
    before.write_text("ATC_RAT_RLL_P 0.2\nRC1_MAX,2000\n")
    beside = bundle(given, firmware, previous=before)
    back = beside.rollback[FILE]
    # What the file does not tell and our loops do not carry is left alone.
    written = values_of(beside.files[FILE]).keys()
    assert values_of(back) == {name: usual[name] for name in written} | {"ATC_RAT_RLL_P": 0.2}
    assert "ATC_RAT_RLL_D" not in written and "ATC_RAT_RLL_I" in written
    assert any("lacks" in line and "ATC_RAT_PIT_P" in line for line in back.decode().splitlines())
    before.write_text("PSC_VELXY_P 1.0\n" if firmware == "4.7" else "PSC_NE_VEL_P 1.0\n")
    with pytest.raises(InputError, match="before.param: PSC_.*VEL.*_P: is a name of Copter"):
        bundle(given, firmware, previous=before)


def test_what_differs_is_said_with_numbers():
    text = "\n".join(bundle(fitting(), "4.6").differences)
    for word in (
        "PSC_ACCZ_FLTE",
        "K = 0.981",
        "1.98 times the mass",
        "ATC_RAT_*_FLTT",
        "square-root",
        "2.5 ms",
        "MOT_SPIN_MAX",
        "7.066 N",
    ):
        assert word in text, word


def test_what_would_not_arm_is_refused():
    """AC_PosControl::pre_arm_checks asks for an acceleration integral above 0, whatever the documented range begins with."""
    still: dict[str, Any] = {"z__ki": 0.0}
    for firmware, name in (("4.6", "PSC_ACCZ_I"), ("4.7", "PSC_D_ACC_I")):
        with pytest.raises(
            InputError, match=rf"{name}: works out at 0; Copter {firmware} does not arm .*change z\.kp, z\.ki"
        ):
            bundle(fitting(**still), firmware, "accel_gain=1.1")
        with pytest.raises(InputError, match="ATC_RAT_RLL_I"):
            bundle(fitting(roll__ki=0.0), firmware)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("ACRO_BAL_ROLL,6.5", "ATC_ANG_RLL_P: .* does not arm with ACRO_BAL_ROLL = 6.5 above it"),
        ("ACRO_BAL_PITCH,6.5", "ATC_ANG_PIT_P: .* does not arm with ACRO_BAL_PITCH = 6.5 above it"),
    ],
)
def test_what_would_not_arm_beside_the_vehicles_own_parameters_is_refused(line, words, tmp_path):
    before = tmp_path / "before.param"
    before.write_text("MOT_THST_EXPO,1\n")
    assert bundle(fitting(), "4.6", "accel_gain=1", previous=before).files
    before.write_text(f"MOT_THST_EXPO,1\n{line}\n")
    with pytest.raises(InputError, match=words):
        bundle(fitting(), "4.6", "accel_gain=1", previous=before)


def test_feed_forward_makes_an_integral_of_a_rate_loop_needless():
    names = positive_names({"ATC_RAT_YAW_FF": 0.1}, DIALECTS["4.6"])
    assert "ATC_RAT_RLL_I" in names and "ATC_RAT_YAW_I" not in names


PYMAVLINK = """
import json, sys, contextlib, io
from pymavlink import mavparm
found = mavparm.MAVParmDict()
with contextlib.redirect_stdout(io.StringIO()):
    good = found.load(sys.argv[1])
print(json.dumps([bool(good), dict(found)]))
"""

METHODIC = """
import json, sys
from ardupilot_methodic_configurator.data_model_par_dict import ParDict
print(json.dumps({name: par.value for name, par in ParDict.load_param_file_into_dict(sys.argv[1]).items()}))
"""


@pytest.mark.parametrize(("group", "script"), [("autopilots", PYMAVLINK), ("ardupilot", METHODIC)])
@pytest.mark.parametrize("separator", ["comma", "blank"])
def test_clients_read_the_same_numbers(group, script, separator, tmp_path):
    content = bundle(fitting(), "4.7", f"separator={separator}").files[FILE]
    file = tmp_path / FILE
    file.write_bytes(content)
    found = ask(group, script, str(file))
    if group == "autopilots":
        good, found = found
        assert good
    ours = values_of(content)
    assert found.keys() == ours.keys()
    assert {name: np.float32(value) for name, value in found.items()} == {name: np.float32(ours[name]) for name in ours}


def templates():
    """Where the methodic configurator keeps vehicles with the metadata and defaults of their firmware."""
    client("ardupilot")
    return next(
        (CLIENTS / "ardupilot" / "lib").glob("python3*/site-packages/ardupilot_methodic_configurator/vehicle_templates")
    )


# Documented from above 0 on, while 0 is the default and switches the term off: see ardupilot_ranges.
FROM_ZERO = {"PSC_VELXY_I", "PSC_VELZ_I"}


def test_ranges_are_those_of_ardupilots_metadata():
    """The 4.6 metadata in ArduPilot's own XML; of names that stand twice the first is the multicopter's."""
    tree = ElementTree.parse(templates() / "ArduCopter/diatone_taycan_mxc/4.6.x-params/apm.pdef.xml")
    documented = {}
    for param in tree.getroot().iter("param"):
        spans = [(field.text or "").split() for field in param.findall("field") if field.get("name") == "Range"]
        if spans:
            documented.setdefault(param.get("name", "").rpartition(":")[2], tuple(float(part) for part in spans[0]))
    checked = 0
    for name, entry in DIALECTS["4.6"].table.items():
        low, high = documented[name]
        assert entry.high == high, name
        assert entry.low == (0.0 if name in FROM_ZERO else low), name
        checked += 1
    assert checked == len(DIALECTS["4.6"].table) > 40


METADATA = """
import json, sys
from ardupilot_methodic_configurator.annotate_params import parse_parameter_metadata
found = parse_parameter_metadata("", sys.argv[1], "apm.pdef.xml", "ArduCopter", 100)
print(json.dumps(sorted(found)))
"""


def test_the_clients_metadata_knows_every_name():
    folder = templates() / "ArduCopter/diatone_taycan_mxc/4.6.x-params"
    assert set(DIALECTS["4.6"].table) <= set(ask("ardupilot", METADATA, str(folder)))


@pytest.mark.parametrize(("firmware", "vehicle"), [("4.6", "diatone_taycan_mxc/4.6.x-params"), ("4.7", "empty_4.7.x")])
def test_defaults_are_those_of_the_firmware(firmware, vehicle):
    """What a vehicle of that version gave as its defaults, read by the configurator."""
    found = ask("ardupilot", METHODIC, str(templates() / "ArduCopter" / vehicle / "00_default.param"))
    table = DIALECTS[firmware].table
    assert {name: single(entry.usual) for name, entry in table.items()} == {name: single(found[name]) for name in table}
    check_names(found, DIALECTS[firmware], Path("00_default.param"))
    assert all(entry.high < MAX_VALUE for entry in table.values())
