"""Betaflight files: its rate loops on the real rotors fly what is said to be held; integers, switches, level; ADRC refused or carried."""

import re
from dataclasses import replace

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.vectors import Rotors, Vec3
from tests.tuner.exchange.controllers import controller, pid
from tests.tuner.exchange.flying_autopilots import attitude_feedback, attitude_gains, betaflight_torque, by_address
from tests.tuner.exchange.reading import read
from tuner.exchange.registry import settings_of
from tuner.exchange.target import Request
from tuner.extensions.betaflight import export as betaflight
from tuner.extensions.betaflight.export import FILE, TARGET
from tuner.extensions.betaflight.map import to_betaflight

DIGEST = "ef" * 32


YAW = {"yaw__kp": 20.0, "yaw__ki": 12.0, "yaw__kd": 6.0}


def bundle(given, *settings, previous=None, exporter=TARGET):
    return exporter.export(Request(given, DIGEST, settings_of(exporter, settings), previous))


def lines(content):
    return [line for line in content.decode("ascii").splitlines() if not line.startswith("#")]


def settings_in(content):
    found = [re.fullmatch(r"set ([a-z0-9_]+) = (\S+)", line) for line in lines(content)]
    return {match[1]: match[2] for match in found if match}


def numbers(content):
    return {name: int(value) for name, value in settings_in(content).items() if re.fullmatch(r"-?\d+", value)}


def yaw_outer(given):
    """Angle loop of yaw: larger root of kd a^2 - kp a + ki."""
    gains = by_address(given)
    return max(np.roots([gains["yaw.kd"], -gains["yaw.kp"], gains["yaw.ki"]]).real)


@pytest.mark.parametrize("curve", [1.0, 0.4])
@pytest.mark.parametrize("airframe", ["iris", "f450", "hummingbird"])
def test_betaflight_flies_what_is_held(airframe, curve):
    """The written integers moved through Betaflight's loops in deg/s, its mixer and the rotors' curve at hover."""
    given = pid(airframe, **YAW)
    made = bundle(given, f"thrust_curve={curve}")
    values, vehicle = numbers(made.files[FILE]), given.airframe.vehicle
    outer = yaw_outer(given)
    found, coupling = attitude_feedback(
        lambda a, r, i: betaflight_torque(values, vehicle, curve, a, r, i, outer), vehicle
    )
    assert found == pytest.approx(attitude_gains(made.held), rel=1e-6, abs=1e-6)
    assert coupling < 1e-6 * found.max(axis=(0, 1))


def test_before_rounding_it_is_our_feedback():
    given = pid("iris")
    vehicle = given.airframe.vehicle
    values = to_betaflight(given, actuation(vehicle))
    found, _ = attitude_feedback(
        lambda a, r, i: betaflight_torque(values, vehicle, 1.0, a, r, i, yaw_outer(given)), vehicle
    )
    assert found == pytest.approx(attitude_gains(given), rel=1e-6)


def test_the_published_example():
    """250-class: arms of 0.088 m, 6 N at most, hover at 0.55 of the command; J 30 rad/s = 0.075 N m s/rad gives P = 17.6."""
    frame = load("iris")
    arms = {"rotor_x": Rotors(0.088, 0.088, -0.088, -0.088), "rotor_y": Rotors(0.088, -0.088, 0.088, -0.088)}
    vehicle = frame.vehicle._replace(inertia=Vec3(0.0025, 0.0025, 0.005), **arms)
    rotors = replace(actuation(vehicle), thrust_max=6.0, hover_thrust=6.0 * 0.55**2)
    quick = {
        f"{axis}__{name}": value for axis in ("roll", "pitch") for name, value in (("kp", 200), ("ki", 100), ("kd", 30))
    }
    given = replace(pid("iris", **quick), airframe=replace(frame, vehicle=vehicle))
    assert to_betaflight(given, rotors)["p_roll"] == pytest.approx(17.6, abs=0.05)


def test_the_file_is_what_the_command_line_takes():
    made = bundle(pid("iris"), "profile=2")
    text = made.files[FILE].decode("ascii")
    assert DIGEST in text and "gainproof" in text and "iris" in text and "###" not in text
    body = lines(made.files[FILE])
    assert body[:2] == ["batch start", "profile 2"] and body[-1] == "save"
    assert all(re.fullmatch(r"set [a-z0-9_]+ = ([0-9]+|[A-Z]+)", line) for line in body[2:-1])
    found = settings_in(made.files[FILE])
    assert found["simplified_pids_mode"] == found["iterm_relax"] == "OFF"
    for name in ("d_roll", "d_max_pitch", "f_yaw", "anti_gravity_gain", "tpa_rate", "yaw_lowpass_hz"):
        assert found[name] == "0"


def test_integers_are_said():
    made = bundle(pid("iris"))
    text = "\n".join(made.differences)
    for parameter in made.parameters:
        assert parameter.held == round(parameter.unrounded)
    assert "p_roll 26.14 -> 26 (-0.5 %)" in text and "angle_p_gain 52.36 -> 52" in text
    for word in ("position loops", "heading loop", "slope at hover", "iterm_windup", "dshot_idle_value"):
        assert word in text
    # Position and heading stay as asked.
    ours, held = by_address(pid("iris")), by_address(made.held)
    assert all(held[name] == ours[name] for name in ours if name[0] in "xyz" and name[1] == ".")


REFUSED = [
    ({**YAW, "yaw__ki": 0.5}, "i_yaw: works out at 0.0.* and rounds to 0; .* raise yaw.ki about"),
    ({"pitch__kp": 100.0}, "pitch.kp: the angle loop of pitch is 6 1/s and that of roll 5.24 1/s"),
    ({"yaw__kd": 60.0, "yaw__kp": 200.0}, "p_yaw: works out at 726.962, allowed 0 to 250: change yaw.kd"),
    ({"roll__kd": 0.2, "roll__kp": 1.1, "roll__ki": 0.1, "pitch__kd": 0.2, "pitch__kp": 1.1, "pitch__ki": 0.1}, "p_roll: works out at 0.349 and rounds to 0; .* raise roll.kd about 2.9 times"),
]  # fmt: skip


@pytest.mark.parametrize(("gains", "words"), REFUSED)
def test_what_betaflight_cannot_hold_is_refused_by_name(gains, words):
    with pytest.raises(InputError, match=words):
        bundle(pid("iris", **gains))


@pytest.mark.parametrize("profile", ["4", "0.5", "x"])
def test_a_wrong_profile(profile):
    with pytest.raises(InputError, match="--set profile"):
        bundle(pid("iris"), f"profile={profile}")


def test_rollback(tmp_path):
    made = bundle(pid("iris"))
    usual = settings_in(made.rollback[FILE])
    assert usual.keys() == settings_in(made.files[FILE]).keys()
    assert (usual["p_roll"], usual["i_pitch"], usual["simplified_pids_mode"]) == ("45", "84", "RPY")
    before = tmp_path / "diff.txt"
    before.write_text(
        "# diff all\nset motor_poles = 12\nprofile 0\nset p_roll = 61\nprofile 1\nset p_roll = 99\nrateprofile 0\nset roll_srate = 3\n"
    )
    known = bundle(pid("iris"), previous=before)
    back = settings_in(known.rollback[FILE])
    assert back.keys() == settings_in(known.files[FILE]).keys()
    assert back == {**{name: usual[name] for name in back}, "p_roll": "61"}
    other = bundle(pid("iris"), "profile=1", previous=before).rollback[FILE]
    assert settings_in(other)["p_roll"] == "99" and lines(other)[-1] == "save"
    # The profile that the vehicle flew is selected again: the last one that its command line prints.
    assert [line for line in lines(back_to(before)) if line.startswith("profile")] == ["profile 0", "profile 1"]
    before.write_text("set p_roll = 6.1\n")
    with pytest.raises(InputError, match="diff.txt: p_roll: given '6.1'; this must be a whole number"):
        bundle(pid("iris"), previous=before)


def back_to(before):
    return bundle(pid("iris"), previous=before).rollback[FILE]


VEHICLE = """# Betaflight / STM32F405 (S405) 2025.12.2 Dec  1 2025 / 12:00:00 (norevision) MSP API: 1.47
set yaw_motors_reversed = OFF
profile 0
set p_roll = 52
set i_roll = 71
set d_roll = 33
set f_pitch = 90
set i_yaw = 60
set angle_p_gain = 44
set angle_limit = 70
set tpa_rate = 50
"""


@pytest.mark.parametrize("airframe", ["iris", "hummingbird"])
def test_imported_and_exported_untouched_is_what_the_vehicle_flies(airframe, tmp_path):
    """What our loop carries comes back as the same number; what it cannot carry is not written, and named."""
    file = tmp_path / "vehicle.txt"
    file.write_text(VEHICLE)
    made = bundle(read("betaflight", file, airframe=airframe).controller, previous=file)
    written = settings_in(made.files[FILE])
    flown = {
        "p_roll": "52",
        "i_roll": "71",
        "p_pitch": "47",
        "i_pitch": "84",
        "p_yaw": "45",
        "i_yaw": "60",
        "angle_p_gain": "44",
    }
    # Beyond our largest tilt the vehicle's own limit stays. The sliders would overwrite the gains from a ground station.
    assert written == {**flown, "simplified_pids_mode": "OFF"}
    text = "\n".join(made.differences)
    for word in ("d_roll = 33", "f_pitch = 90", "tpa_rate = 50", "d_pitch = 34", "iterm_relax = RP"):
        assert word in text, word
    assert "d_yaw" not in text


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (VEHICLE.replace("2025.12.2", "4.5.0"), "version: was printed by Betaflight 4.5, whose settings are others"),
        (VEHICLE.replace("2025.12.2", "3.5.7"), "version: was printed by Betaflight 3.5; known are Betaflight 4.3, "),
        (VEHICLE + "set use_integrated_yaw = ON\n", "use_integrated_yaw: given ON"),
    ],
)
def test_a_vehicle_that_the_file_is_not_for_is_refused(content, words, tmp_path):
    file = tmp_path / "vehicle.txt"
    file.write_text(content)
    with pytest.raises(InputError, match=f"vehicle.txt: {words}"):
        bundle(pid("iris", **YAW), previous=file)


def test_motors_are_named_by_betaflights_numbers():
    """Its QUADX: 1 rear right, 2 front right, 3 rear left, 4 front left; the front left one turns clockwise unless reversed."""
    text = bundle(pid("iris")).files[FILE].decode()
    assert "motor 1 rear right" in text and "motor 4 front left" in text
    senses = re.findall(r"motor \d [a-z ]+? (clockwise|counter-clockwise)", text)
    spins = pid("iris").airframe.vehicle.spin
    assert senses == [
        "clockwise" if spin > 0 else "counter-clockwise" for spin in (spins[3], spins[1], spins[2], spins[0])
    ]
    assert f"yaw_motors_reversed = {'OFF' if spins[0] > 0 else 'ON'}" in text


def test_an_integral_limit_is_said_as_the_firmware_has_it():
    (sentence,) = [text for text in bundle(pid("iris")).differences if "Anti-windup" in text]
    for word in ("80 %", "400", "yaw 320", "pidsum_limit"):
        assert word in sentence


def test_laws_that_the_target_carries():
    assert betaflight.TARGET.attitude_laws == ("pid", "betaflight") and betaflight.TARGET.position_laws == ()
    assert bundle(controller("ladrc", "pid", "iris")).held.cascade.position.name == "ladrc"
