"""Export target `betaflight_adrc`: gains of a study as a file for the command line, without a vehicle's own file."""

from dataclasses import replace
from math import degrees

from plant.errors import InputError
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.exchange.target import Bundle, ExportTarget, Option, Request
from tuner.extensions.autopilots.native_loops import NativeLaw, native_gains
from tuner.extensions.autopilots.parameters import ParameterInfo, parameter_table, parameters
from tuner.extensions.autopilots.pid import with_gains
from tuner.extensions.betaflight.export import LOADING, bundle, nearest
from tuner.extensions.betaflight.map import ANGLE_LIMIT, NAMES, OFF, tilt_limit
from tuner.extensions.betaflight.native_loops import NATIVE_TABLE, units
from tuner.extensions.betaflight_adrc.adrc_law import LAW
from tuner.extensions.betaflight_adrc.export import COMMON_SETTINGS
from tuner.extensions.betaflight_adrc.settings import BUILDS, LAG, SCHEDULE, SETTINGS, Build, build_of

NAME = "Betaflight with ADRC"
GYRO_FILTERS = {"gyro_lpf1": "gyro_lpf1_static_hz", "gyro_lpf2": "gyro_lpf2_static_hz"}
NATIVE_LAW = NativeLaw(
    LAW.name,
    {
        axis: {
            **{name: f"adrc_{name}_{axis}" for name in ("wc", "wo", "b0")},
            **COMMON_SETTINGS,
            **GYRO_FILTERS,
            **(
                {"limit": "pidsum_limit_yaw"} if axis == "yaw" else {"limit": "pidsum_limit", "angle_p": "angle_p_gain"}
            ),
        }
        for axis in ATTITUDE_AXES
    },
    frozenset(),
)
"""Setting of each gain by axis; schedule and motor lag have settings in some builds alone."""
SILENT = (*(names.f for names in NAMES.values()), "angle_feedforward", "thrust_linear", "gyro_lpf1_dyn_min_hz")
"""Numbers that are 0 with the law: feed-forward, thrust linearization, and a low-pass that follows the throttle."""
FIXED_SWITCHES = {
    "pid_type": ("ADRC", "CLASSIC"),
    "simplified_gyro_filter": ("OFF", "ON"),
    "gyro_lpf1_type": ("PT1", "PT1"),
    "gyro_lpf2_type": ("PT1", "PT1"),
}
"""Setting -> word that is set, default."""
DIFFERENCES = (
    "The position loops and the heading loop of yaw are not carried: in Betaflight the pilot, or a computer that takes the "
    "pilot's place, gives tilt, yaw rate and throttle; what is verified flies them as tuned.",
    "In what is verified the gate is open and the schedule of b0 has the collective of hover; in Betaflight the schedule "
    "follows the collective, and before lift-off the settings of the ground act.",
    "Feed-forward and thrust linearization are switched off, and the low-passes of the gyro are set to fixed cut-offs, first "
    "order each.",
    "RPM and dynamic notches stay as they are on the vehicle, and what phase they take is not in the margins.",
)


def _info(name: str, source: str) -> ParameterInfo:
    setting = SETTINGS[name]
    return ParameterInfo(name, setting.unit, setting.low, setting.high, setting.default, source)


TABLE = {
    **parameter_table(
        *(
            _info(name, f"{axis}.{gain}")
            for axis, names in NATIVE_LAW.names.items()
            for gain, name in names.items()
            if name in SETTINGS
        ),
        _info(LAG, "roll.tau"),
    ),
    **{name: NATIVE_TABLE[name] for name in (*GYRO_FILTERS.values(), "angle_p_gain", ANGLE_LIMIT)},
    **{name: replace(NATIVE_TABLE[name], source=OFF) for name in SILENT},
}
"""Numbers of the file: unit, range, default."""


def export(request: Request) -> Bundle:
    """Return the file; raises InputError naming a gain that the build has no setting for."""
    controller, build = request.controller, build_of(request.settings["build"])
    rotors = actuation(controller.airframe.vehicle, None)
    acceleration = units(controller, rotors)
    gains = native_gains(controller, LAW.name)
    wanted = {
        **NATIVE_LAW.to_parameters(controller, acceleration),
        **_lag(gains["roll"]["tau"], build),
        **dict.fromkeys(SILENT, 0.0),
        ANGLE_LIMIT: degrees(controller.options.tilt_limit),
    }
    written = parameters(TABLE, wanted, nearest, NAME)
    values = {parameter.name: parameter.held for parameter in written}
    rows = NATIVE_LAW.to_gains(values, acceleration, controller)
    if LAG in values:
        rows |= {axis: rows[axis]._replace(tau=1e-3 * values[LAG]) for axis in ("roll", "pitch")}
    held = with_gains(controller, rows)
    held = replace(held, options=replace(controller.options, tilt_limit=tilt_limit(values)))
    switches = FIXED_SWITCHES | _schedule(gains["roll"]["schedule"], build)
    about = f"For {NAME} (pull request 15400), build {build.name}. {LOADING}"
    return bundle(request, rotors, NAME, about, TABLE, switches, written, held, DIFFERENCES)


def _lag(tau: float, build: Build) -> dict[str, float]:
    """Return the setting of a motor lag [s] in the observer; raises InputError where the build has none."""
    if build.has(LAG):
        return {LAG: 1e3 * tau}
    if tau > 0.0:
        message = (
            f"given {1e3 * tau:g} ms; build {build.name} has no motor lag in its observer: give 0, or --set build=mp2"
        )
        raise InputError(message, key="roll.tau")
    return {}


def _schedule(number: float, build: Build) -> dict[str, tuple[str, str]]:
    """Return the setting of the schedule with its default; raises InputError where the build has another one alone."""
    word = SETTINGS[SCHEDULE].text(number)
    if build.has(SCHEDULE):
        return {SCHEDULE: (word, build.schedule)}
    if word != build.schedule:
        raise InputError(
            f"given {word}; build {build.name} has the schedule {build.schedule} alone: give schedule = 0",
            key="roll.schedule",
        )
    return {}


TARGET = ExportTarget(
    name="betaflight_adrc",
    title="Betaflight with ADRC (pull request 15400), settings for the command line",
    export=export,
    attitude_laws=(LAW.name,),
    options=(
        Option("build", "build of the firmware", choices=tuple(BUILDS), default="pr"),
        Option("profile", "PID profile that is written, 0 to 3", default="0"),
    ),
    experimental="No released firmware has this law, and builds differ in their settings.",
)
