"""Exported files on the command line of Betaflight's own firmware: taken, held after a restart, stored whole or not at all."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from plant.quadrotor.gains import default_row, gain_addresses
from tests.clients import client
from tests.clients.betaflight import Firmware
from tests.tuner.exchange.controllers import controller, pid
from tests.tuner.exchange.flying_autopilots import by_address
from tests.tuner.exchange.reading import read, same_flight, write
from tuner.exchange.registry import settings_of
from tuner.exchange.target import Request
from tuner.extensions.betaflight.export import FILE, TARGET
from tuner.extensions.betaflight.map import SWITCHES
from tuner.extensions.betaflight.native_loops import NATIVE_TABLE, native_switches
from tuner.extensions.betaflight.rpm_filter import FIXED, RPM_TABLE

YAW = {"yaw__kp": 20.0, "yaw__ki": 12.0, "yaw__kd": 6.0}
FLOWN = {"p_roll": "52", "i_pitch": "70"} | {
    name: "2"
    for name in (
        "d_yaw",
        "d_max_yaw",
        "f_yaw",
        "anti_gravity_gain",
        "yaw_lowpass_hz",
        "thrust_linear",
        "angle_feedforward",
    )
}
# Settings of a vehicle that somebody has flown: one or more of each kind away from its default.


@pytest.fixture
def firmware(tmp_path):
    with Firmware(tmp_path) as vehicle:
        yield vehicle


def bundle(given, *settings, previous=None):
    return TARGET.export(Request(given, "ab" * 32, settings_of(TARGET, settings), previous))


def written(content):
    return dict(re.findall(r"^set (\w+) = (.*)$", content.decode("ascii"), re.MULTILINE))


def held(vehicle, names, profile=0):
    found = vehicle.settings(profile)
    return {name: found.get(name) for name in names}


def flown(vehicle, profile=0):
    """Make the vehicle one that somebody has flown; the text that its command line prints of it."""
    lines = [f"profile {profile}", *(f"set {name} = {value}" for name, value in FLOWN.items()), "save"]
    assert "###" not in vehicle.load("\n".join(lines).encode())
    return vehicle.prints("diff all")


def test_names_ranges_and_defaults_are_the_firmwares(firmware):
    # Motors of the simulator do not tell their speed, so it has no RPM filter.
    for entry in [entry for name, entry in NATIVE_TABLE.items() if name not in RPM_TABLE]:
        answer = firmware.say(f"get {entry.name}")
        found = re.search(rf"^{entry.name} = (\d+)$.*?^Allowed range: (\d+) - (\d+)$", answer, re.MULTILINE | re.DOTALL)
        assert found, answer
        assert tuple(map(float, found.groups())) == (entry.usual, entry.low, entry.high), answer
    for name, (off, usual) in {**SWITCHES, **native_switches(own_controller())}.items():
        answer = firmware.say(f"get {name}")
        found = re.search(rf"^{name} = (\w+)$.*?^Allowed values: (.*)$", answer, re.MULTILINE | re.DOTALL)
        assert found, answer
        assert found[1] == usual and off in found[2].strip().split(", "), answer


def test_the_rpm_filters_ranges_and_defaults_are_those_of_its_source():
    (source,) = Path(client("betaflight")).parents[1].glob("lib/python*/site-packages/betaflight/firmware/src/main")
    ranges, usual = (source / "cli/settings.c").read_text(), (source / "pg/rpm_filter.c").read_text()
    for name, entry in RPM_TABLE.items():
        (span,) = re.findall(rf"PARAM_NAME_{name.upper()},.*minmaxUnsigned = \{{ (\d+), (\d+) \}}", ranges)
        (default,) = re.findall(rf"\.{name} = (\d+),", usual)
        assert (float(default), *map(float, span)) == (entry.usual, entry.low, entry.high), name
    for name, text in FIXED.items():
        (default,) = re.findall(rf"\.{name} = (.*),", usual)
        assert default.strip("{ }").replace(" ", "") == text


@pytest.mark.parametrize(("airframe", "profile"), [("iris", 0), ("f450", 2)])
def test_the_file_is_taken_and_held_after_a_restart(firmware, airframe, profile):
    content = bundle(pid(airframe, **YAW), f"profile={profile}").files[FILE]
    answer = firmware.load(content)
    assert "###" not in answer, answer
    assert "Rebooting" in answer
    assert held(firmware, written(content), profile) == written(content)


def test_its_own_loops_are_taken_and_come_back(firmware, tmp_path):
    """Settings of the firmware's own loops, stored, printed by it and read back: the same gains to the last bit."""
    changed = {
        **{f"{axis}__{name}": value for axis in ("roll", "pitch") for name, value in (("p", 61), ("i", 70), ("d", 25))},
        **{f"{axis}__gyro_lpf1": 180 for axis in ("roll", "pitch", "yaw")},
        **{f"{axis}__d_lpf2": 140 for axis in ("roll", "pitch", "yaw")},
        **{
            f"{axis}__{name}": value
            for axis in ("roll", "pitch", "yaw")
            for name, value in (
                ("notch", 200),
                ("notch_cutoff", 150),
                ("relax", 8),
                ("relax_cutoff", 9),
                ("tpa_rate", 40),
                ("tpa_breakpoint", 1400),
                ("tpa_p", 1),
            )
        },
    }
    given = own_controller(**changed)
    made = bundle(given)
    answer = firmware.load(made.files[FILE])
    assert "###" not in answer, answer
    assert held(firmware, written(made.files[FILE])) == written(made.files[FILE])
    printed = write(tmp_path, firmware.everything())
    back = read("betaflight", printed, "loops=own", "position_every=1", airframe="f450").controller
    assert made.held.gains == given.gains
    theirs, ours = by_address(back), by_address(given)
    carried = [name for name in ours if name.split(".")[0] in ("roll", "pitch", "yaw") and name != "yaw.angle_p"]
    assert {name: theirs[name] for name in carried} == {name: ours[name] for name in carried}


def own_controller(**changed):
    """Betaflight's own loops on an F450, some gains changed."""
    plain = controller("pid", "betaflight", "f450")
    plain = replace(plain, gains=tuple(default_row(plain.cascade, plain.airframe.vehicle)))
    values = {gain.address: plain.gains[gain.column] for gain in gain_addresses(plain.cascade)}
    values |= {name.replace("__", "."): float(value) for name, value in changed.items()}
    return replace(plain, gains=tuple(values[gain.address] for gain in gain_addresses(plain.cascade)))


def test_the_same_loop_whatever_the_vehicle_held_before(firmware):
    """Why settings at the firmware's default are written too: left out, the vehicle keeps what it had."""
    flown(firmware)
    content = bundle(pid("iris", **YAW)).files[FILE]
    assert "###" not in firmware.load(content)
    assert held(firmware, FLOWN) == {name: written(content)[name] for name in FLOWN}


BAD = [
    ("set iterm_limit = 500", "first"),
    ("set p_roll = 251", "middle"),
    ("set simplified_pids_mode = NO", "last"),
    ("sat p_roll = 40", "middle"),
]


@pytest.mark.parametrize(("bad", "place"), BAD)
def test_one_bad_line_and_nothing_is_stored(firmware, bad, place):
    before = firmware.everything()
    lines = bundle(pid("iris", **YAW)).files[FILE].decode("ascii").splitlines()
    inside = [k for k, line in enumerate(lines) if line.startswith("set ")]
    lines.insert({"first": inside[0], "middle": inside[len(inside) // 2], "last": inside[-1] + 1}[place], bad)
    answer = firmware.load("\n".join(lines).encode("ascii"))
    assert "###ERROR" in answer and "PLEASE FIX ERRORS" in answer, answer
    assert firmware.everything() == before


@pytest.mark.parametrize("profile", [0, 2])
def test_the_rollback_brings_everything_back(firmware, tmp_path, profile):
    previous = write(tmp_path, flown(firmware))
    before = firmware.everything()
    made = bundle(pid("iris", **YAW), f"profile={profile}", previous=previous)
    for content in (made.files[FILE], made.rollback[FILE]):
        between = firmware.everything()
        answer = firmware.load(content)
        assert "###" not in answer, answer
        assert firmware.everything() != between
    assert firmware.everything() == before


def test_without_a_previous_file_the_rollback_is_the_firmwares_defaults(firmware):
    before = firmware.everything()
    made = bundle(pid("iris", **YAW))
    for content in (made.files[FILE], made.rollback[FILE]):
        assert "###" not in firmware.load(content)
    assert firmware.everything() == before


def test_what_the_firmware_prints_is_read_with_nothing_of_the_loop_left_unsaid(firmware, tmp_path):
    """Diff and dump of one vehicle are the same controller; what differs from the firmware's defaults is in the notes."""
    flown(firmware)
    assert "###" not in firmware.load(
        b"set yaw_motors_reversed = ON\nset iterm_windup = 90\nset gyro_lpf2_static_hz = 700\nsave\n"
    )
    texts = [firmware.prints("diff all"), firmware.everything()]
    short, full = (
        read("betaflight", write(tmp_path, text, f"{k}.txt"), airframe="iris") for k, text in enumerate(texts)
    )
    assert same_flight(short.controller, full.controller)
    for imported in (short, full):
        notes = "\n".join(imported.notes)
        for word in (
            "Read as Betaflight 4.6",
            "yaw_motors_reversed = ON",
            "iterm_windup = 90",
            "gyro_lpf2_static_hz = 700",
            "d_yaw (",
        ):
            assert word in notes, word
        for name in ("f_yaw", "anti_gravity_gain", "yaw_lowpass_hz", "thrust_linear", "angle_feedforward"):
            assert f"{name} = 2" in notes, name
    assert "at the default" not in "\n".join(full.notes)


def test_imported_and_exported_untouched_changes_the_sliders_alone(firmware, tmp_path):
    previous = write(tmp_path, flown(firmware))
    before = firmware.settings()
    made = bundle(read("betaflight", previous, airframe="iris").controller, previous=previous)
    assert "###" not in firmware.load(made.files[FILE])
    after = firmware.settings()
    assert {name for name in after if after[name] != before[name]} == {"simplified_pids_mode"}
