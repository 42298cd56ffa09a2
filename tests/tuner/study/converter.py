"""Step-down converter, averaged over its switching period, about 5 V out of 12 V."""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    current: Annotated[float, "A"]
    voltage: Annotated[float, "V"]


class Input(NamedTuple):
    duty: Annotated[float, "1"]


class Disturbance(NamedTuple):
    load: Annotated[float, "A"]


class Parameters(NamedTuple):
    supply: Annotated[float, "V"] = 12.0
    inductance: Annotated[float, "H"] = 47e-6
    winding: Annotated[float, "Ohm"] = 0.05
    capacitance: Annotated[float, "F"] = 220e-6
    resistance: Annotated[float, "Ohm"] = 5.0


class Output(NamedTuple):
    voltage: Annotated[float, "V"]
    current: Annotated[float, "A"]


def rest(p):
    current = 5.0 / p.resistance
    return State(current, 5.0), Input((5.0 + p.winding * current) / p.supply)


def derivative(state, input, disturbance, p):
    coil = p.supply * input.duty - state.voltage - p.winding * state.current
    drawn = state.voltage / p.resistance + disturbance.load
    return State(coil / p.inductance, (state.current - drawn) / p.capacitance)


def output(state, input, disturbance, p):
    return Output(state.voltage, state.current)
