"""Frames that parameter files are of: only quadrotors have gains of our vehicles; a file that names no frame is taken for one."""

from collections.abc import Mapping

from plant.errors import InputError
from plant.input_files import ReadableFile

QUAD_ROTORS = 4
# MAV_TYPE of MAVLink's common.xml, of what flies with rotors or passes for it.
VEHICLE_TYPES = {
    1: "a fixed wing", 3: "a coaxial helicopter", 4: "a helicopter", 7: "an airship", 10: "a rover", 11: "a boat",
    12: "a submarine", 13: "a hexacopter", 14: "an octocopter", 15: "a tricopter", 19: "a VTOL", 20: "a VTOL",
    21: "a VTOL", 22: "a VTOL", 23: "a VTOL", 24: "a VTOL", 25: "a VTOL", 29: "a dodecacopter", 35: "a decacopter",
}  # fmt: skip
# FRAME_CLASS of ArduCopter/Parameters.cpp; 0 is a frame not yet set.
FRAME_CLASSES = {
    2: "a hexacopter", 3: "an octocopter", 4: "an octoquad (X8)", 5: "a Y6", 6: "a helicopter", 7: "a tricopter",
    8: "a single copter", 9: "a coaxial copter", 10: "a bicopter", 11: "a dual helicopter",
    12: "a dodecahexacopter", 13: "a heliquad", 14: "a decacopter", 15: "a frame of a script, of up to 32 motors",
    16: "a frame of six degrees of freedom", 17: "a frame of a script, of up to 32 motors",
}  # fmt: skip
# CA_AIRFRAME of src/modules/control_allocator/module.yaml; 0 is a multirotor.
ALLOCATIONS = {
    1: "a fixed wing", 2: "a VTOL", 3: "a tiltrotor VTOL", 4: "a tailsitter", 5: "a rover", 6: "a rover",
    7: "a frame of six degrees of freedom", 8: "a multirotor that tilts its rotors", 9: "a frame of its own",
    10: "a helicopter", 11: "a helicopter", 12: "a coaxial helicopter", 13: "a rover", 14: "a spacecraft",
    15: "a spacecraft",
}  # fmt: skip
# Thousands of SYS_AUTOSTART, ROMFS/px4fmu_common/init.d/airframes.
AIRFRAMES = {
    2: "a fixed wing", 3: "a fixed wing", 6: "a hexacopter", 7: "a hexacopter", 8: "an octocopter",
    9: "an octocopter", 11: "a coaxial hexacopter", 12: "a coaxial octocopter", 13: "a VTOL",
    14: "a tricopter, or a multirotor that tilts its rotors", 15: "a coaxial helicopter", 16: "a helicopter",
    17: "an autogyro", 18: "a balloon", 24: "a dodecacopter", 50: "a rover", 51: "a rover", 60: "a submarine",
}  # fmt: skip
ROTORS = {
    2: "a bicopter",
    3: "a tricopter",
    6: "a hexacopter",
    8: "an octocopter",
    10: "a decacopter",
    12: "a dodecacopter",
}


# Parameters that another vehicle of ArduPilot alone has.
OTHER_VEHICLES = {
    "FRAME_CONFIG": "ArduSub",
    "Q_ENABLE": "ArduPlane",
    "TECS_SPDWEIGHT": "ArduPlane",
    "CRUISE_THROTTLE": "Rover",
}


def check_ardupilot_frame(values: Mapping[str, float], file: ReadableFile) -> None:
    """Refuse parameters of another frame than a quadrotor; raises InputError naming file and parameter."""
    for name, vehicle in OTHER_VEHICLES.items():
        if name in values:
            message = f"{vehicle} is not supported: its gains mean other torques than those of Copter"
            raise InputError(message, file=file, key=name)
    _check(values, "FRAME_CLASS", FRAME_CLASSES, file)


def check_px4_frame(values: Mapping[str, float], file: ReadableFile) -> None:
    """Refuse parameters of another frame than a quadrotor; raises InputError naming file and parameter.

    The geometry of the control allocation decides where it is there; the airframe that it began as may be another one.
    """
    _check(values, "CA_AIRFRAME", ALLOCATIONS, file)
    rotors = int(values.get("CA_ROTOR_COUNT", 0.0))
    if rotors == QUAD_ROTORS:
        return
    if rotors != 0:
        _refuse("CA_ROTOR_COUNT", rotors, ROTORS.get(rotors, f"a frame of {rotors} rotors"), file)
    _check(values, "MAV_TYPE", VEHICLE_TYPES, file)
    airframe = int(values.get("SYS_AUTOSTART", 0.0))
    if airframe // 1000 in AIRFRAMES:
        _refuse("SYS_AUTOSTART", airframe, AIRFRAMES[airframe // 1000], file)


def _check(values: Mapping[str, float], name: str, frames: Mapping[int, str], file: ReadableFile) -> None:
    value = int(values.get(name, 0.0))
    if value in frames:
        _refuse(name, value, frames[value], file)


def _refuse(name: str, value: int, frame: str, file: ReadableFile) -> None:
    message = f"given {value}, {frame}; only files of quadrotors can be read: gains mean other torques on other frames"
    raise InputError(message, file=file, key=name)
