"""Settings of a vehicle that a tune leaves alone: those that decide sense, order, orientation, scale, limits or the law.

No loop of the model has them, so no flight here shows their effect, and one wrong value turns a vehicle over at take-off.
The table has facts alone; each row names the file of the firmware's sources, in its repository, that declares the setting.
"""

import re
from collections.abc import Iterator, Mapping
from functools import cache
from math import isclose
from typing import NamedTuple

from plant.errors import one_line, shortened
from tuner.text.sentences import first_texts

Value = str | float
Values = Mapping[str, Value]

SENSE, ORDER, ORIENTATION = "sense of rotation or of a stick", "order of outputs or channels", "orientation of a sensor"
SCALE, LIMIT, LAW = "scale of the motor commands", "limits of commands or rates", "control law or estimator"


class Setting(NamedTuple):
    """A row of the table.

    Attributes:
        firmware: Name of the source of a parameter file.
        names: Names with blanks between; # is a number.
        decides: Property of the vehicle that it decides.
        default: Value of the firmware; None where it depends on board or vehicle.
        source: File of the firmware that declares it.
        blocking: Values with which no vehicle flies as modelled.
        harmless: Lowest and highest value between which a change moves no flight of a judgement; None where each may.
        alike: Words that fly alike; a value that the file lacks is taken for one of them.
    """

    firmware: str
    names: str
    decides: str
    default: Value | None
    source: str
    blocking: tuple[Value, ...] = ()
    harmless: tuple[float, float] | None = None
    alike: tuple[str, ...] = ()

    def is_harmless(self, *values: Value | None) -> bool:
        """Return True for values between which a change is harmless."""
        if self.harmless is None:
            return bool(self.alike) and all(value is None or str(value).upper() in self.alike for value in values)
        low, high = self.harmless
        numbers = [None if value is None else _number(value) for value in values]
        return all(number is not None and low <= number <= high for number in numbers)


_SENSORS = "PX4-Autopilot src/modules/sensors/sensor_params.c (1.17: sensor_params.yaml)"
_CALIBRATION = "PX4-Autopilot src/modules/sensors/module.yaml, sensor calibration"
_ALLOCATION = "PX4-Autopilot src/modules/control_allocator/module.yaml"
_OUTPUTS = "PX4-Autopilot src/drivers/pwm_out/module.yaml, standard parameters of each output"
_RATES = "PX4-Autopilot src/modules/mc_att_control/mc_att_control_params.c"
_THRUST = "PX4-Autopilot src/modules/mc_pos_control/multicopter_position_control_limits_params.c"
_CHANNELS = "PX4-Autopilot src/modules/sensors/rc_params.c (later: src/modules/rc_update/params.c)"
_SERVO = "ardupilot libraries/SRV_Channel/SRV_Channel.cpp"
_MOTORS = "ardupilot libraries/AP_Motors/AP_MotorsMulticopter.cpp"
_ATTITUDE = "ardupilot libraries/AC_AttitudeControl/AC_AttitudeControl.cpp"
_MULTI = "ardupilot libraries/AC_AttitudeControl/AC_AttitudeControl_Multi.cpp"
_COPTER = "ardupilot ArduCopter/Parameters.cpp"
_ROTATIONS = "ardupilot libraries/AP_CustomRotations/AP_CustomRotations.cpp, AP_CustomRotations_params.cpp"
_CLI = "betaflight src/main/cli/settings.c"
_COMMANDS = "betaflight src/main/cli/cli.c, a command of its own"
_IMU = "crazyflie-firmware src/hal/src/sensors_bmi088_bmp3xx.c, group imu_sensors"
_STABILIZER = "crazyflie-firmware src/modules/src/stabilizer.c, group stabilizer"
_MODES = "crazyflie-firmware src/modules/src/crtp_commander_rpyt.c, group flightmode"

SETTINGS = (
    Setting("px4", "SENS_BOARD_ROT", ORIENTATION, 0.0, _SENSORS),
    Setting("px4", "SENS_BOARD_X_OFF SENS_BOARD_Y_OFF SENS_BOARD_Z_OFF", ORIENTATION, 0.0, _SENSORS),
    Setting("px4", "CAL_GYRO#_ROT CAL_ACC#_ROT CAL_MAG#_ROT", ORIENTATION, None, _CALIBRATION),
    Setting("px4", "CA_AIRFRAME CA_ROTOR_COUNT", ORDER, None, _ALLOCATION),
    Setting("px4", "CA_ROTOR#_PX CA_ROTOR#_PY CA_ROTOR#_PZ", ORDER, None, _ALLOCATION),
    Setting("px4", "CA_ROTOR#_AX CA_ROTOR#_AY CA_ROTOR#_AZ", ORDER, None, _ALLOCATION),
    Setting("px4", "CA_ROTOR#_KM", SENSE, None, _ALLOCATION),
    Setting("px4", "CA_ROTOR#_CT", SCALE, 6.5, _ALLOCATION),
    Setting("px4", "CA_R_REV", SENSE, 0.0, _ALLOCATION),
    Setting("px4", "CA_R#_SLEW", LIMIT, 0.0, _ALLOCATION),
    Setting("px4", "CA_METHOD", LIMIT, 2.0, _ALLOCATION),
    Setting("px4", "PWM_MAIN_FUNC# PWM_AUX_FUNC# UAVCAN_EC_FUNC#", ORDER, None, _OUTPUTS),
    Setting("px4", "PWM_MAIN_REV PWM_AUX_REV", SENSE, 0.0, _OUTPUTS),
    Setting("px4", "PWM_MAIN_MIN# PWM_MAIN_MAX# PWM_AUX_MIN# PWM_AUX_MAX#", SCALE, None, _OUTPUTS),
    Setting("px4", "DSHOT_3D_ENABLE", SENSE, 0.0, "PX4-Autopilot src/drivers/dshot/module.yaml"),
    Setting("px4", "MC_ROLLRATE_MAX MC_PITCHRATE_MAX", LIMIT, 220.0, _RATES, (0.0,)),
    Setting("px4", "MC_YAWRATE_MAX", LIMIT, 200.0, _RATES, (0.0,)),
    Setting("px4", "MPC_THR_MAX", LIMIT, 1.0, _THRUST, (0.0,)),
    Setting("px4", "MPC_THR_MIN", LIMIT, 0.12, _THRUST),
    Setting("px4", "MC_AIRMODE", LIMIT, 0.0, "PX4-Autopilot src/lib/mixer_module/params.c"),
    Setting("px4", "MC_BAT_SCALE_EN", SCALE, 0.0, "PX4-Autopilot src/modules/mc_rate_control/mc_rate_control_params.c"),
    Setting("px4", "SYS_AUTOSTART", ORDER, None, "PX4-Autopilot ROMFS/px4fmu_common/init.d/airframes"),
    Setting("px4", "RC_MAP_ROLL RC_MAP_PITCH RC_MAP_YAW RC_MAP_THROTTLE", ORDER, None, _CHANNELS),
    Setting("px4", "RC#_REV", SENSE, 1.0, _CHANNELS),
    Setting("ardupilot", "AHRS_ORIENTATION", ORIENTATION, 0.0, "ardupilot libraries/AP_AHRS/AP_AHRS.cpp"),
    Setting(
        "ardupilot",
        "AHRS_CUSTOM_ROLL AHRS_CUSTOM_PIT AHRS_CUSTOM_YAW",
        ORIENTATION,
        0.0,
        "ardupilot libraries/AP_AHRS/AP_AHRS.cpp of 4.1",
    ),
    Setting(
        "ardupilot", "CUST_ROT_ENABLE CUST_ROT#_ROLL CUST_ROT#_PITCH CUST_ROT#_YAW", ORIENTATION, 0.0, _ROTATIONS
    ),
    Setting(
        "ardupilot",
        "COMPASS_ORIENT COMPASS_ORIENT#",
        ORIENTATION,
        0.0,
        "ardupilot libraries/AP_Compass/AP_Compass.cpp",
    ),
    Setting("ardupilot", "FRAME_CLASS", ORDER, None, _COPTER, (0.0,)),
    Setting("ardupilot", "FRAME_TYPE", ORDER, 1.0, _COPTER),
    Setting("ardupilot", "FRAME", ORDER, None, "ardupilot ArduCopter/Parameters.cpp of 3.4"),
    Setting("ardupilot", "SERVO#_FUNCTION", ORDER, None, _SERVO),
    Setting("ardupilot", "SERVO#_REVERSED", SENSE, 0.0, _SERVO),
    Setting(
        "ardupilot",
        "SERVO_BLH_RVMASK SERVO_BLH_3DMASK",
        SENSE,
        0.0,
        "ardupilot libraries/AP_BLHeli/AP_BLHeli.cpp",
    ),
    Setting("ardupilot", "SERVO_FTW_RVMASK", SENSE, 0.0, "ardupilot libraries/AP_FETtecOneWire/AP_FETtecOneWire.cpp"),
    Setting("ardupilot", "MOT_PWM_TYPE MOT_PWM_MIN MOT_PWM_MAX", SCALE, None, _MOTORS),
    Setting("ardupilot", "MOT_SPIN_MIN", SCALE, 0.15, _MOTORS),
    Setting("ardupilot", "MOT_SPIN_MAX", SCALE, 0.95, _MOTORS, (0.0,)),
    Setting("ardupilot", "MOT_BAT_VOLT_MAX MOT_BAT_VOLT_MIN", SCALE, 0.0, _MOTORS),
    Setting("ardupilot", "MOT_BAT_CURR_MAX", LIMIT, 0.0, _MOTORS),
    Setting("ardupilot", "MOT_YAW_HEADROOM", LIMIT, 200.0, _MOTORS),
    Setting("ardupilot", "MOT_SLEW_UP_TIME MOT_SLEW_DN_TIME", LIMIT, 0.0, _MOTORS),
    Setting("ardupilot", "ATC_RATE_R_MAX ATC_RATE_P_MAX ATC_RATE_Y_MAX", LIMIT, 0.0, _ATTITUDE),
    Setting("ardupilot", "ATC_THR_MIX_MIN ATC_THR_MIX_MAN", LIMIT, 0.1, _MULTI),
    Setting("ardupilot", "ATC_THR_MIX_MAX", LIMIT, 0.5, _MULTI),
    Setting("ardupilot", "RCMAP_ROLL RCMAP_PITCH RCMAP_YAW RCMAP_THROTTLE", ORDER, None, "ardupilot libraries/AP_RCMapper"),
    Setting("ardupilot", "RC#_REVERSED", SENSE, 0.0, "ardupilot libraries/RC_Channel/RC_Channel.cpp"),
    Setting("ardupilot", "CC_TYPE CC_AXIS_MASK", LAW, 0.0, "ardupilot libraries/AC_CustomControl/AC_CustomControl.cpp"),
    Setting("betaflight", "align_board_roll align_board_pitch align_board_yaw", ORIENTATION, "0", _CLI),
    Setting("betaflight", "gyro_#_sensor_align gyro_#_align_roll gyro_#_align_pitch gyro_#_align_yaw", ORIENTATION, None, _CLI),
    Setting("betaflight", "gyro_to_use gyro_enabled_bitmask gyro_#_enabled", ORIENTATION, None, _CLI),
    Setting("betaflight", "align_mag mag_align_roll mag_align_pitch mag_align_yaw", ORIENTATION, None, _CLI),
    Setting("betaflight", "yaw_motors_reversed", SENSE, "OFF", _CLI),
    Setting("betaflight", "motor_output_reordering", ORDER, "0,1,2,3,4,5,6,7", _CLI),
    Setting("betaflight", "mixer", ORDER, "QUADX", _COMMANDS),
    Setting("betaflight", "mmix_#", ORDER, None, _COMMANDS),
    Setting("betaflight", "resource_MOTOR_#", ORDER, None, _COMMANDS),
    Setting("betaflight", "map", ORDER, "AETR1234", _COMMANDS),
    Setting("betaflight", "feature_3D", SENSE, "OFF", _COMMANDS),
    Setting("betaflight", "3d_switched_mode", SENSE, "OFF", _CLI),
    Setting("betaflight", "motor_pwm_inversion", SENSE, None, _CLI),
    # Digital commands have one scale; an ESC that lacks the faster protocol does not start.
    Setting("betaflight", "motor_pwm_protocol", SENSE, None, _CLI, alike=("DSHOT150", "DSHOT300", "DSHOT600")),
    Setting("betaflight", "mixer_type", LIMIT, "LEGACY", _CLI),
    # Idle of 1 to 10 % of the motors, in hundredths of a per cent or as a pulse: the loop gain scales with the other 90 to 99 %.
    Setting("betaflight", "motor_idle dshot_idle_value", LIMIT, "550", _CLI, harmless=(100.0, 1000.0)),
    Setting("betaflight", "min_throttle", LIMIT, "1070", _CLI, harmless=(1010.0, 1100.0)),
    Setting("betaflight", "max_throttle", LIMIT, None, _CLI),
    Setting("betaflight", "motor_output_limit", LIMIT, "100", _CLI),
    # Of 1000, the whole range of the motors: from 400 on (yaw 300) motors meet their limits before the sum does.
    Setting("betaflight", "pidsum_limit", LIMIT, "500", _CLI, harmless=(400.0, 1000.0)),
    Setting("betaflight", "pidsum_limit_yaw", LIMIT, "400", _CLI, harmless=(300.0, 1000.0)),
    Setting("betaflight", "roll_rate_limit pitch_rate_limit yaw_rate_limit", LIMIT, "1998", _CLI),
    Setting("betaflight", "acc_limit acc_limit_yaw", LIMIT, "0", _CLI),
    Setting("betaflight", "throttle_limit_type", LIMIT, "OFF", _CLI),
    Setting("betaflight", "throttle_limit_percent", LIMIT, "100", _CLI),
    # On a full battery it does nothing; flights on a low one here have the gain without it, the lowest.
    Setting("betaflight", "vbat_sag_compensation", SCALE, "0", _CLI, harmless=(0.0, 150.0)),
    Setting("crazyflie", "imu_sensors.imuPhi imu_sensors.imuTheta imu_sensors.imuPsi", ORIENTATION, 0.0, _IMU),
    Setting("crazyflie", "stabilizer.controller stabilizer.estimator", LAW, 0.0, _STABILIZER),
    Setting("crazyflie", "flightmode.stabModeRoll flightmode.stabModePitch flightmode.stabModeYaw", LAW, None, _MODES),
    Setting("crazyflie", "flightmode.yawMode", ORIENTATION, None, _MODES),
    Setting(
        "crazyflie",
        "powerDist.idleThrust",
        LIMIT,
        0.0,
        "crazyflie-firmware src/modules/src/power_distribution_quadrotor.c",
    ),
    Setting("crazyflie", "motorPowerSet.enable", LAW, 0.0, "crazyflie-firmware src/drivers/src/motors.c", (1.0, 2.0, 3.0)),
    Setting(
        "crazyflie",
        "pid_attitude.yawMaxDelta",
        LIMIT,
        None,
        "crazyflie-firmware src/modules/src/controller/attitude_pid_controller.c",
    ),
)  # fmt: skip
"""The table. ATC_ACCEL_*_MAX is not in it: it shapes the set point alone, and each autotune of ArduPilot writes it."""
UNSEEN = "no flight here shows that: judge the gains without these settings, and test them on the vehicle by themselves"
SAME = 1e-6
"""Share by which two texts of one float32 may differ."""
MAX_LISTED = 4
"""Largest number of settings that a reason lists by name."""


class ConfigurationChange(NamedTuple):
    """A setting of the table that differs: its name, the property that it decides, its values in words."""

    name: str
    decides: str
    values: str


def setting_of(firmware: str, name: str) -> Setting | None:
    """Return the row of a setting, None where the table has none."""
    # Names of commands, such as resource MOTOR 1, have blanks.
    word = name.replace(" ", "_")
    return next((row for pattern, row in _patterns(firmware) if pattern.fullmatch(word)), None)


def changed_configuration(firmware: str, before: Values, after: Values) -> Iterator[ConfigurationChange]:
    """Yield the settings of the table that differ beyond harmless changes.

    A setting that a file lacks has the default; where that depends on the vehicle, its value is unknown, which is a difference.

    Args:
        firmware: Name of the source of both files.
        before: Settings of the present file.
        after: Settings of the vehicle with the proposal.
    """
    for name in dict.fromkeys((*after, *before)):
        row = setting_of(firmware, name)
        if row is None:
            continue
        old, new = (values.get(name, row.default) for values in (before, after))
        if not is_same_value(old, new) and not row.is_harmless(old, new):
            yield ConfigurationChange(name, row.decides, f"{_shown(old)} to {_shown(new)}")


def blocking_configuration(firmware: str, values: Values) -> Iterator[ConfigurationChange]:
    """Yield the settings with which no vehicle flies as modelled."""
    for name, value in values.items():
        row = setting_of(firmware, name)
        if row is not None and any(is_same_value(value, other) for other in row.blocking):
            yield ConfigurationChange(name, row.decides, _shown(value))


def unusual_configuration(firmware: str, values: Values) -> dict[str, str]:
    """Return the settings that are not at the default of the firmware."""
    rows = {name: setting_of(firmware, name) for name in values}
    return {
        name: _shown(values[name])
        for name, row in rows.items()
        if row is not None and row.default is not None and not is_same_value(values[name], row.default)
    }


def configuration_reasons(firmware: str, before: Values | None, after: Values) -> list[str]:
    """Return the reasons for which settings of the table forbid a verdict.

    Args:
        firmware: Name of the source of both files.
        before: Settings of the present file, None without one.
        after: Settings of the vehicle with the proposal.
    """
    blocking = list(blocking_configuration(firmware, after))
    reasons = [
        f"with {row.name} = {row.values} ({row.decides}) no vehicle flies as modelled: correct it" for row in blocking
    ]
    named = {row.name for row in blocking}
    by_property: dict[str, list[str]] = {}
    for change in () if before is None else changed_configuration(firmware, before, after):
        if change.name not in named:
            by_property.setdefault(change.decides, []).append(f"{change.name} {change.values}")
    reasons += [f"changed {decides}: {listed(texts)}" for decides, texts in by_property.items()]
    return [*reasons, UNSEEN] if by_property else reasons


def listed(texts: list[str]) -> str:
    """Return the first of several texts, and the number of the others."""
    return first_texts(texts, MAX_LISTED)


def is_same_value(one: Value | None, other: Value | None) -> bool:
    """Return True for equal numbers, or words that differ in case alone; an unknown value equals none."""
    if one is None or other is None:
        return False
    first, second = (" ".join(str(value).split()).casefold() for value in (one, other))
    numbers = [_number(value) for value in (one, other)]
    if numbers[0] is None or numbers[1] is None:
        return first == second
    return first == second or isclose(numbers[0], numbers[1], rel_tol=SAME)


def _number(value: Value) -> float | None:
    """Return a value as a number, None for a word."""
    try:
        return float(value)
    except ValueError:
        return None


def _shown(value: Value | None) -> str:
    if value is None:
        return "unknown"
    return shortened(one_line(value), 30) if isinstance(value, str) else f"{value:.9g}"


@cache
def _patterns(firmware: str) -> list[tuple[re.Pattern[str], Setting]]:
    """Return pattern and row of each name of a firmware."""
    return [
        (re.compile(re.escape(name).replace(r"\#", r"\d+")), row)
        for row in SETTINGS
        if row.firmware == firmware
        for name in row.names.split()
    ]
