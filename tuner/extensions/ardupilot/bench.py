"""ArduPilot Copter's control libraries on the bench: where they are in a checkout, and what flies there.

Facts of ArduPilot's master of July 2025 (Copter 4.7-dev): libraries/AC_AttitudeControl, AP_Motors, AP_InertialSensor.
"""

import re
from pathlib import Path

from tuner.extensions.autopilots.firmware import Bench, Firmware, period_check
from tuner.extensions.autopilots.firmware_parameters import parameters_in
from tuner.extensions.autopilots.libraries.board import installer
from tuner.extensions.autopilots.libraries.building import ControlLibraries
from tuner.extensions.autopilots.scales import is_plus

LIBRARIES = ControlLibraries(
    name="ardupilot",
    checkout="the folder of ArduPilot's sources",
    source=Path(__file__).with_name("loops.cpp"),
    middleware=Path(__file__).with_name("middleware.hpp"),
    empty=(
        "AP_AHRS/AP_AHRS.h", "AP_AHRS/AP_AHRS_View.h", "AP_Baro/AP_Baro.h", "AP_BattMonitor/AP_BattMonitor.h",
        "AP_BoardConfig/AP_BoardConfig.h", "AP_CustomRotations/AP_CustomRotations.h", "AP_HAL/AP_HAL.h", "AP_HAL/AP_HAL_Boards.h",
        "AP_InternalError/AP_InternalError.h", "AP_Logger/AP_Logger.h", "AP_Logger/AP_Logger_config.h", "AP_Motors/AP_Motors.h",
        "AP_Notify/AP_Notify.h", "AP_Param/AP_Param.h", "AP_Scheduler/AP_Scheduler.h", "AP_Scripting/AP_Scripting_config.h",
        "AP_Vehicle/AP_Vehicle_Type.h", "Filter/AP_Filter.h", "GCS_MAVLink/GCS.h", "GCS_MAVLink/GCS_MAVLink.h",
        "RC_Channel/RC_Channel.h", "SRV_Channel/SRV_Channel.h", "SRV_Channel/SRV_Channel_config.h",
    ),
    folders=("libraries",),
    marker="libraries/AC_PID/AC_PID.cpp",
)  # fmt: skip
VALUE, HEADING = re.compile(r"(\w+),(-?[\d.]+)"), re.compile(r"#|\Z")
POSITION = ("PSC_",)
"""Beginning of the parameters of the position loops, in whose place ours are."""
SHAPING = {"ATC_RATE_FF_ENAB": 0.0}
"""Angles that are asked for are so at once; with 1, the default, a trajectory leads to them."""
FRAME_TYPES = {(False, True): 1.0, (False, False): 3.0, (True, True): 0.0, (True, False): 6.0}
"""FRAME_TYPE: X, H, plus and plus reversed, by whether rotors stand in a plus and the first turns clockwise."""


def parameters_of(bench: Bench, content: bytes) -> dict[str, float]:
    """Return the parameters of an exported file and of the bench."""
    frame = FRAME_TYPES[is_plus(bench.rotors), bench.rotors.rotors[0].spin > 0.0]
    fixed = SHAPING | {"FRAME_TYPE": frame, "SCHED_LOOP_RATE": 1.0 / bench.control_period}
    return {"INS_GYRO_FILTER": 20.0} | parameters_in(content, VALUE, HEADING, POSITION) | fixed


ARDUPILOT = Firmware(
    name="ardupilot",
    title="ArduPilot",
    target="ardupilot",
    file="gainproof.param",
    law="ardupilot",
    heading=None,
    curve=None,
    binary=LIBRARIES.checkout,
    check=period_check(
        lambda period: 1.0 / period,
        50,
        2000,
        "ArduPilot's loops run each 0.5 to 20 ms, at a whole SCHED_LOOP_RATE in Hz",
    ),
    program=LIBRARIES.program,
    install=installer(parameters_of),
    lockstep=True,
    loses=(
        "Everything is float32, as on the vehicle; motor commands are not yet whole microseconds.",
        "The gyro is filtered once each control period, as our law does; a vehicle's at the gyro's own rate.",
        "Angles are asked for at once (ATC_RATE_FF_ENAB = 0); the attitude loop runs before the rate loop, in the same period.",
        "The position loops are ours: the file's PSC_* are not loaded, and the throttle has no low-pass and no angle boost.",
    ),
    options=("firmware=4.7",),
)
