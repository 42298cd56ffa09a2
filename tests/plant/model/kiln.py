"""Kiln, held at temperature by the power of its element: slow, linear, and at rest far from 0."""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    element: Annotated[float, "degC"]
    chamber: Annotated[float, "degC"]


class Input(NamedTuple):
    power: Annotated[float, "W"]


class Disturbance(NamedTuple):
    door: Annotated[float, "W"]


class Parameters(NamedTuple):
    element_capacity: Annotated[float, "J/K"] = 2000.0
    chamber_capacity: Annotated[float, "J/K"] = 4e4
    conduction: Annotated[float, "W/K"] = 20.0
    loss: Annotated[float, "W/K"] = 8.0
    ambient: Annotated[float, "degC"] = 20.0
    hold: Annotated[float, "degC"] = 600.0


class Output(NamedTuple):
    chamber: Annotated[float, "degC"]


def derivative(state, input, disturbance, p):
    across = p.conduction * (state.element - state.chamber)
    lost = p.loss * (state.chamber - p.ambient) + disturbance.door
    return State((input.power - across) / p.element_capacity, (across - lost) / p.chamber_capacity)


def output(state, input, disturbance, p):
    return Output(state.chamber)


def rest(p):
    power = p.loss * (p.hold - p.ambient)
    return State(p.hold + power / p.conduction, p.hold), Input(power)
