"""Angle of a DC motor, and how far its winding warms."""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]
    warmth: Annotated[float, "K"]


class Input(NamedTuple):
    voltage: Annotated[float, "V"]


class Parameters(NamedTuple):
    inertia: Annotated[float, "kg m2"] = 3.2284e-6
    friction: Annotated[float, "N m s"] = 3.5077e-6
    constant: Annotated[float, "N m/A"] = 0.0274
    resistance: Annotated[float, "Ohm"] = 4.0
    heat_capacity: Annotated[float, "J/K"] = 2.0
    heat_resistance: Annotated[float, "K/W"] = 15.0


class Output(NamedTuple):
    angle: Annotated[float, "rad"]
    warmth: Annotated[float, "K"]


def derivative(state, input, disturbance, p):
    current = (input.voltage - p.constant * state.speed) / p.resistance
    torque = p.constant * current - p.friction * state.speed
    heat = p.resistance * current * current - state.warmth / p.heat_resistance
    return State(state.speed, torque / p.inertia, heat / p.heat_capacity)


def output(state, input, disturbance, p):
    return Output(state.angle, state.warmth)
