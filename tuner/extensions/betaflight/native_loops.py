"""Betaflight's own loops as settings: the integers of a profile are the gains, and its filters are set to what flies.

Low-passes that follow the throttle are set to a fixed cut-off, and terms that our law has not (D max, anti-gravity, feed-forward
of angle mode) are switched off. I-term relax and TPA are of the loops. Dynamic notches stay as they are on the vehicle, as does
the RPM filter where the controller has no notches that follow the rotors.
"""

from collections.abc import Mapping

from plant.errors import InputError
from plant.quadrotor.airframes.actuation import Actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.extensions.autopilots.native_loops import NativeLaw, native_gains, with_authorities
from tuner.extensions.autopilots.parameters import ParameterInfo, parameter_table
from tuner.extensions.autopilots.pid import with_gains
from tuner.extensions.betaflight.map import NAMES, OFF, TABLE, betaflight_torque
from tuner.extensions.betaflight.rpm_filter import RPM_TABLE, rpm_differences, rpm_settings
from tuner.gains import Controller

# Low-pass that acts at rest: the one that follows the throttle begins at its least cut-off, unless that is 0.
FOLLOWING = {"gyro_lpf1_static_hz": "gyro_lpf1_dyn_min_hz", "dterm_lpf1_static_hz": "dterm_lpf1_dyn_min_hz"}
FILTERS = {
    "gyro_lpf1": "gyro_lpf1_static_hz",
    "gyro_lpf2": "gyro_lpf2_static_hz",
    "notch": "gyro_notch1_hz",
    "notch_cutoff": "gyro_notch1_cutoff",
    "d_lpf1": "dterm_lpf1_static_hz",
    "d_lpf2": "dterm_lpf2_static_hz",
}
LARGE = {"relax_cutoff": "iterm_relax_cutoff", "tpa_rate": "tpa_rate", "tpa_breakpoint": "tpa_breakpoint"}
"""Parameters of I-term relax and TPA."""
NATIVE_TABLE = {
    **TABLE,
    **RPM_TABLE,
    **parameter_table(
        ParameterInfo("gyro_lpf1_static_hz", "Hz", 0.0, 1000.0, 250.0, "attitude.gyro_lpf1"),
        ParameterInfo("gyro_lpf1_dyn_min_hz", "Hz", 0.0, 1000.0, 250.0, OFF),
        ParameterInfo("gyro_lpf2_static_hz", "Hz", 0.0, 1000.0, 500.0, "attitude.gyro_lpf2"),
        ParameterInfo("gyro_notch1_hz", "Hz", 0.0, 1000.0, 0.0, "attitude.notch"),
        ParameterInfo("gyro_notch1_cutoff", "Hz", 0.0, 1000.0, 0.0, "attitude.notch_cutoff"),
        ParameterInfo("dterm_lpf1_static_hz", "Hz", 0.0, 1000.0, 75.0, "attitude.d_lpf1"),
        ParameterInfo("dterm_lpf1_dyn_min_hz", "Hz", 0.0, 1000.0, 75.0, OFF),
        ParameterInfo("dterm_lpf2_static_hz", "Hz", 0.0, 1000.0, 150.0, "attitude.d_lpf2"),
        ParameterInfo("iterm_relax_cutoff", "Hz", 1.0, 50.0, 15.0, "attitude.relax_cutoff"),
        ParameterInfo("tpa_rate", "%", 0.0, 100.0, 65.0, "attitude.tpa_rate"),
        ParameterInfo("tpa_breakpoint", "us", 1000.0, 2000.0, 1350.0, "attitude.tpa_breakpoint"),
    ),
}
# Kinds of the low-passes and of I-term relax, and sliders: setting -> what the export sets, the default.
NATIVE_SWITCHES = {
    "simplified_pids_mode": ("OFF", "RPY"),
    "simplified_gyro_filter": ("OFF", "ON"),
    "simplified_dterm_filter": ("OFF", "ON"),
    "iterm_relax_type": ("SETPOINT", "SETPOINT"),
    **dict.fromkeys(("gyro_lpf1_type", "gyro_lpf2_type", "dterm_lpf1_type", "dterm_lpf2_type"), ("PT1", "PT1")),
}
# Motion of the set point at which an integral stands still in angle mode [deg/s].
RELAX = 8.0
# iterm_relax by whether it is on for roll, pitch and yaw; tpa_mode by whether P loses as D does; defaults.
RELAXING = {(False, False, False): "OFF", (True, True, False): "RP", (True, True, True): "RPY"}
ATTENUATED = {False: "D", True: "PD"}
USUAL_MODES = {"iterm_relax": "RP", "tpa_mode": "D"}
NATIVE_LAW = NativeLaw(
    "betaflight",
    {
        axis: {
            **dict(zip("pid", NAMES[axis][:3], strict=True)),
            **FILTERS,
            **LARGE,
            **({"p_cutoff": "yaw_lowpass_hz"} if axis == "yaw" else {"angle_p": "angle_p_gain"}),
        }
        for axis in ATTITUDE_AXES
    },
    frozenset({"p", "i", "d"}),
)
SILENT = (
    *(name for names in NAMES.values() for name in (names.d_max, names.f)),
    "angle_feedforward",
    "anti_gravity_gain",
    "thrust_linear",
    *FOLLOWING.values(),
)
"""Numbers that are 0 with our law."""


def units(controller: Controller, rotors: Actuation) -> dict[str, float]:
    """Return the angular acceleration per unit of output [rad/s2]: at hover, by axis."""
    torques, inertia = betaflight_torque(rotors), controller.airframe.vehicle.inertia
    return {axis: torque / part for axis, torque, part in zip(ATTITUDE_AXES, torques, inertia, strict=True)}


def native_settings(controller: Controller, rotors: Actuation) -> dict[str, float]:
    """Return the settings of the loops, unrounded; raises InputError naming a gain that axes must share."""
    return {
        **NATIVE_LAW.to_parameters(controller, units(controller, rotors)),
        **dict.fromkeys(SILENT, 0.0),
        **rpm_settings(controller.options),
    }


def native_switches(controller: Controller) -> dict[str, tuple[str, str]]:
    """Return setting -> what is set, the default; raises InputError naming a gain where the firmware has no such choice."""
    gains = native_gains(controller, NATIVE_LAW.law)
    roll, pitch, yaw = (gains[axis]["relax"] > 0.0 for axis in ATTITUDE_AXES)
    relaxing = roll, pitch, yaw
    if relaxing not in RELAXING:
        given = ", ".join(f"{gains[axis]['relax']:g} for {axis}" for axis in ATTITUDE_AXES)
        raise InputError(
            f"given {given}; iterm_relax is off, for roll and pitch, or for all three", key="attitude.relax"
        )
    on_p = {gains[axis]["tpa_p"] > 0.5 for axis in ATTITUDE_AXES}
    if len(on_p) > 1:
        raise InputError("given 0 on some axes and 1 on others; tpa_mode is one for all", key="attitude.tpa_p")
    chosen = {"iterm_relax": RELAXING[relaxing], "tpa_mode": ATTENUATED[on_p.pop()]}
    return NATIVE_SWITCHES | {name: (choice, USUAL_MODES[name]) for name, choice in chosen.items()}


def native_held(controller: Controller, values: Mapping[str, float], rotors: Actuation) -> Controller:
    """Return the controller that flies with rounded settings; the heading loop and those of position stay as they are."""
    return with_gains(controller, NATIVE_LAW.to_gains(values, units(controller, rotors), controller))


def native_differences(controller: Controller) -> tuple[str, ...]:
    """Return sentences on the differences between Betaflight's loops and ours."""
    period = 1000.0 * controller.control_period
    stays = "dynamic notches" if controller.options.rpm_notches else "RPM and dynamic notches"
    return (
        "The position loops and the heading loop of yaw are not carried: in Betaflight the pilot, or a computer that takes the "
        "pilot's place, gives tilt, yaw rate and throttle; what is verified flies them as tuned.",
        f"The low-passes of gyro and D terms are set to fixed cut-offs, first order each; {stays} stay as they are on the "
        "vehicle, and what phase they take is not in the margins.",
        *rpm_differences(controller.options),
        "D max, feed-forward, anti-gravity and the sliders are switched off, for they act on sticks, throttle and large motions "
        "alone, or move the gains.",
        "TPA follows the throttle; what is verified has it at hover. I-term relax is that of angle mode; the threshold of rate "
        "mode is five times as large.",
        f"Our attitude loops run each {period:g} ms; Betaflight runs its loops at the gyro rate over pid_process_denom, "
        "0.125 to 1 ms, and the attitude that the level gain sees is an estimate.",
        "Thrust does not follow the command: the slope at hover counts, so loop gains grow with the throttle.",
    )


def native_read(
    controller: Controller, values: Mapping[str, float], modes: Mapping[str, str], rotors: Actuation
) -> Controller:
    """Return the controller with the settings of a vehicle as gains.

    values: complete, those of `OWN_TABLE`; modes: the settings that are choices, where they are given.
    """
    fixed = {name: values[low] or values[name] for name, low in FOLLOWING.items()}
    controller = with_authorities(controller, units(controller, rotors))
    gains = NATIVE_LAW.to_gains({**values, **fixed}, units(controller, rotors), controller)
    relax, tpa = (modes.get(name, usual) for name, usual in USUAL_MODES.items())
    on_p = float(tpa == ATTENUATED[True])
    return with_gains(
        controller, {axis: row._replace(relax=RELAX * relaxes(relax, axis), tpa_p=on_p) for axis, row in gains.items()}
    )


def relaxes(choice: str, axis: str) -> bool:
    """Return true where a choice of iterm_relax holds on an axis."""
    return choice != "OFF" and (axis != "yaw" or choice.startswith("RPY"))
