"""Two masses and a spring: a force on the first has to place the second, and nobody knows the spring.

B. Wie, D. S. Bernstein, "A benchmark problem for robust control design", American Control Conference 1990: masses of 1 kg, a
spring of 1 N/m without damping, a force on the first mass, the position of the second measured, a push on the second.
"""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    first: Annotated[float, "m"]
    second: Annotated[float, "m"]
    first_speed: Annotated[float, "m/s"]
    second_speed: Annotated[float, "m/s"]


class Input(NamedTuple):
    force: Annotated[float, "N"]


class Disturbance(NamedTuple):
    push: Annotated[float, "N"]


class Parameters(NamedTuple):
    first_mass: Annotated[float, "kg"] = 1.0
    second_mass: Annotated[float, "kg"] = 1.0
    stiffness: Annotated[float, "N/m"] = 1.0


class Output(NamedTuple):
    position: Annotated[float, "m"]


def derivative(state, input, disturbance, p):
    pull = p.stiffness * (state.second - state.first)
    return State(
        state.first_speed,
        state.second_speed,
        (input.force + pull) / p.first_mass,
        (disturbance.push - pull) / p.second_mass,
    )


def output(state, input, disturbance, p):
    return Output(state.second)
