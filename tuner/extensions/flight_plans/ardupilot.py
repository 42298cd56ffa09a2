"""An experiment in ArduPilot Copter's SYSTEMID mode: a parameter file for each axis, whose chirp the mode flies once.

Names and units as in ArduCopter/mode_systemid.cpp: SID_MAGNITUDE is in deg for roll and pitch
(SID_AXIS 1, 2), in deg/s for yaw (3) and a share of the throttle for the thrust (13); SID_T_REC counts the two periods at the
first frequency and both fades.
"""

from collections.abc import Mapping, Sequence
from math import degrees

from tuner.extensions.ardupilot.text import write_param
from tuner.extensions.flight_plans.choosing import TargetCapabilities
from tuner.extensions.flight_plans.excitation import Excitation, Shape
from tuner.extensions.flight_plans.excitation_target import ExcitationTarget, throttle_share
from tuner.extensions.flight_plans.flying import SimulatedVehicle

AXES = {"roll": 1, "pitch": 2, "yaw": 3, "lift": 13}
"""Axis -> SID_AXIS."""
SHAPE = Shape(dwell=2.0, fade_in=1.0, fade_out=0.5)
"""Two periods at the first frequency are the mode's own."""


def parameters(excitation: Excitation, simulated: SimulatedVehicle) -> dict[str, float]:
    """Return the parameters of an excitation by name."""
    lift = throttle_share(excitation.amplitude, simulated.system.vehicle)
    return {
        "SID_AXIS": float(AXES[excitation.axis]),
        "SID_MAGNITUDE": round(lift if excitation.axis == "lift" else degrees(excitation.amplitude), 4),
        "SID_F_START_HZ": excitation.first,
        "SID_F_STOP_HZ": excitation.last,
        "SID_T_FADE_IN": SHAPE.fade_in,
        "SID_T_REC": excitation.duration,
        "SID_T_FADE_OUT": SHAPE.fade_out,
    }


def files(excitations: Sequence[Excitation], simulated: SimulatedVehicle) -> Mapping[str, bytes]:
    """Return a parameter file for each axis."""
    return {
        f"{k}_{entry.axis}.param": write_param(
            parameters(entry, simulated),
            "comma",
            (f"{entry.axis}: load it, hover, switch to SYSTEMID, and back when it is over",),
        )
        for k, entry in enumerate(excitations, start=1)
    }


EXCITATIONS = ExcitationTarget(
    "ardupilot",
    TargetCapabilities({"roll": "angle", "pitch": "angle", "yaw": "rate", "lift": "acceleration"}, shape=SHAPE),
    files,
    (
        "SYSTEMID flies one axis each time it is switched on; load the next file in the air, with the sticks in the middle.",
        "The mode's amplitude does not fall with the frequency; feel the motors after each file.",
        "The mode has no position and no height hold; its pilot keeps both.",
        "The thrust's chirp is added to the throttle, which is thrust as far as MOT_THST_EXPO fits the motors.",
        "Log IMU and motors fast: identification reads the messages IMU and RCOU.",
    ),
)
