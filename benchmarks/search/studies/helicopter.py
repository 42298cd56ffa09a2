"""Pitch and yaw of a helicopter with two propellers on a stand; each propeller turns both axes.

The 2 DOF Helicopter of Quanser, equations and numbers of its Laboratory Manual (2011).
"""

from typing import Annotated, NamedTuple

from plant.primitives import cos, sin

GRAVITY = 9.81


class State(NamedTuple):
    pitch: Annotated[float, "rad"]
    yaw: Annotated[float, "rad"]
    pitch_rate: Annotated[float, "rad/s"]
    yaw_rate: Annotated[float, "rad/s"]


class Input(NamedTuple):
    front: Annotated[float, "V"]
    tail: Annotated[float, "V"]


class Disturbance(NamedTuple):
    pitch_torque: Annotated[float, "N m"]
    yaw_torque: Annotated[float, "N m"]


class Parameters(NamedTuple):
    mass: Annotated[float, "kg"] = 1.3872
    offset: Annotated[float, "m"] = 0.186
    pitch_inertia: Annotated[float, "kg m2"] = 0.0384
    yaw_inertia: Annotated[float, "kg m2"] = 0.0432
    pitch_friction: Annotated[float, "N m s"] = 0.8
    yaw_friction: Annotated[float, "N m s"] = 0.318
    pitch_by_front: Annotated[float, "N m/V"] = 0.204
    pitch_by_tail: Annotated[float, "N m/V"] = 0.0068
    yaw_by_front: Annotated[float, "N m/V"] = 0.0219
    yaw_by_tail: Annotated[float, "N m/V"] = 0.072


class Output(NamedTuple):
    pitch: Annotated[float, "rad"]
    yaw: Annotated[float, "rad"]


def rest(p):
    torque = p.mass * GRAVITY * p.offset
    coupling = p.pitch_by_front * p.yaw_by_tail - p.pitch_by_tail * p.yaw_by_front
    return State(0.0, 0.0, 0.0, 0.0), Input(p.yaw_by_tail * torque / coupling, -p.yaw_by_front * torque / coupling)


def derivative(state, input, disturbance, p):
    arm = p.mass * p.offset * p.offset
    up, along = sin(state.pitch), cos(state.pitch)
    pitch_torque = p.pitch_by_front * input.front + p.pitch_by_tail * input.tail - p.mass * GRAVITY * p.offset * along
    yaw_torque = p.yaw_by_front * input.front + p.yaw_by_tail * input.tail
    pitch_torque = (
        pitch_torque - p.pitch_friction * state.pitch_rate - arm * up * along * state.yaw_rate * state.yaw_rate
    )
    yaw_torque = (
        yaw_torque - p.yaw_friction * state.yaw_rate + 2.0 * arm * up * along * state.yaw_rate * state.pitch_rate
    )
    return State(
        state.pitch_rate,
        state.yaw_rate,
        (pitch_torque + disturbance.pitch_torque) / (p.pitch_inertia + arm),
        (yaw_torque + disturbance.yaw_torque) / (p.yaw_inertia + arm * along * along),
    )


def output(state, input, disturbance, p):
    return Output(state.pitch, state.yaw)
