"""Pitch of a small fixed-wing aircraft about level flight, in the gusts that it flies through.

The Aerosonde of R. W. Beard, T. W. McLain, "Small Unmanned Aircraft", Princeton 2012, with the coefficients of their revised
appendix E. Airspeed is held; all states are departures from trim. A negative elevator raises the nose.
"""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    pitch: Annotated[float, "rad"]
    pitch_rate: Annotated[float, "rad/s"]
    downward_speed: Annotated[float, "m/s"]


class Input(NamedTuple):
    elevator: Annotated[float, "rad"]


class Disturbance(NamedTuple):
    updraught: Annotated[float, "m/s"]


class Parameters(NamedTuple):
    mass: Annotated[float, "kg"] = 11.0
    inertia: Annotated[float, "kg m2"] = 1.135
    wing_area: Annotated[float, "m2"] = 0.55
    chord: Annotated[float, "m"] = 0.19
    air_density: Annotated[float, "kg/m3"] = 1.2682
    airspeed: Annotated[float, "m/s"] = 25.0
    lift_by_angle: Annotated[float, "1/rad"] = 5.61
    lift_by_rate: Annotated[float, "1/rad"] = 7.95
    lift_by_elevator: Annotated[float, "1/rad"] = 0.13
    moment_by_angle: Annotated[float, "1/rad"] = -2.74
    moment_by_rate: Annotated[float, "1/rad"] = -38.21
    moment_by_elevator: Annotated[float, "1/rad"] = -0.99


class Output(NamedTuple):
    pitch: Annotated[float, "rad"]
    pitch_rate: Annotated[float, "rad/s"]


def derivative(state, input, disturbance, p):
    force = 0.5 * p.air_density * p.airspeed * p.airspeed * p.wing_area
    angle = (state.downward_speed + disturbance.updraught) / p.airspeed
    rate = p.chord / (2.0 * p.airspeed) * state.pitch_rate
    lift = force * (p.lift_by_angle * angle + p.lift_by_rate * rate + p.lift_by_elevator * input.elevator)
    moment = p.moment_by_angle * angle + p.moment_by_rate * rate + p.moment_by_elevator * input.elevator
    return State(
        state.pitch_rate,
        force * p.chord * moment / p.inertia,
        p.airspeed * state.pitch_rate - lift / p.mass,
    )


def output(state, input, disturbance, p):
    return Output(state.pitch, state.pitch_rate)
