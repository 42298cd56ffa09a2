"""Parameter files without a name of their firmware: guessed, laid over the present ones, and read back from a vehicle."""

import pytest

from plant.errors import InputError
from tests.tuner.exchange.reading import read, write
from tuner.exchange.registry import exporters, settings_of
from tuner.exchange.target import Request
from tuner.extensions.autopilots.sources import (
    changed_values,
    check_versions,
    differing_values,
    guess_source,
    is_same,
    overlaid,
    sources,
)

BETAFLIGHT = "# Betaflight / X (X) {}.1 Jul  1 2026 / 00:00:00 (abc) MSP API: 1.48\nprofile 0\nset p_roll = {}\nset d_roll = 30\n"
CRAZYFLIE = (
    "type: persistent_param_state\nversion: '1'\nparams:\n  pid_rate.roll_kp: {is_stored: true, default_value: 250.0, "
    "stored_value: 200.0}\n  pid_rate.pitch_kp:\n    is_stored: true\n    default_value: 250.0\n    stored_value: 210.0\n"
)
FILES = {
    "betaflight": BETAFLIGHT.format("2026.6", 45),
    "crazyflie": CRAZYFLIE,
    "px4": "# Stack: PX4 Pro\n# Version: 1.16.0\n1\t1\tMC_ROLLRATE_P\t0.15\t9\n1\t1\tMC_ROLLRATE_I\t0.2\t9\n",
    "ardupilot": "#NOTE: some ground station\nATC_RAT_RLL_P,0.135\nATC_RAT_RLL_I,0.135\n",
}
OTHERS = {
    "px4 without a head": ("px4", "1\t1\tCA_ROTOR_COUNT\t4\t6\n"),
    "ardupilot with blanks": ("ardupilot", "FRAME_CLASS 1\n"),
    "ardupilot in columns": ("ardupilot", "1\t1\tATC_RAT_RLL_P\t0.135\t9\n"),
    "betaflight without a head": ("betaflight", "set p_roll = 45\n"),
    "gains": ("gains", '\n{"format": "gainproof-gains"}'),
}


@pytest.mark.parametrize("source", FILES)
def test_a_file_is_guessed_by_its_lines(source, tmp_path):
    assert guess_source(write(tmp_path, FILES[source])) == source


@pytest.mark.parametrize(("source", "text"), OTHERS.values(), ids=OTHERS)
def test_a_file_of_another_ground_station_is_guessed(source, text, tmp_path):
    assert guess_source(write(tmp_path, text)) == source


@pytest.mark.parametrize("source", sources())
def test_an_export_is_guessed_and_read_in_the_native_loops(source, tmp_path):
    settings = ("firmware=4.7",) if source == "ardupilot" else ()
    native = read(
        source,
        write(tmp_path, FILES[source]),
        *([f"{name}={value}" for name, value in sources()[source].options(tmp_path / "vehicle.txt").items()]),
        airframe="crazyflie-pybullet" if source == "crazyflie" else "f450",
    )
    assert native.controller.cascade.attitude.name == source
    bundle = exporters()[source].export(
        Request(native.controller, "12" * 32, settings_of(exporters()[source], settings))
    )
    (content, *_) = bundle.files.values()
    file = write(tmp_path, content, "exported.txt")
    assert guess_source(file) == source
    assert sources()[source].options(file).get("firmware", "4.7") == "4.7"


@pytest.mark.parametrize("text", ["", "hello\n", "p_roll = 45\n", "[airframe]\nname = 1\n", "<html></html>"])
def test_anything_else_is_refused(text, tmp_path):
    with pytest.raises(InputError, match="nothing of a known firmware"):
        guess_source(write(tmp_path, text))


@pytest.mark.parametrize(
    ("source", "after"),
    [
        ("betaflight", "set p_roll = 60\n"),
        ("px4", "1\t1\tMC_ROLLRATE_P\t0.2\t9\n"),
        ("ardupilot", "  ATC_RAT_RLL_P 0.2  # mine\n"),
        ("ardupilot", "1\t1\tATC_RAT_RLL_P\t0.2\t9\n"),
        ("crazyflie", CRAZYFLIE.replace("200.0", "100.0").partition("  pid_rate.pitch")[0]),
    ],
)
def test_what_a_file_does_not_name_stays(source, after, tmp_path):
    kind = sources()[source]
    before, later = write(tmp_path, FILES[source], "before.txt"), write(tmp_path, after, "after.txt")
    merged = kind.values(write(tmp_path, overlaid(kind, before, later), "merged.txt"))
    assert merged == {**kind.values(before), **kind.values(later)} and len(merged) == 2
    assert len(changed_values(kind.values(before), merged)) == 1


def test_a_file_that_begins_with_the_defaults_keeps_nothing(tmp_path):
    kind = sources()["betaflight"]
    before = write(tmp_path, FILES["betaflight"], "before.txt")
    later = write(tmp_path, "defaults nosave\nset p_roll = 60\n", "after.txt")
    merged = write(tmp_path, overlaid(kind, before, later), "merged.txt")
    assert kind.values(merged) == {"p_roll": "60"}


def test_settings_behind_a_rate_profile_reach_the_loops(tmp_path):
    kind = sources()["betaflight"]
    before = write(tmp_path, FILES["betaflight"] + "rateprofile 0\nset roll_srate = 70\n", "before.txt")
    later = write(tmp_path, "set dterm_lpf1_static_hz = 150\n", "after.txt")
    merged = kind.values(write(tmp_path, overlaid(kind, before, later), "merged.txt"))
    assert merged["dterm_lpf1_static_hz"] == "150"


def test_files_of_two_versions_are_refused(tmp_path):
    old, new = (write(tmp_path, BETAFLIGHT.format(v, 45), v) for v in ("2025.12", "2026.6"))
    with pytest.raises(InputError, match=r"2026\.6.*of 2025\.12"):
        check_versions(sources()["betaflight"], old, new)
    # An export has what it replaces beside it, in names of its own version.
    (tmp_path / "rollback").mkdir()
    rollback = write(tmp_path / "rollback", new.read_text(), new.name)
    with pytest.raises(InputError, match="such as .*rollback.* for "):
        check_versions(sources()["betaflight"], old, new)
    check_versions(sources()["betaflight"], rollback, new)
    silent = write(tmp_path, "set p_roll = 45\n", "silent")
    check_versions(sources()["betaflight"], old, silent)


@pytest.mark.parametrize(
    ("written", "held", "same"),
    [
        (0.1, 0.10000000149011612, True),
        (0.135, 0.1350001, True),
        (0.135, 0.1351, False),
        (0.0, 0.0, True),
        (0.0, 1e-9, False),
        (1e9, 1e9 + 32.0, True),
        ("45", "45", True),
        ("045", "45", True),
        ("45", "46", False),
        ("ON", "on", True),
        ("PT1", "PT2", False),
    ],
)
def test_values_are_the_same_up_to_the_rounding_of_the_firmware(written, held, same):
    assert is_same(written, held, isinstance(written, str)) == same


def test_read_back_names_what_is_missing_and_what_differs():
    written = {"a": 1.0, "b": 2.0, "c": 3.0}
    found = differing_values(sources()["px4"], written, {"a": 1.0, "b": 2.5, "d": 4.0})
    assert found == {"b": (2.0, 2.5), "c": (3.0, None)}
