"""The table of a vehicle's configuration: its form, and differences, values that block and unusual values by hand."""

import numpy as np
import pytest

from tests.tuner.exchange.reading import read, write
from tuner.extensions.autopilots.sources import sources
from tuner.extensions.judge.configuration import (
    LAW,
    LIMIT,
    ORDER,
    ORIENTATION,
    SCALE,
    SENSE,
    SETTINGS,
    UNSEEN,
    blocking_configuration,
    changed_configuration,
    configuration_reasons,
    is_same_value,
    listed,
    setting_of,
    unusual_configuration,
)

PROJECTS = {
    "px4": "PX4-Autopilot ",
    "ardupilot": "ardupilot ",
    "betaflight": "betaflight ",
    "crazyflie": "crazyflie-firmware ",
}
GAINS = {
    "px4": "1\t1\tMC_ROLLRATE_P\t0.15\t9\n",
    "ardupilot": "ATC_RAT_RLL_P,0.135\n",
    "betaflight": "# Betaflight / X (X) 2026.6.1 Jul  1 2026 / 00:00:00 (abc) MSP API: 1.48\nset p_roll = 45\n",
    "crazyflie": "type: persistent_param_state\nversion: '1'\nparams:\n"
    "  pid_rate.roll_kp: {is_stored: true, default_value: 250.0, stored_value: 250.0}\n",
}


def test_the_table_has_each_firmware_and_each_property_with_a_source():
    assert len(SETTINGS) >= 40 and {row.firmware for row in SETTINGS} == set(sources()) == set(PROJECTS)
    assert {row.decides for row in SETTINGS} == {SENSE, ORDER, ORIENTATION, SCALE, LIMIT, LAW}
    assert all(row.source.startswith(PROJECTS[row.firmware]) for row in SETTINGS)
    assert all(row.default not in row.blocking for row in SETTINGS if row.default is not None)


def test_a_name_has_one_row():
    names = [(row.firmware, name) for row in SETTINGS for name in row.names.split()]
    assert len(names) == len(set(names))
    for firmware, name in names:
        row = setting_of(firmware, name.replace("#", "12"))
        assert row is not None and name in row.names.split()


@pytest.mark.parametrize("firmware", sources())
def test_no_setting_that_the_loops_carry_is_in_the_table(firmware, tmp_path):
    """A change of a modelled setting is judged by its flights."""
    file = write(tmp_path, GAINS[firmware])
    options = [f"{name}={value}" for name, value in sources()[firmware].options(file).items()]
    controller = read(firmware, file, *options, airframe="crazyflie-pybullet").controller
    assert controller.vehicle is not None
    carried = set(controller.vehicle.parameters) - set(controller.vehicle.untuned) | sources()[firmware].scaling
    assert carried and not [name for name in carried if setting_of(firmware, name)]


HARMLESS = {
    "idle of 4.5 %": ("dshot_idle_value", None, "450", True),
    "idle of 5.5 to 20 %": ("dshot_idle_value", "550", "2000", False),
    "a wider limit of the sum": ("pidsum_limit", "500", "1000", True),
    "a limit of the sum that flights reach": ("pidsum_limit", "500", "200", False),
    "a digital protocol for another": ("motor_pwm_protocol", "DSHOT300", "dshot600", True),
    "a digital protocol for what the board has": ("motor_pwm_protocol", None, "DSHOT600", True),
    "an analog protocol": ("motor_pwm_protocol", "DSHOT300", "ONESHOT125", False),
    "compensation of the battery": ("vbat_sag_compensation", None, "100", True),
}


@pytest.mark.parametrize(("name", "old", "new", "is_harmless"), HARMLESS.values(), ids=HARMLESS)
def test_a_change_that_no_flight_here_shows_forbids_a_verdict_unless_none_depends_on_it(name, old, new, is_harmless):
    before = {} if old is None else {name: old}
    assert (configuration_reasons("betaflight", before, {name: new}) == []) is is_harmless


CHANGES = {
    "a number": ({"SENS_BOARD_ROT": 0.0}, {"SENS_BOARD_ROT": 4.0}, ["0 to 4"]),
    "the same": ({"SENS_BOARD_ROT": 4.0}, {"SENS_BOARD_ROT": 4.0}, []),
    "from the default": ({}, {"SENS_BOARD_ROT": 4.0}, ["0 to 4"]),
    "at the default": ({}, {"SENS_BOARD_ROT": 0.0}, []),
    "back to the default by a reset": ({"SENS_BOARD_ROT": 4.0}, {}, ["4 to 0"]),
    "from a value of the board": ({}, {"PWM_MAIN_FUNC1": 101.0}, ["unknown to 101"]),
    "a number behind the name": ({"PWM_MAIN_FUNC12": 1.0}, {"PWM_MAIN_FUNC12": 2.0}, ["1 to 2"]),
    "another setting": ({"MC_ROLLRATE_P": 0.1}, {"MC_ROLLRATE_P": 0.2}, []),
    "a longer name": ({"XSENS_BOARD_ROT": 0.0}, {"XSENS_BOARD_ROT": 4.0}, []),
}


@pytest.mark.parametrize(("before", "after", "values"), CHANGES.values(), ids=CHANGES)
def test_a_change_counts_from_the_present_value_or_the_default(before, after, values):
    assert [change.values for change in changed_configuration("px4", before, after)] == values


def test_a_setting_of_another_firmware_has_no_row():
    assert setting_of("ardupilot", "SENS_BOARD_ROT") is None
    assert setting_of("betaflight", "resource MOTOR 1") is not None


def test_a_value_that_stops_an_axis_blocks_and_an_unusual_one_does_not():
    values = {"MC_ROLLRATE_MAX": 0.0, "MC_PITCHRATE_MAX": 90.0, "SENS_BOARD_ROT": 4.0, "MC_AIRMODE": 0.0}
    assert [change.name for change in blocking_configuration("px4", values)] == ["MC_ROLLRATE_MAX"]
    assert unusual_configuration("px4", values) == {
        "MC_ROLLRATE_MAX": "0",
        "MC_PITCHRATE_MAX": "90",
        "SENS_BOARD_ROT": "4",
    }


def test_reasons_are_one_for_each_property():
    before = {"AHRS_ORIENTATION": 0.0, "SERVO1_FUNCTION": 33.0, "SERVO2_FUNCTION": 34.0}
    after = {"AHRS_ORIENTATION": 4.0, "SERVO1_FUNCTION": 34.0, "SERVO2_FUNCTION": 33.0}
    assert configuration_reasons("ardupilot", before, after) == [
        f"changed {ORIENTATION}: AHRS_ORIENTATION 0 to 4",
        f"changed {ORDER}: SERVO1_FUNCTION 33 to 34, SERVO2_FUNCTION 34 to 33",
        UNSEEN,
    ]
    assert configuration_reasons("ardupilot", None, after) == configuration_reasons("ardupilot", after, after) == []


def test_a_value_that_blocks_is_named_once():
    (reason,) = configuration_reasons("px4", {"MC_YAWRATE_MAX": 200.0}, {"MC_YAWRATE_MAX": 0.0})
    assert reason.startswith(f"with MC_YAWRATE_MAX = 0 ({LIMIT}) no vehicle flies")
    assert configuration_reasons("px4", None, {"MC_YAWRATE_MAX": 0.0}) == [reason]


def test_a_long_list_is_counted():
    assert listed(["a", "b", "c", "d"]) == "a, b, c, d"
    assert listed(["a", "b", "c", "d", "e", "f"]) == "a, b, c, d and 2 more"


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        (0.0, 0.0, True), ("0", 0.0, True), ("ON", "on", True), ("1.0  -1.0", "1.0 -1.0", True), (0.0, 1.0, False),
        ("nan", "nan", True), (float(np.float32(0.15)), 0.15, True), (0.15, 0.1501, False), ("ON", "OFF", False), (None, None, False), (None, 0.0, False), ("OFF", 0.0, False),
    ],
)  # fmt: skip
def test_values_are_the_same_as_numbers_or_as_words(one, other, same):
    assert is_same_value(one, other) == is_same_value(other, one) == same


def test_a_limit_at_its_default_is_that_of_a_file_that_lacks_it():
    """Every published tune sets both to 0, as src/main/flight/pid.c of the firmware has them, and a `diff` lacks them."""
    limits = {"acc_limit": "0", "acc_limit_yaw": "0"}
    assert not list(changed_configuration("betaflight", {}, limits))
    assert len(list(changed_configuration("betaflight", limits, {"acc_limit": "10"}))) == 1
