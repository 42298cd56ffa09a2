"""Angle of a DC motor, from plant to C99."""

from typing import Annotated, NamedTuple

from tuner.api.plants import LAWS, Actuator, Channel, export_plant, plant_system


class State(NamedTuple):
    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]
    current: Annotated[float, "A"]


class Input(NamedTuple):
    voltage: Annotated[float, "V"]


class Parameters(NamedTuple):
    inertia: Annotated[float, "kg m2"] = 3.2284e-6
    friction: Annotated[float, "N m s"] = 3.5077e-6
    constant: Annotated[float, "N m/A"] = 0.0274
    resistance: Annotated[float, "Ohm"] = 4.0
    inductance: Annotated[float, "H"] = 2.75e-3


class Output(NamedTuple):
    angle: Annotated[float, "rad"]


def derivative(state, input, disturbance, p):
    torque = p.constant * state.current - p.friction * state.speed
    voltage = input.voltage - p.constant * state.speed - p.resistance * state.current
    return State(state.speed, torque / p.inertia, voltage / p.inductance)


def output(state, input, disturbance, p):
    return Output(state.angle)


loops = [Channel("angle", LAWS["pid"], "angle", "voltage")], [Actuator("voltage", -12.0, 12.0, delay=0.002, lag=0.001)]
motor = plant_system(globals(), "motor", *loops, control_period=0.001)
export_plant(motor, [4.0, 20.0, 0.05, 0.005], "motor", real="double")
