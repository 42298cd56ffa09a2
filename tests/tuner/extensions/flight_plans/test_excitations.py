"""Experiments for targets: the names, units and ranges that the targets' own sources give, and refusals of those that cannot."""

import re

import numpy as np
import pytest

from plant.errors import InputError, UnknownNameError
from plant.quadrotor.airframes import load
from tuner.extensions.ardupilot.text import read_param
from tuner.extensions.flight_plans.api import craft_of
from tuner.extensions.flight_plans.excitation import Excitation, length_of
from tuner.extensions.flight_plans.excitation_target import HALF
from tuner.extensions.flight_plans.exciters import EXCITERS, UNABLE, exciter

NAME = "f450"
CRAFT = craft_of(load(NAME), NAME, None, None)
SIZES = {"angle": np.radians(12.0), "rate": np.radians(90.0), "acceleration": 3.0}
RANGES = {
    "chirp_lag_freq_hz": 255,
    "chirp_lead_freq_hz": 255,
    "chirp_amplitude_roll": 500,
    "chirp_amplitude_pitch": 500,
    "chirp_amplitude_yaw": 500,
    "chirp_frequency_start_deci_hz": 1000,
    "chirp_frequency_end_deci_hz": 10000,
    "chirp_time_seconds": 255,
}
"""Setting of Betaflight -> the largest that its command line takes (cli/settings.c of 2025.12.6)."""


def flight_for(target):
    capabilities, made = target.capabilities, []
    for axis, quantity in capabilities.quantities.items():
        wave, _, shape = capabilities.shapes(axis)[0]
        band = (0.5, 0.5) if wave == "steps" else (1.0, 12.0)
        made.append(Excitation(axis, quantity, SIZES[quantity], *band, 14.0, wave, shape))
    return made


@pytest.mark.parametrize("name", EXCITERS)
def test_every_target_writes_its_files_and_says_how_to_fly_them(name):
    target = EXCITERS[name]
    files = target.files(flight_for(target), CRAFT)
    assert files and all(content.endswith(b"\n") and content.isascii() for content in files.values())
    assert target.notes and all(note.endswith(".") for note in target.notes)


def amplitudes(files):
    """Return every amplitude in the files of a target: name of the file and of the number -> amplitude."""
    found = {}
    for name, content in files.items():
        text = content.decode()
        if name.endswith(".csv"):
            head, *rows = text.splitlines()
            table = np.array([[float(value) for value in row.split(",")] for row in rows])
            found |= {(name, key): np.ptp(table[:, k]) for k, key in enumerate(head.split(",")) if key != "time_s"}
        else:
            sizes = re.findall(r"(chirp_amplitude_\w+ = |SID_MAGNITUDE[, ]+|^by )([\d.]+)", text, re.MULTILINE)
            found |= {(name, key): float(value) for key, value in sizes}
    return found


@pytest.mark.parametrize("name", EXCITERS)
def test_files_with_half_the_amplitude_lie_beside_those_of_the_plan(name):
    target = EXCITERS[name]
    files = target.all_files(flight_for(target), CRAFT)
    full = amplitudes({name: content for name, content in files.items() if not name.startswith(HALF)})
    half = amplitudes({name: content for name, content in files.items() if name.startswith(HALF)})
    assert len(full) >= 4 and 2 * len(full) == len(full) + len(half)
    for (file, key), amplitude in full.items():
        assert half[f"{HALF}{file}", key] == pytest.approx(0.5 * amplitude, rel=0.03), (file, key)


def test_ardupilot_gets_a_file_for_each_axis_in_its_units(tmp_path):
    """SID_MAGNITUDE in deg, deg/s for yaw and a share of the throttle; SID_T_REC is longer than two periods at the start."""
    target, read = EXCITERS["ardupilot"], {}
    for name, content in target.files(flight_for(target), CRAFT).items():
        (tmp_path / name).write_bytes(content)
        found = read_param(tmp_path / name)
        read[found["SID_AXIS"]] = found
        assert found["SID_T_REC"] > 2.0 / found["SID_F_START_HZ"] and found["SID_F_STOP_HZ"] <= 100.0
    vehicle = CRAFT.system.vehicle
    share = 3.0 * vehicle.mass / (4.0 * vehicle.thrust_coefficient * vehicle.speed_max**2)
    sizes = {axis: found["SID_MAGNITUDE"] for axis, found in read.items()}
    assert sizes == pytest.approx({1.0: 12.0, 2.0: 12.0, 3.0: 90.0, 13.0: share}, abs=1e-4)


def test_betaflight_gets_settings_inside_their_ranges():
    target = EXCITERS["betaflight"]
    content = target.files(flight_for(target), CRAFT)["chirp.txt"]
    lines = [line.split() for line in content.decode().splitlines() if line.startswith("set ")]
    found = {name: int(value) for _, name, _, value in lines}
    assert set(found) == set(RANGES) and all(0 <= value <= RANGES[name] for name, value in found.items())
    assert found["chirp_amplitude_yaw"] == 90 and found["chirp_frequency_end_deci_hz"] == 120
    assert (found["chirp_lag_freq_hz"], found["chirp_lead_freq_hz"]) == (3, 30) and content.endswith(b"save\n")


def test_betaflight_s_pilot_is_told_throttle_steps():
    target = EXCITERS["betaflight"]
    text = target.files(flight_for(target), CRAFT)["throttle_steps.txt"].decode()
    vehicle = CRAFT.system.vehicle
    share = 100.0 * 3.0 * vehicle.mass / (4.0 * vehicle.thrust_coefficient * vehicle.speed_max**2)
    assert f"by {share:.1f} %" in text and "begin with 0.5 s up, then 1 s down" in text and "14 s in all" in text
    only = [entry for entry in flight_for(target) if entry.axis == "lift"]
    assert list(target.files(only, CRAFT)) == ["throttle_steps.txt"]


def test_the_table_holds_the_set_points_of_the_whole_flight():
    target = EXCITERS["csv"]
    flight = flight_for(target)
    head, *rows = target.files(flight, CRAFT)["excitation.csv"].decode().splitlines()
    table = np.array([[float(value) for value in row.split(",")] for row in rows])
    columns = dict(zip(head.split(","), table.T, strict=True))
    assert columns["time_s"][-1] == pytest.approx(length_of(flight) - 0.004, abs=1e-3)
    largest = {name: np.abs(columns[name]).max() for name in ("roll_deg", "pitch_deg", "yaw_rate_deg_s", "climb_m_s2")}
    expected = {"roll_deg": 12.0, "pitch_deg": 12.0, "yaw_rate_deg_s": 90.0, "climb_m_s2": 3.0}
    # At its first frequency of 1 Hz the filter lets 0.949 pass.
    assert largest == pytest.approx({name: 0.949 * size for name, size in expected.items()}, rel=0.01)


@pytest.mark.parametrize("name", UNABLE)
def test_a_target_that_cannot_excite_says_why_and_what_to_do(name):
    with pytest.raises(InputError, match="take 'csv'") as caught:
        exciter(name)
    assert "\n" not in str(caught.value)


def test_an_unknown_target_is_refused_with_those_that_can():
    with pytest.raises(UnknownNameError, match="ardupilot, betaflight, csv"):
        exciter("inav")
