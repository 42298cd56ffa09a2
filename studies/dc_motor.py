"""Angle of a DC motor, driven by a voltage.

Numbers of the motor position example of the Control Tutorials for MATLAB and Simulink (University of Michigan). Its inductance of
2.75 uH settles in under a microsecond and is left out.
"""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]


class Input(NamedTuple):
    voltage: Annotated[float, "V"]


class Disturbance(NamedTuple):
    torque: Annotated[float, "N m"]


class Parameters(NamedTuple):
    inertia: Annotated[float, "kg m2"] = 3.2284e-6
    friction: Annotated[float, "N m s"] = 3.5077e-6
    constant: Annotated[float, "N m/A"] = 0.0274
    resistance: Annotated[float, "Ohm"] = 4.0


class Output(NamedTuple):
    angle: Annotated[float, "rad"]


def derivative(state, input, disturbance, p):
    current = (input.voltage - p.constant * state.speed) / p.resistance
    torque = p.constant * current - p.friction * state.speed + disturbance.torque
    return State(state.speed, torque / p.inertia)


def output(state, input, disturbance, p):
    return Output(state.angle)
