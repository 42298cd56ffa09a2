"""Betaflight with pull request 15400: our linear ADRC of the attitude as `pid_type = ADRC`. Experimental.

Ours controls an angle: second-order plant, PD on angle and rate, third-order observer of the angle. Theirs controls a rate behind
the motors' lag: second-order plant again, PD on rate and angular acceleration, third-order observer of the rate,

    u = (wc^2 (r - z1) - 2 wc z2 - z3) / b0,    rate'' = f + b0 u,    b0 = G / (J tau)

so bandwidths carry over as numbers and by their meaning, not the loops. src/main/flight/adrc.c of that pull request.
"""

from dataclasses import replace
from math import degrees

from plant.errors import InputError
from plant.quadrotor.airframes.actuation import Actuation, actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from plant.quadrotor.gains import gain_addresses
from tuner.exchange.target import Bundle, ExportTarget, Request
from tuner.extensions.autopilots.assembly import curve
from tuner.extensions.autopilots.parameters import parameters
from tuner.extensions.betaflight.export import LOADING, OPTIONS, bundle, nearest
from tuner.extensions.betaflight.map import ADRC_SWITCHES, ADRC_TABLE, betaflight_torque
from tuner.gains import Controller

NAME = "Betaflight pull request 15400 (6317fe2)"
EXPERIMENTAL = (
    "Betaflight's ADRC is open pull request 15400, in no release; settings and law may change; its loop is on the rate."
)
# The damping ratio of their design.
ZETA, SAME = 1.0, 1e-9


def export(request: Request) -> Bundle:
    """Return the file; raises InputError where the gains have no counterpart or leave the ranges."""
    requested = request.controller
    check_damping(requested)
    rotors = actuation(requested.airframe.vehicle, curve(request.settings))
    written = parameters(ADRC_TABLE, to_adrc(requested, rotors), nearest, NAME)
    values = {parameter.name: parameter.held for parameter in written}
    about = f"For {NAME}. EXPERIMENTAL: {EXPERIMENTAL} {LOADING}"
    held, differences = held_controller(requested, values), _differences(requested, values, rotors)
    return bundle(request, rotors, NAME, about, ADRC_TABLE, ADRC_SWITCHES, written, held, differences)


def check_damping(controller: Controller) -> None:
    """Refuse a damping ratio other than theirs; raises InputError naming the gain."""
    for gain in gain_addresses(controller.cascade):
        value = controller.gains[gain.column]
        if gain.loop == "attitude" and gain.info.name == "zeta" and abs(value - ZETA) > SAME:
            raise InputError(
                f"given {value:g}; {NAME} has kp = wc^2 and kd = 2 wc, a damping ratio of 1: fix attitude.zeta = 1 in the study",
                key=gain.address,
            )


def to_adrc(controller: Controller, rotors: Actuation) -> dict[str, float]:
    """Return the settings, unrounded."""
    held = {gain.address: controller.gains[gain.column] for gain in gain_addresses(controller.cascade)}
    values: dict[str, float] = {}
    torques = betaflight_torque(rotors)
    for axis, inertia, torque in zip(ATTITUDE_AXES, controller.airframe.vehicle.inertia, torques, strict=True):
        values |= {
            f"adrc_wc_{axis}": held[f"{axis}.omega_c"],
            f"adrc_wo_{axis}": held[f"{axis}.omega_o"],
            f"adrc_b0_{axis}": degrees(torque / inertia) / rotors.lag,
        }
    return values | {"adrc_hover_throttle": 100.0 * rotors.hover_command, "adrc_sigma_decay": 0.0}


def held_controller(requested: Controller, values: dict[str, float]) -> Controller:
    """Return the controller with the bandwidths that the settings hold."""
    names = {"omega_c": "adrc_wc", "omega_o": "adrc_wo"}
    row = list(requested.gains)
    for gain in gain_addresses(requested.cascade):
        if gain.loop == "attitude" and gain.info.name in names:
            row[gain.column] = values[f"{names[gain.info.name]}_{gain.axis}"]
    return replace(requested, gains=tuple(row))


def _differences(controller: Controller, values: dict[str, float], rotors: Actuation) -> tuple[str, ...]:
    measured = controller.options.attitude_rate == "measured"
    source = "angle and rate as measured" if measured else "z1 and z2 of the observer"
    return (
        "The loops differ: ours is a PD on angle and rate with an observer of the angle, theirs a PD on rate and angular "
        "acceleration with an observer of the rate behind the motors; margins and flights of the verification are those of "
        "our law with rounded bandwidths, not of theirs.",
        "In angle mode theirs stands inside Betaflight's level loop (angle_p_gain, default 5 1/s), which is not written; the "
        "heading has no loop at all.",
        f"The input gain b0 is worked out from the airframe: roll {values['adrc_b0_roll']:.0f}, pitch "
        f"{values['adrc_b0_pitch']:.0f}, yaw {values['adrc_b0_yaw']:.0f} deg/s3 per unit of output, with a motor lag of "
        f"{1000.0 * rotors.lag:.3g} ms and the thrust slope at hover; ours takes 1/J and needs no lag.",
        f"Our law takes {source}; theirs always takes z1 and z2, of a gyro through adrc_gyro_lpf_hz (default 150 Hz).",
        f"Above the hover throttle ({values['adrc_hover_throttle']:.0f} %) theirs multiplies b0 by the square of the "
        "throttle ratio, up to adrc_b0_scale_max (default 3); ours is constant.",
        "The disturbance estimate z3 does not leak (adrc_sigma_decay = 0), as ours; theirs is clipped at pidsum_limit times "
        "b0 and fed nothing before lift-off, ours is not.",
        f"Theirs caps the observer at wo dt = 0.5 with dt of its own loop, 0.125 to 1 ms; ours runs each "
        f"{1000.0 * controller.control_period:g} ms.",
        "The position loops are not carried: the pilot, or a computer that takes the pilot's place, gives tilt and throttle.",
    )


TARGET = ExportTarget(
    name="betaflight-adrc",
    title="Betaflight with ADRC (pull request 15400), settings for the command line",
    export=export,
    attitude_laws=("ladrc",),
    options=OPTIONS,
    experimental=EXPERIMENTAL,
)
