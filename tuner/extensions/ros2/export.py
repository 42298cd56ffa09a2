"""ROS 2: parameters of two `pid_controller/PidController` of ros2_control, one for the attitude, one for the position.

For a vehicle whose hardware interface takes torques and whose controller manager runs the controllers. With position and
velocity as state and reference interfaces, the controller computes  u = p (r - y) + i-term + d (r' - y'), which is our PID as it
stands, times the inertia: p = J kp [N m/rad], i = J ki [N m/(rad s)], d = J kd [N m s/rad]; times the mass for positions. Its
integral takes effect one period after it is formed, as ours does, and its back-calculation with the tracking time constant kp/ki
is ours too. ros-controls/ros2_controllers, pid_controller/src/pid_controller.yaml and ros-controls/control_toolbox,
control_toolbox/src/pid.cpp, as of 2025.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite, tan

import numpy as np

from plant.errors import InputError, one_line
from plant.input_files import given_text, read_input
from plant.laws.pid import Gains
from plant.quadrotor.airframes.derived import quantities
from plant.quadrotor.cascade import ATTITUDE_AXES, MIN_LIFT, POSITION_AXES
from plant.records import flatten, pack
from tuner.exchange.aboard import rollback_request
from tuner.exchange.target import Bundle, ExportTarget, HeldParameter, Request
from tuner.exchange.texts import heading
from tuner.extensions.autopilots.pid import rate_sources, with_measured_rates
from tuner.gains import Controller

ATTITUDE, POSITION = "attitude_pid", "position_pid"
NODES = {ATTITUDE: ATTITUDE_AXES, POSITION: POSITION_AXES}
FILE = "gainproof_pid.yaml"

# Every field of the controllers' schema that this file writes -> its type, as a node declares it: a value of another type is
# refused when the node starts. "*" stands for the name of a degree of freedom.
SCHEMA = {
    "dof_names": "string_array",
    "command_interface": "string",
    "reference_and_state_interfaces": "string_array",
    "gains.*.p": "double",
    "gains.*.i": "double",
    "gains.*.d": "double",
    "gains.*.u_clamp_max": "double",
    "gains.*.u_clamp_min": "double",
    "gains.*.i_clamp_max": "double",
    "gains.*.i_clamp_min": "double",
    "gains.*.antiwindup_strategy": "string",
    "gains.*.tracking_time_constant": "double",
    "gains.*.angle_wraparound": "bool",
}


@dataclass(frozen=True)
class AxisOutput:
    """inertia [kg m2, or kg]: turns gains into p, i, d; low, high: limits of the controller's output [N m, or N]."""

    inertia: float
    low: float
    high: float


def axes_of(controller: Controller) -> dict[str, AxisOutput]:
    """Return each axis's factor of gains (to torque or force) and output limits.

    Torques: the largest that the rotors have at hover. Forces: the tilt cone at hover, and for z what the rotors and the bound on
    sinking leave besides the weight.
    """
    vehicle = controller.airframe.vehicle
    weight = vehicle.mass * vehicle.gravity
    derived = quantities(vehicle)
    sideways = weight * tan(controller.options.tilt_limit)
    lift = 4.0 * vehicle.thrust_coefficient * vehicle.speed_max**2 - weight
    torque = {axis: derived[f"{axis}_torque"].value for axis in ATTITUDE_AXES}
    return {
        "x": AxisOutput(vehicle.mass, -sideways, sideways),
        "y": AxisOutput(vehicle.mass, -sideways, sideways),
        "z": AxisOutput(vehicle.mass, (MIN_LIFT - 1.0) * weight, lift),
        **{
            axis: AxisOutput(inertia, -torque[axis], torque[axis])
            for axis, inertia in zip(ATTITUDE_AXES, vehicle.inertia, strict=True)
        },
    }


def export(request: Request) -> Bundle:
    """Write the parameters; see `ExportTarget.export`. Raises InputError for a period of no whole number of Hz."""
    controller = request.controller
    refuse(controller)
    back, sentence = rollback(request)
    return Bundle(
        files={FILE: yaml(request)},
        rollback={FILE: back},
        held=held(controller),
        differences=(*differences(controller), sentence),
        target_version="ros2_controllers pid_controller and control_toolbox of 2025 (antiwindup_strategy, u_clamp)",
        parameters=tuple(parameters(controller)),
    )


def refuse(controller: Controller) -> None:
    """Raise InputError for a control period that the controller manager cannot keep."""
    rate = 1.0 / controller.control_period
    if round(rate) < 1 or abs(rate - round(rate)) > 1e-6 * rate:
        message = (
            f"given {controller.control_period:.10g} s, which is {rate:.10g} Hz; the controller manager takes a whole number "
            f"of Hz: tune with a period of 1/{max(1, round(rate))} s"
        )
        raise InputError(message, key="controller.control_period")


def rollback(request: Request) -> tuple[bytes, str]:
    """Return the file that restores the previous parameters, and its sentence."""
    if request.previous is not None and request.previous.suffix in (".yaml", ".yml"):
        return copied(request), "The rollback is a copy of the previous YAML file."
    earlier, sentence = rollback_request(request)
    laws = {earlier.controller.cascade.position.name, earlier.controller.cascade.attitude.name}
    if laws != {"pid"}:
        message = (
            f"its laws are {', '.join(sorted(laws))}; this target carries pid only: give the previous YAML file instead"
        )
        raise InputError(message, file=request.previous, key="controller")
    refuse(earlier.controller)
    return yaml(earlier, sentence), f"The rollback: {sentence[0].lower()}{sentence[1:]}"


def copied(request: Request) -> bytes:
    """Return the previous YAML file as it is; raises InputError where it is no parameter file."""
    assert request.previous is not None
    remedy = "give the YAML file that is flown now"
    if "ros__parameters:" not in given_text(request.previous, remedy):
        message = f"this key is missing, so no node would read the file; {remedy}"
        raise InputError(message, file=request.previous, key="ros__parameters")
    return read_input(request.previous)


def numbers(controller: Controller) -> dict[str, dict[str, float]]:
    """Return axis -> field -> value, unrounded: the target holds doubles."""
    gains = pack(controller.cascade.Gains, controller.gains)
    outputs = {}
    for name, axis in axes_of(controller).items():
        axis_gains: Gains = getattr(gains, name)
        fields = {
            "p": axis.inertia * axis_gains.kp,
            "i": axis.inertia * axis_gains.ki,
            "d": axis.inertia * axis_gains.kd,
        }
        # Without its own limits, which some versions take as 0, the integral would be cut off; it needs no more than the output.
        for limit in ("u_clamp", "i_clamp"):
            fields |= {f"{limit}_max": axis.high, f"{limit}_min": axis.low}
        if axis_gains.ki > 0.0:
            fields["tracking_time_constant"] = axis_gains.kp / axis_gains.ki
        outputs[name] = fields
    return outputs


def parameters(controller: Controller) -> list[HeldParameter]:
    """Return every number with its unit; the schema sets no limits but the sign of a gain."""
    listed = []
    for name, fields in numbers(controller).items():
        turn, unit = (" rad", "N.m") if name in ATTITUDE_AXES else (" m", "N")
        per = turn.strip()
        units = {"p": f"{unit}/{per}", "i": f"{unit}/({per}.s)", "d": f"{unit}.s/{per}", "tracking_time_constant": "s"}
        node = ATTITUDE if name in ATTITUDE_AXES else POSITION
        for field, value in fields.items():
            low = -np.inf if field.endswith("_min") else 0.0
            label = f"{node}.gains.{name}.{field}"
            usual = 0.0 if field in ("p", "i", "d") else None
            listed.append(HeldParameter(label, units.get(field, unit), value, float(double(value)), low, np.inf, usual))
    return listed


def held(controller: Controller) -> Controller:
    """Return the controller in the target: the same feedback without our filter of the rate."""
    gains = pack(controller.cascade.Gains, controller.gains)
    axes, written = axes_of(controller), numbers(controller)
    rows = []
    for name, axis_gains in gains._asdict().items():
        inertia, fields = axes[name].inertia, written[name]
        rounded = [float(double(fields[part])) / inertia for part in ("p", "i", "d")]
        rows.append(type(axis_gains)(*rounded, 0.0))
    return with_measured_rates(replace(controller, gains=tuple(flatten(tuple(rows)))))


def differences(controller: Controller) -> tuple[str, ...]:
    """Return the differences of the target besides the gains."""
    gains = pack(controller.cascade.Gains, controller.gains)
    longest = max(axis_gains.t_f for axis_gains in gains)
    return (
        f"The rate is not filtered: our derivative filters of up to {longest:g} s are absent, so the velocity interface must "
        "give rates that are smooth enough; margins and flights are worked out again without the filter.",
        "The derivative acts on the error of the rate: give 0, or the derivative of the setpoint, as the reference of the "
        "velocity interface; without one the controller differentiates the error and kicks on steps.",
        "Each output is limited on its own (u_clamp), at the largest torque or force that hover leaves; our limits are those of "
        "the rotors together, with yaw given up first.",
        "The acceleration of the reference is not fed forward.",
        "position_pid gives the force without the weight, in world axes [N]: adding the weight, limiting to the tilt cone and "
        "turning the force into roll, pitch and thrust are left to the node between the controllers.",
        "angle_wraparound is on for yaw, as our yaw error goes the short way round.",
        *rate_sources(controller),
    )


def double(value: float) -> str:
    """Return a double as YAML text that every reader takes for one: positional, shortest exact, always with a dot."""
    assert isfinite(value), value
    return np.format_float_positional(value, unique=True, trim="0")


def yaml(request: Request, sentence: str = "") -> bytes:
    """Return the whole file."""
    controller = request.controller
    lines = [f"# {line}" for line in (*heading(request, one_line), *((one_line(sentence),) if sentence else ()))]
    lines += [
        "# World ENU, body FLU (REP 103), rad. attitude: p N m/rad, i N m/(rad s), d N m s/rad, clamps N m;",
        "# position: p N/m, i N/(m s), d N s/m, clamps N; tracking_time_constant s.",
        "controller_manager:",
        "  ros__parameters:",
        f"    update_rate: {round(1.0 / controller.control_period)}  # Hz",
    ]
    for node in NODES:
        lines += [f"    {node}:", '      type: "pid_controller/PidController"']
    values = numbers(controller)
    for node, axes in NODES.items():
        lines += node_lines(node, {axis: values[axis] for axis in axes})
    return ("\n".join(lines) + "\n").encode()


def node_lines(node: str, values: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Return the lines of one controller."""
    names = ", ".join(f'"{axis}"' for axis in values)
    lines = [
        f"{node}:",
        "  ros__parameters:",
        f"    dof_names: [{names}]",
        '    command_interface: "effort"',
        '    reference_and_state_interfaces: ["position", "velocity"]',
        "    gains:",
    ]
    for axis, fields in values.items():
        strategy = "back_calculation" if "tracking_time_constant" in fields else "none"
        lines.append(f"      {axis}:")
        lines += [f"        {field}: {double(value)}" for field, value in fields.items()]
        lines.append(f'        antiwindup_strategy: "{strategy}"')
        lines.append(f"        angle_wraparound: {'true' if axis == 'yaw' else 'false'}")
    return lines


TARGET = ExportTarget(
    name="ros2",
    title="ROS 2, parameters of ros2_control's pid_controller (YAML)",
    export=export,
    position_laws=("pid",),
    attitude_laws=("pid",),
)
