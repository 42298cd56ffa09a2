"""Random inputs of the exported entry points, sized so that most steps stay between the limits, and the oracles' runs of them."""

from dataclasses import dataclass

import numpy as np

from plant import primitives
from plant.backends import vector_math
from plant.backends.c_code import REALS
from plant.backends.rebind import Rebinder
from plant.quadrotor.sensors import Measurement
from plant.records import flatten, pack
from plant.references.track import Reference
from plant.seeds import generator
from tuner.exchange.c99.entries import AttitudeApplied, AttitudeMeasurement, AttitudeSetpoint, entries
from tuner.exchange.c99.precision import as_signals, matrix, rebinder, signals
from tuner.exchange.c99.quadrotor import constants_of, nominal_of

LANES, STEPS = 16, 64
# RMS of each member: position, velocity, acceleration, roll, pitch, yaw, yaw rate; hold is 0 or 1.
REFERENCE = [0.1] * 3 + [0.1] * 3 + [0.2] * 3 + [0.1, 0.1, 0.03, 0.1, 1.0]
# Position, velocity, angles, rate, thrust direction, heading.
MEASUREMENT = [0.05] * 3 + [0.05] * 3 + [0.01, 0.01, 0.01] + [0.03] * 3 + [0.1, 0.1, 0.1] + [0.7, 0.7, 0.0]


@dataclass(frozen=True)
class Inputs:
    """start (members, lanes) and rows (steps, members, lanes)."""

    start: np.ndarray
    rows: np.ndarray


def step_inputs(name, steps=STEPS, lanes=LANES):
    rng = generator(5, f"tests/c99/step/{name}", 0)
    rows = rng.standard_normal((steps, 32, lanes)) * np.array(REFERENCE + MEASUREMENT)[:, None]
    rows[:, 13] = rows[:, 13] > -0.5
    rows[:, 14 + 14] += 0.9
    rows[:, [11, 14 + 8]] = turning(rows[:, [11, 14 + 8]])
    # Now and then a step is thirty times wilder, which takes it to the limits.
    rows[44::12, 14:] *= 30.0
    rows[26::12, :13] *= 30.0
    start = rng.standard_normal((18, lanes)) * np.array(MEASUREMENT)[:, None]
    start[8] = rows[0, 14 + 8]
    return Inputs(start, rows)


def turning(yaws):
    """Yaws (steps, ., lanes) about a steady turn of 0.1 rad a step, as sensors give them, between -pi and pi."""
    turn = 0.1 * np.arange(len(yaws))[:, None, None] + np.arange(yaws.shape[2])
    return np.remainder(turn + yaws + np.pi, 2.0 * np.pi) - np.pi


def attitude_inputs(name, steps=STEPS, lanes=LANES):
    rng = generator(5, f"tests/c99/attitude/{name}", 0)
    sizes = np.array([0.2, 0.2, 0.1, 0.3] + [0.2, 0.2, 0.1] + [0.3] * 3 + [0.02] * 6)
    rows = rng.standard_normal((steps, 16, lanes)) * sizes[:, None]
    rows[:, [2, 6]] = turning(rows[:, [2, 6]])
    rows[7::8] *= 30.0
    start = rng.standard_normal((6, lanes)) * sizes[4:10, None]
    start[2] = rows[0, 6]
    return Inputs(start, rows)


def expected_step(controller, real_name, inputs):
    """Outputs (steps, 8, lanes) and states (steps, ., lanes) of the model functions on arrays of the precision."""
    real = REALS[real_name]
    bound, bind = entries(controller.cascade), rebinder(real)
    constants, knowledge, h = constants_of(controller), nominal_of(controller), controller.control_period
    step, lanes = bind(bound.step), inputs.rows.shape[2]
    state = as_signals(bind(bound.init)(constants, knowledge, signals(Measurement, inputs.start, real)), real, lanes)
    outputs, states = [], []
    for row in inputs.rows:
        reference, m = signals(Reference, row[:14], real), signals(Measurement, row[14:], real)
        command, state = step(state, constants, knowledge, reference, m, h)
        command, state = as_signals(command, real, lanes), as_signals(state, real, lanes)
        outputs.append(matrix(command))
        states.append(matrix(state))
    return np.array(outputs), np.array(states)


def expected_attitude_step(controller, real_name, inputs):
    """Outputs (steps, 3, lanes) and states (steps, ., lanes) of the model functions on arrays of the precision."""
    real = REALS[real_name]
    bound, bind = entries(controller.cascade), rebinder(real)
    constants, knowledge, h = constants_of(controller), nominal_of(controller), controller.control_period
    step, lanes = bind(bound.attitude_step), inputs.rows.shape[2]
    state = as_signals(
        bind(bound.attitude_init)(constants, signals(AttitudeMeasurement, inputs.start, real)), real, lanes
    )
    outputs, states = [], []
    for row in inputs.rows:
        setpoint, m = signals(AttitudeSetpoint, row[:4], real), signals(AttitudeMeasurement, row[4:10], real)
        applied = signals(AttitudeApplied, row[10:], real)
        torque, state = step(state, constants, knowledge, setpoint, m, applied, h)
        torque, state = as_signals(torque, real, lanes), as_signals(state, real, lanes)
        outputs.append(matrix(torque))
        states.append(matrix(state))
    return np.array(outputs), np.array(states)


def plain(function):
    """The model function itself, but with the arc tangent of `vector_math`."""
    names = {name: getattr(primitives, name) for name in primitives.__all__}
    inner = Rebinder(names)
    return Rebinder(names | {"atan2": inner(vector_math.atan2), "asin": inner(vector_math.asin)})(function)


def plain_step(controller, inputs, lane):
    """Outputs and states (steps, .) of the model functions on Python floats."""
    bound = entries(controller.cascade)
    constants, knowledge, h = constants_of(controller), nominal_of(controller), controller.control_period
    step = plain(bound.step)
    state = plain(bound.init)(constants, knowledge, pack(Measurement, inputs.start[:, lane].tolist()))
    rows = []
    for row in inputs.rows[:, :, lane].tolist():
        command, state = step(state, constants, knowledge, pack(Reference, row[:14]), pack(Measurement, row[14:]), h)
        rows.append([*flatten(command), *flatten(state)])
    table = np.array(rows)
    return table[:, :8], table[:, 8:]


def plain_attitude_step(controller, inputs, lane):
    """Outputs and states (steps, .) of the attitude loops on Python floats."""
    bound = entries(controller.cascade)
    constants, knowledge, h = constants_of(controller), nominal_of(controller), controller.control_period
    step = plain(bound.attitude_step)
    state = plain(bound.attitude_init)(constants, pack(AttitudeMeasurement, inputs.start[:, lane].tolist()))
    rows = []
    for row in inputs.rows[:, :, lane].tolist():
        given = pack(AttitudeSetpoint, row[:4]), pack(AttitudeMeasurement, row[4:10]), pack(AttitudeApplied, row[10:])
        torque, state = step(state, constants, knowledge, *given, h)
        rows.append([*flatten(torque), *flatten(state)])
    table = np.array(rows)
    return table[:, :3], table[:, 3:]
