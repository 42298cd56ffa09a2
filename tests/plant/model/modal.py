"""Any linear plant of one input: a slow part, which may be unstable, and two oscillating modes."""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    place: Annotated[float, "m"]
    speed: Annotated[float, "m/s"]
    first: Annotated[float, "m"]
    first_speed: Annotated[float, "m/s"]
    second: Annotated[float, "m"]
    second_speed: Annotated[float, "m/s"]


class Input(NamedTuple):
    force: Annotated[float, "N"]


class Disturbance(NamedTuple):
    push: Annotated[float, "N"]


class Parameters(NamedTuple):
    stiffness: Annotated[float, "1/s2"] = 0.0
    friction: Annotated[float, "1/s"] = 0.0
    first_frequency: Annotated[float, "rad/s"] = 50.0
    first_damping: Annotated[float, "1"] = 0.01
    first_share: Annotated[float, "1"] = -1.0
    second_frequency: Annotated[float, "rad/s"] = 80.0
    second_damping: Annotated[float, "1"] = 0.5
    second_share: Annotated[float, "1"] = 0.0


class Output(NamedTuple):
    place: Annotated[float, "m"]
    speed: Annotated[float, "m/s"]


def derivative(state, input, disturbance, p):
    force = input.force + disturbance.push
    return State(
        state.speed,
        force - p.stiffness * state.place - p.friction * state.speed,
        state.first_speed,
        p.first_share * force
        - p.first_frequency * p.first_frequency * state.first
        - 2.0 * p.first_damping * p.first_frequency * state.first_speed,
        state.second_speed,
        p.second_share * force
        - p.second_frequency * p.second_frequency * state.second
        - 2.0 * p.second_damping * p.second_frequency * state.second_speed,
    )


def output(state, input, disturbance, p):
    return Output(state.place + state.first + state.second, state.speed + state.first_speed + state.second_speed)
