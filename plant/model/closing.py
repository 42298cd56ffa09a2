"""The closed loop of a plant of the user's own: its records and functions, put together from the plan of its channels.

At t = k h the controller (`plant.model.controller`) reads the outputs and decides; actuators lag and the plant moves over the
period by Runge-Kutta steps. Outputs at k are those at the end of the period before, with the input and the
disturbance of that period, so no loop is closed without a state in it.

Model functions have no loops over fields, so the functions are written out, line by line, for the channels at hand.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from plant.loop import LARGEST_STATE, ClosedLoop, LoopRecords, MeterModel
from plant.model.controller import PlantController, plant_controller
from plant.model.functions import written
from plant.model.plan import LoopPlan
from plant.model.plant_model import PlantModel, PlantRecords
from plant.primitives import absolute, both, either, select
from plant.records import axpy_of, flatten, pack, paths, record_type, selector
from plant.sample import AxisSample, Target

Function = Callable[..., Any]


class Lag(NamedTuple):
    """Pole of an actuator [1/s]; 0 for none, where the plant feels the command itself."""

    pole: float


@dataclass(frozen=True)
class PlantLoop(ClosedLoop):
    """The closed loop of a plant, bound to its channels and to meters."""

    plant: PlantRecords
    plan: LoopPlan
    controller: PlantController


def body_type(plant: PlantRecords) -> Any:
    """Return the record of the plant's state with its actuators and what its outputs show."""
    return record_type("Body", {"state": plant.State, "actuators": plant.Input, "shown": plant.Output})


def dynamics_type(plant: PlantRecords, plan: LoopPlan) -> Any:
    """Return the record of the constants of the plant that flies."""
    lags = record_type("Lags", {actuator.name: Lag for actuator in plan.actuators})
    return record_type("PlantDynamics", {"parameters": plant.Parameters, "lags": lags})


def stepping(plant: PlantModel, plan: LoopPlan) -> Function:
    """Return advance(body, command, disturbance, dynamics, h): one classical Runge-Kutta step of plant and actuators."""
    State, Input = plant.State, plant.Input
    Body = body_type(plant)
    Moving = record_type("Moving", {"state": State, "actuators": Input})
    names = {
        "State": State,
        "Input": Input,
        "Body": Body,
        "Moving": Moving,
        "derivative": plant.derivative,
        "output": plant.output,
        "axpy": axpy_of(Moving),
        "select": select,
        "lagged": lagged,
        "felt": felt,
    }
    inputs = paths(Input)
    moving = ", ".join(f"lagged(at.actuators.{name}, command.{name}, f.lags.{name}.pole)" for name in inputs)
    acting = ", ".join(f"felt(at.actuators.{name}, command.{name}, lags.{name}.pole)" for name in inputs)
    names["acting"] = written("acting", ["def acting(at, command, lags):", f"    return Input({acting})"], names)
    rate = [
        "def rate(at, command, disturbance, f):",
        "    return Moving(",
        "        derivative(at.state, acting(at, command, f.lags), disturbance, f.parameters),",
        f"        Input({moving}),",
        "    )",
    ]
    names["rate"] = written("rate", rate, names)
    step = [
        "def advance(body, command, disturbance, f, h):",
        "    at = Moving(body.state, body.actuators)",
        "    k1 = rate(at, command, disturbance, f)",
        "    k2 = rate(axpy(at, 0.5 * h, k1), command, disturbance, f)",
        "    k3 = rate(axpy(at, 0.5 * h, k2), command, disturbance, f)",
        "    k4 = rate(axpy(at, h, k3), command, disturbance, f)",
        "    end = axpy(axpy(axpy(axpy(at, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4)",
        "    now = acting(end, command, f.lags)",
        "    return Body(end.state, now, output(end.state, now, disturbance, f.parameters))",
    ]
    return written("advance", step, names)


def lagged(position: float, command: float, pole: float) -> float:
    """Rate of a first-order actuator [unit/s]: (command - position)/lag."""
    return pole * (command - position)


def felt(position: float, command: float, pole: float) -> float:
    """Return the input that the plant feels: where the actuator is, or the command where it has no lag."""
    return select(pole > 0.0, position, command)


def resting(loop: PlantLoop, parameters: Any) -> tuple[Any, Any]:
    """Return the constants of a plant with these parameters, and its body where it rests under no disturbance."""
    poles = [1.0 / actuator.lag if actuator.lag > 0.0 else 0.0 for actuator in loop.plan.actuators]
    return pack(loop.records.Dynamics, [*flatten(parameters), *poles]), loop.Body(*loop.plant.at_rest(parameters))


def to_plant(command: float, channel: float) -> float:  # noqa: ARG001
    """Return the command of an input as it goes to the plant; margins break the loop of a channel here."""
    return command


def close_plant(plant: PlantRecords, plan: LoopPlan, meter: MeterModel, h: float) -> PlantLoop:
    """Bind the closed loop of a plant to the plan of its channels and to the meters that judge it, at control period h [s]."""
    controller = plant_controller(plant, plan, h)
    Noise = record_type("PlantNoise", {"output": plant.Output})
    Targets = record_type("Targets", dict.fromkeys(plan.judged, Target))
    Limits = record_type("Limits", dict.fromkeys(plan.judged, float))
    axes = dict.fromkeys(plan.judged, AxisSample)
    Sample = record_type(
        "PlantSample", {"time": float, **axes, "command": plant.Input, "previous": plant.Input, "saturated": float}
    )
    Flight = record_type(
        "PlantFlight",
        {
            "body": body_type(plant),
            "speed": plant.Input,
            "control": controller.Memory,
            "meters": meter.Meters,
            "status": float,
            "end_time": float,
        },
    )
    records = LoopRecords(
        controller.Gains,
        controller.Nominal,
        controller.Reference,
        plant.Disturbance,
        Noise,
        dynamics_type(plant, plan),
        Targets,
        Limits,
        len(paths(plant.Disturbance)),
    )
    names = {
        "Flight": Flight,
        "Sample": Sample,
        "AxisSample": AxisSample,
        "Input": plant.Input,
        "Output": plant.Output,
        "control_start": controller.start,
        "control_step": controller.step,
        "to_plant": to_plant,
        "meter_start": meter.start,
        "meter_update": meter.update,
        "keep_meters": selector(meter.Meters),
        "select": select,
        "both": both,
        "either": either,
        "absolute": absolute,
        "LARGEST": LARGEST_STATE,
    }
    for name, lines in (("sense", _sense_lines(plant)), ("status_of", _status_lines(plant, plan))):
        names[name] = written(name, lines, names)
    start, decide = written("start", _start_lines(plan), names), written("decide", _decide_lines(plan), names)
    advance = stepping(plant, plan) if isinstance(plant, PlantModel) else standing
    return PlantLoop(
        plant.name,
        records,
        controller.Constants,
        Flight,
        controller.prepare,
        place,
        start,
        decide,
        advance,
        plant,
        plan,
        controller,
    )


def _sense_lines(plant: PlantRecords) -> list[str]:
    each = ", ".join(f"shown.{path} + noise.output.{path}" for path in paths(plant.Output))
    return ["def sense(shown, noise):", f"    return Output({each})"]


def _status_lines(plant: PlantRecords, plan: LoopPlan) -> list[str]:
    """Lines of status_of(state, sample, limits): 0 while the flight may go on, 2 beyond a limit, 3 where it is no number."""
    size = " + ".join(f"state.{path} * state.{path}" for path in paths(plant.State))
    lines = ["def status_of(state, sample, limits):", f"    size = {size}", "    inside = size < LARGEST"]
    for name in plan.judged:
        error = f"absolute(sample.{name}.reference - sample.{name}.actual)"
        lines.append(f"    inside = both(inside, {error} < limits.{name})")
    return [*lines, "    return select(size < LARGEST, select(inside, 0.0, 2.0), 3.0)"]


def _axes(plan: LoopPlan, commanded: str) -> str:
    """Expressions of the samples of all channels; commanded: of the set point of an inner one, from OUTER and OUTPUT."""
    goals = {
        each.name: commanded.format(outer=plan.commanded[each.name], output=each.output)
        if each.name in plan.commanded
        else f"reference.{each.name}.value"
        for each in plan.channels
    }
    channels = [f"AxisSample({goals[each.name]}, body.shown.{each.output})" for each in plan.channels]
    return ", ".join((*channels, *[signal.expression for signal in plan.watched]))


def _start_lines(plan: LoopPlan) -> list[str]:
    return [
        "def start(body, constants, nominal, reference, noise, targets, dynamics):",
        "    held = body.actuators",
        "    control = control_start(constants, nominal, sense(body.shown, noise), held)",
        f"    sample = Sample(0.0, {_axes(plan, 'body.shown.{output}')}, held, held, 0.0)",
        "    return Flight(body, held, control, meter_start(sample, targets), 0.0, 0.0)",
    ]


def _decide_lines(plan: LoopPlan) -> list[str]:
    return [
        "def decide(flight, constants, nominal, reference, noise, targets, limits, time, h):",
        "    body, before = flight.body, flight.control",
        "    control = control_step(before, constants, nominal, reference, sense(body.shown, noise), h)",
        f"    speed = Input({', '.join(_sent(each.name, plan) for each in plan.actuators)})",
        f"    saturated = {_saturated(plan)}",
        f"    sample = Sample(time, {_axes(plan, 'control.commands.{outer}')}, control.command, before.command, saturated)",
        "    status = select(flight.status < 0.5, status_of(body.state, sample, limits), flight.status)",
        "    alive = status < 0.5",
        "    meters = keep_meters(alive, meter_update(flight.meters, sample, targets, h), flight.meters)",
        "    end_time = select(alive, time + h, flight.end_time)",
        "    return Flight(body, speed, control, meters, status, end_time)",
    ]


def _sent(name: str, plan: LoopPlan) -> str:
    """Expression of an input as it goes to the plant."""
    first = plan.acting_on(name)[:1]
    force = f"control.in_force.{name}"
    return f"to_plant({force}, {plan.number(first[0].name)})" if first else force


def _saturated(plan: LoopPlan) -> str:
    """Expression that is 1 where any input is not what channels want of it."""
    limited = [f"absolute(control.shortfall.{each.name}) > 0.0" for each in plan.actuators if each.bounded]
    any_of_them = limited[0] if limited else ""
    for condition in limited[1:]:
        any_of_them = f"either({any_of_them}, {condition})"
    return f"select({any_of_them}, 1.0, 0.0)" if limited else "0.0"


def standing(body: Any, command: Any, disturbance: Any, f: Any, h: float) -> Any:  # noqa: ARG001
    """Return the body as it is: the equations of a plant that moves in a process of its own are not known here."""
    return body


def place(body: Any, reference: Any) -> Any:  # noqa: ARG001
    """Return the body as it was drawn: a plant starts where it rests, not where its reference starts."""
    return body
