"""Experiments for targets: the names, units and ranges that the targets' own sources give, and refusals of those that cannot."""

import numpy as np
import pytest

from plant.errors import InputError, UnknownNameError
from plant.quadrotor.airframes import load
from tuner.analysis.flight_plan.excitation import Excitation, length_of
from tuner.api.flight_plans import craft_of
from tuner.exchange.ardupilot.text import read_param
from tuner.exchange.excitations import EXCITERS, UNABLE, exciter

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
    capabilities = target.capabilities
    return [
        Excitation(axis, quantity, SIZES[quantity], 1.0, 12.0, 14.0, shape=capabilities.shape)
        for axis, quantity in capabilities.quantities.items()
    ]


@pytest.mark.parametrize("name", EXCITERS)
def test_every_target_writes_its_files_and_says_how_to_fly_them(name):
    target = EXCITERS[name]
    files = target.files(flight_for(target), CRAFT)
    assert files and all(content.endswith(b"\n") and content.isascii() for content in files.values())
    assert target.notes and all(note.endswith(".") for note in target.notes)
    # A table of numbers has no room for words.
    texts = [content.decode() for file, content in files.items() if not file.endswith(".csv")] or [
        " ".join(target.notes)
    ]
    assert all("egin with half the amplitude" in text for text in texts)


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
    (content,) = target.files(flight_for(target), CRAFT).values()
    lines = [line.split() for line in content.decode().splitlines() if line.startswith("set ")]
    found = {name: int(value) for _, name, _, value in lines}
    assert set(found) == set(RANGES) and all(0 <= value <= RANGES[name] for name, value in found.items())
    assert found["chirp_amplitude_yaw"] == 90 and found["chirp_frequency_end_deci_hz"] == 120
    assert found["chirp_lag_freq_hz"] == found["chirp_lead_freq_hz"] and content.endswith(b"save\n")


def test_the_table_holds_the_set_points_of_the_whole_flight():
    target = EXCITERS["csv"]
    flight = flight_for(target)
    head, *rows = target.files(flight, CRAFT)["excitation.csv"].decode().splitlines()
    table = np.array([[float(value) for value in row.split(",")] for row in rows])
    columns = dict(zip(head.split(","), table.T, strict=True))
    assert columns["time_s"][-1] == pytest.approx(length_of(flight) - 0.004, abs=1e-3)
    largest = {name: np.abs(columns[name]).max() for name in ("roll_deg", "pitch_deg", "yaw_rate_deg_s", "climb_m_s2")}
    expected = {"roll_deg": 12.0, "pitch_deg": 12.0, "yaw_rate_deg_s": 90.0, "climb_m_s2": 3.0}
    assert largest == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("name", UNABLE)
def test_a_target_that_cannot_excite_says_why_and_what_to_do(name):
    with pytest.raises(InputError, match="take 'csv'") as caught:
        exciter(name)
    assert "\n" not in str(caught.value)


def test_an_unknown_target_is_refused_with_those_that_can():
    with pytest.raises(UnknownNameError, match="ardupilot, betaflight, csv"):
        exciter("inav")
