"""The traced entry points against the simulator's closed loop, and against CasADi, which knows nothing of our tracing."""

import numpy as np
import pytest

from objectives.margins.period import NO_METERS
from plant.backends.stepping import Inputs, fly_steps, unchanged
from plant.backends.symbolic import symbolic_function
from plant.laws.channel import Applied
from plant.loop import Timing
from plant.quadrotor.allocation import speed_commands
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.closed_loop import Limits, close_loop, held_by
from plant.quadrotor.nominal import ControlOptions
from plant.quadrotor.rigid_body import Body, dynamics
from plant.quadrotor.sample import Targets
from plant.quadrotor.sensors import Measurement, Noise, measure
from plant.quadrotor.trim import trim_of
from plant.records import flatten, pack
from plant.references.track import Reference
from tests.tuner.exchange.c99.compiled import build, uneven
from tests.tuner.exchange.c99.signals import attitude_inputs
from tests.tuner.exchange.controllers import controller
from tuner.exchange.c99.entries import AttitudeApplied, AttitudeMeasurement, AttitudeSetpoint, entries
from tuner.exchange.c99.quadrotor import constants_of, nominal_of
from tuner.extensions.processor_cost.inputs import typical_inputs

K = 120


def still(given):
    """Return the start of flights in still air: hover, as the trim of the vehicle has it."""
    return trim_of(given.airframe.vehicle, [0.0, 0.0, 0.0]).body[0]


def started(bound, given, m):
    """The state from which a flight in still air starts.

    `init` starts at the nominal hover thrust, the flight at the thrust of its rotor speeds: the same but for rounding.
    """
    knowledge, body = nominal_of(given), pack(Body, still(given).tolist())
    held = held_by(body, body.rotor_speed, euler_angles(body.attitude), knowledge)
    constants = constants_of(given)
    state = bound.State(given.cascade.start(constants, m, knowledge, held), held.thrust, held.thrust)
    np.testing.assert_allclose(flatten(bound.init(constants, knowledge, m)), flatten(state), rtol=1e-14, atol=1e-14)
    return state


def flown(given):
    """Every control instant of a flight with noise: (reference, measurement, rotor speeds in force, control memory)."""
    rng = np.random.default_rng(2)
    knowledge, h = nominal_of(given), given.control_period
    references = np.zeros((K, 14))
    references[:, 0], references[:, 2], references[:, 11], references[:, 13] = 0.5, -0.3, 0.4, 1.0
    references[K // 2 :, [9, 13]] = 0.1, 0.0
    noises = 0.01 * rng.standard_normal((K, 12))
    vehicle = given.airframe.vehicle
    lane = Inputs(np.array(flatten(dynamics(vehicle))), still(given), np.zeros((K, 12)), noises, references)
    seen = []

    def watch(k, flight):
        body, reference = flight.body, pack(Reference, references[k].tolist())
        m = measure(body, euler_angles(body.attitude), body.rate, pack(Noise, noises[k].tolist()))
        seen.append((reference, m, flight))

    targets = pack(Targets, [0.0] * len(flatten(pack(Targets, [0.0] * 100))))
    loop = close_loop(given.cascade, NO_METERS)
    gains = pack(given.cascade.Gains, given.gains)
    timing = Timing(h, given.plant_step)
    fly_steps(loop, unchanged, gains, knowledge, lane, targets, Limits(50.0, 0.0), timing, watch)
    return seen


@pytest.mark.parametrize("delay", [False, True])
@pytest.mark.parametrize("laws", [("pid", "hybrid"), ("ladrc", "pid")])
def test_the_step_is_what_the_simulator_decides(laws, delay):
    """Same commands in force, same pending ones, same memory, at every instant of a flight."""
    given = controller(*laws, options=ControlOptions(delay=delay))
    bound, constants, knowledge = entries(given.cascade), constants_of(given), nominal_of(given)
    flight_log = flown(given)
    state = started(bound, given, flight_log[0][1])
    for reference, m, flight in flight_log:
        command, state = bound.step(state, constants, knowledge, reference, m, given.control_period)
        assert state.control == flight.control
        assert command.rotor_thrust == state.in_force == flight.in_force
        assert state.pending == flight.pending
        assert speed_commands(command.rotor_thrust, knowledge) == flight.speed
        assert command.thrust == sum(command.rotor_thrust)
    if delay:
        assert state.pending != state.in_force


def test_the_attitude_loops_are_those_of_the_cascade():
    """Fed with what the cascade's own attitude loops were given, they keep the same memories."""
    given = controller("pid", "hybrid_gsta")
    bound, constants, knowledge = entries(given.cascade), constants_of(given), nominal_of(given)
    instants = list(typical_inputs(given))
    first = instants[0].measurement
    state = bound.attitude_init(constants, AttitudeMeasurement(first.angles, first.rate))
    cascade = started(bound, given, first)
    for instant in instants:
        m = AttitudeMeasurement(instant.measurement.angles, instant.measurement.rate)
        _, cascade = bound.step(
            cascade, constants, knowledge, instant.reference, instant.measurement, given.control_period
        )
        goal = AttitudeSetpoint(*instant.goal[:2], instant.reference.yaw, instant.reference.yaw_rate)
        effect, excess = (
            type(m.rate)(*[getattr(entry, name) for entry in instant.applied]) for name in Applied._fields
        )
        torque, state = bound.attitude_step(
            state, constants, knowledge, goal, m, AttitudeApplied(effect, excess), given.control_period
        )
        assert (state.roll, state.pitch, state.yaw) == (
            cascade.control.roll,
            cascade.control.pitch,
            cascade.control.yaw,
        )
        assert all(np.isfinite(torque))


def test_casadi_agrees_with_the_compiled_code(tmp_path):
    """The three attitude loops of the nonlinear ADRC as CasADi's own graph, in double, over a run of steps."""
    given = uneven("pid", "adrc")
    compiled = build(tmp_path, {"oracle": (given, "double")})["oracle"]
    bound, constants, knowledge = entries(given.cascade), constants_of(given), nominal_of(given)

    attitude_step, h = bound.attitude_step, given.control_period

    def step(state, setpoint, m, applied):
        torque, after = attitude_step(state, constants, knowledge, setpoint, m, applied, h)
        return torque, after

    kinds = (bound.AttitudeState, AttitudeSetpoint, AttitudeMeasurement, AttitudeApplied)
    symbolic = symbolic_function("attitude_step", step, kinds)
    inputs = attitude_inputs("casadi", 200, 1)
    start, rows = inputs.start[:, 0], inputs.rows[:, :, 0]
    run = compiled.attitude_step(start, rows)
    state = np.array(flatten(bound.attitude_init(constants, pack(AttitudeMeasurement, start.tolist()))))
    for k, row in enumerate(rows):
        result = np.array(symbolic(state, row[:4], row[4:10], row[10:])).ravel()
        np.testing.assert_allclose(run.outputs[k], result[:3], rtol=1e-9, atol=1e-12)
        # Continue from the compiled state, so that differences of rounding do not add up through the sign of a root.
        state = run.states[k, : len(state)]
        np.testing.assert_allclose(state, result[3:], rtol=1e-9, atol=1e-12)


def test_a_measurement_record_is_what_the_header_says():
    """Members of the C structures are counted on in their order by the driver, the golden vectors and other exports."""
    assert Measurement._fields == ("position", "velocity", "angles", "rate", "thrust_direction", "heading")
    assert Reference._fields == ("position", "velocity", "acceleration", "roll", "pitch", "yaw", "yaw_rate", "hold")
