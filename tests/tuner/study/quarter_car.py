"""Quarter car with an active suspension."""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    body: Annotated[float, "m"]
    body_speed: Annotated[float, "m/s"]
    wheel: Annotated[float, "m"]
    wheel_speed: Annotated[float, "m/s"]


class Input(NamedTuple):
    force: Annotated[float, "N"]


class Disturbance(NamedTuple):
    road: Annotated[float, "m"]


class Parameters(NamedTuple):
    body_mass: Annotated[float, "kg"] = 300.0
    wheel_mass: Annotated[float, "kg"] = 40.0
    spring: Annotated[float, "N/m"] = 16e3
    damper: Annotated[float, "N s/m"] = 1000.0
    tyre: Annotated[float, "N/m"] = 180e3


class Output(NamedTuple):
    speed: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]
    tyre_load: Annotated[float, "N"]
    stroke: Annotated[float, "m"]


def derivative(state, input, disturbance, p):
    strut = p.spring * (state.wheel - state.body) + p.damper * (state.wheel_speed - state.body_speed) + input.force
    tyre = p.tyre * (disturbance.road - state.wheel)
    return State(state.body_speed, strut / p.body_mass, state.wheel_speed, (tyre - strut) / p.wheel_mass)


def output(state, input, disturbance, p):
    rate = derivative(state, input, disturbance, p)
    return Output(
        state.body_speed, rate.body_speed, p.tyre * (disturbance.road - state.wheel), state.body - state.wheel
    )
