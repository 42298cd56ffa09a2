"""A motor that turns a load through a soft shaft."""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    load_angle: Annotated[float, "rad"]
    twist: Annotated[float, "rad"]
    load_speed: Annotated[float, "rad/s"]
    motor_speed: Annotated[float, "rad/s"]


class Input(NamedTuple):
    torque: Annotated[float, "N m"]


class Disturbance(NamedTuple):
    load_torque: Annotated[float, "N m"]


class Parameters(NamedTuple):
    motor_inertia: Annotated[float, "kg m2"] = 0.001
    load_inertia: Annotated[float, "kg m2"] = 0.004
    stiffness: Annotated[float, "N m"] = 4.0
    shaft_damping: Annotated[float, "N m s"] = 0.005
    motor_friction: Annotated[float, "N m s"] = 0.002
    load_friction: Annotated[float, "N m s"] = 0.004


class Output(NamedTuple):
    load_angle: Annotated[float, "rad"]
    motor_speed: Annotated[float, "rad/s"]


def derivative(state, input, disturbance, p):
    twisting = state.motor_speed - state.load_speed
    shaft = p.stiffness * state.twist + p.shaft_damping * twisting
    return State(
        state.load_speed,
        twisting,
        (shaft - p.load_friction * state.load_speed + disturbance.load_torque) / p.load_inertia,
        (input.torque - shaft - p.motor_friction * state.motor_speed) / p.motor_inertia,
    )


def output(state, input, disturbance, p):
    return Output(state.load_angle, state.motor_speed)
