"""Pendulum on a geared motor: nonlinear, held off its rest by a torque."""

from typing import Annotated, NamedTuple

from plant.primitives import sin


class State(NamedTuple):
    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]


class Input(NamedTuple):
    torque: Annotated[float, "N m"]


class Disturbance(NamedTuple):
    push: Annotated[float, "N m"]


class Parameters(NamedTuple):
    inertia: Annotated[float, "kg m2"] = 0.02
    friction: Annotated[float, "N m s"] = 0.01
    weight: Annotated[float, "N m"] = 0.5
    start: Annotated[float, "rad"] = 0.3


class Output(NamedTuple):
    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]


def derivative(state, input, disturbance, p):
    torque = input.torque + disturbance.push - p.weight * sin(state.angle) - p.friction * state.speed
    return State(state.speed, torque / p.inertia)


def output(state, input, disturbance, p):
    return Output(state.angle, state.speed)


def rest(p):
    return State(p.start, 0.0), Input(p.weight * sin(p.start))
