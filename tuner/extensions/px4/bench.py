"""PX4's control libraries on the bench: where they are in a checkout, and which parameters they are given besides the gains.

Facts of PX4 1.16 and the main branch of August 2025: src/modules/mc_rate_control, mc_att_control, control_allocator and
sensors/vehicle_angular_velocity, their parameters' defaults included.
"""

import re
from pathlib import Path

from plant.quadrotor.airframes.actuation import Actuation
from tuner.extensions.autopilots.firmware import Bench, Firmware, period_check
from tuner.extensions.autopilots.firmware_parameters import parameters_in
from tuner.extensions.autopilots.libraries.board import installer
from tuner.extensions.autopilots.libraries.building import ControlLibraries
from tuner.extensions.autopilots.scales import PX4_CT

LIBRARIES = ControlLibraries(
    name="px4",
    checkout="the folder of PX4-Autopilot's sources",
    source=Path(__file__).with_name("loops.cpp"),
    middleware=Path(__file__).with_name("middleware.hpp"),
    empty=(
        "px4_platform_common/defines.h", "px4_platform_common/log.h", "px4_platform_common/module_params.h",
        "px4_platform_common/px4_work_queue/ScheduledWorkItem.hpp", "uORB/Subscription.hpp", "uORB/SubscriptionInterval.hpp",
        "uORB/SubscriptionCallback.hpp", "uORB/topics/rate_ctrl_status.h", "uORB/topics/control_allocator_status.h",
        "uORB/topics/actuator_motors.h", "mixer_module/output_functions.hpp",
    ),
    folders=(
        "src/lib", "src/lib/matrix", "src/lib/control_allocation/control_allocation",
        "src/lib/control_allocation/actuator_effectiveness", "src/modules/mc_att_control/AttitudeControl",
        "src/modules/control_allocator", "src/modules/control_allocator/VehicleActuatorEffectiveness",
    ),
    marker="src/lib/rate_control/rate_control.cpp",
)  # fmt: skip
DEFAULTS = {
    "MC_ROLLRATE_MAX": 220.0, "MC_PITCHRATE_MAX": 220.0, "MC_YAWRATE_MAX": 200.0, "MC_AIRMODE": 0.0, "IMU_GYRO_NF0_FRQ": 0.0,
    "IMU_GYRO_NF0_BW": 20.0, "IMU_GYRO_NF1_FRQ": 0.0, "IMU_GYRO_NF1_BW": 20.0, "IMU_GYRO_CUTOFF": 40.0, "IMU_DGYRO_CUTOFF": 30.0,
}  # fmt: skip
"""Parameters that these libraries read and an export may leave out."""
POSITION = ("MPC_",)
"""Beginning of the parameters of the position loops, in whose place ours are."""
LOOP_RATE = "IMU_GYRO_RATEMAX"
VALUE = re.compile(r"\d+\t1\t(\w+)\t(-?[\d.]+)\t[69]")
HEADING = re.compile(r"#|\Z")


def geometry(rotors: Actuation) -> dict[str, float]:
    """Return the parameters CA_ROTOR* of rotors in our order."""
    values = {"CA_ROTOR_COUNT": 4.0}
    for i, rotor in enumerate(rotors.rotors):
        places = {"PX": rotor.x, "PY": -rotor.y, "PZ": 0.0, "AX": 0.0, "AY": 0.0, "AZ": -1.0}
        thrust = {"CT": PX4_CT, "KM": -rotor.spin * rotor.torque_ratio}
        values |= {f"CA_ROTOR{i}_{name}": value for name, value in (places | thrust).items()}
    return values


def parameters_of(bench: Bench, content: bytes) -> dict[str, float]:
    """Return the parameters of an exported file and of the bench."""
    given = parameters_in(content, VALUE, HEADING, POSITION)
    return DEFAULTS | geometry(bench.rotors) | given | {LOOP_RATE: 1.0 / bench.control_period}


PX4_FIRMWARE = Firmware(
    name="px4",
    title="PX4",
    target="px4",
    file="gainproof.params",
    law="px4",
    heading=None,
    curve=None,
    binary=LIBRARIES.checkout,
    check=period_check(
        lambda period: 1e6 * period, 125, 10_000, "PX4's rate loops run each 0.125 to 10 ms, in whole microseconds"
    ),
    program=LIBRARIES.program,
    install=installer(parameters_of),
    lockstep=True,
    loses=(
        "Everything is float32, as on the vehicle.",
        "The gyro is filtered and differentiated once each control period, as our law does; a vehicle's at the gyro's own rate.",
        "The attitude loop runs at every period of the rate loop, before it; a vehicle's with its estimator.",
        "The position loops are ours: the file's MPC_* are not loaded.",
    ),
)
