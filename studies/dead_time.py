"""First order plus dead time: the process that most rules for PI and PID controllers are written for.

The dead time is the delay of the actuator in the study. `load` enters with the input, `shift` adds to the output.
"""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    level: Annotated[float, "1"]


class Input(NamedTuple):
    valve: Annotated[float, "1"]


class Disturbance(NamedTuple):
    load: Annotated[float, "1"]
    shift: Annotated[float, "1"]


class Parameters(NamedTuple):
    gain: Annotated[float, "1"] = 1.0
    lag: Annotated[float, "s"] = 1.0


class Output(NamedTuple):
    level: Annotated[float, "1"]


def derivative(state, input, disturbance, p):
    return State((p.gain * (input.valve + disturbance.load) - state.level) / p.lag)


def output(state, input, disturbance, p):
    return Output(state.level + disturbance.shift)
