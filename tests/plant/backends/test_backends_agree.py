"""One source, four backends: python, numpy, compiled lanes and casadi give the same numbers on random states."""

from functools import cache

import numpy as np
import pytest

from objectives.margins.period import NO_METERS
from plant.backends import array, lanes, symbolic
from plant.contract.law_backends import backends_agree
from plant.law_registry import LAWS
from plant.quadrotor.airframes import load, names
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import close_loop
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.features import vehicle_features
from plant.quadrotor.nominal import ControlOptions, Nominal, nominal
from plant.quadrotor.rigid_body import Body, Dynamics, dynamics
from plant.quadrotor.sensors import Measurement
from plant.records import flatten, pack, size
from plant.references.track import Reference
from plant.vectors import Rotors

H = 0.004
SAMPLES = 6
# 1e-12 relative, of each number or of the size of the numbers it is a difference of (SCALE: accelerations of some 10 m/s2,
# thrusts of some N, rotor speeds of some 100 rad/s are formed on the way).
RELATIVE = 1e-12


def close(actual, wanted, scale):
    np.testing.assert_allclose(actual, wanted, rtol=RELATIVE, atol=RELATIVE * scale)


def airframe(name):
    return load(name, allow_unphysical=name == "paper-literal").vehicle


def random_body(draw, vehicle):
    q = np.array([1.0, 0.0, 0.0, 0.0]) + 0.3 * draw.normal(size=4)
    q /= np.linalg.norm(q, axis=0)
    hover = (vehicle.mass * vehicle.gravity / 4 / vehicle.thrust_coefficient) ** 0.5
    speed = hover * draw.uniform(0.5, 1.5, 4)
    return pack(Body, np.concatenate([draw.normal(size=6), q, 2.0 * draw.normal(size=3), speed]).tolist())


def columns(records):
    """Leaves of several records of one type as arrays over them."""
    return [np.array(leaf) for leaf in zip(*[flatten(record) for record in records], strict=True)]


@cache
def steps_of(features):
    """The step of the plant with some features in Python, on arrays, in CasADi and compiled: vehicles differ in numbers alone."""
    advance = close_loop(close_cascade(LAWS["pid"], LAWS["pid"]), NO_METERS, features).advance
    expression = symbolic.symbolic_function("advance", advance, (Body, Rotors, Disturbance, Dynamics, float))
    return advance, array.rebinder()(advance), expression, lanes.compiled(advance)


@pytest.mark.parametrize(("name", "linear"), [*[(name, 0.0) for name in names()], ("f450", 0.4), ("f450", -0.4)])
def test_plant_step(name, linear):
    draw = np.random.default_rng(1)
    vehicle = airframe(name)._replace(thrust_linear=linear)
    f = dynamics(vehicle)
    advance, on_arrays, expression, native = steps_of(vehicle_features(vehicle, H))
    bodies = [random_body(draw, vehicle) for _ in range(SAMPLES)]
    commands = [Rotors(*(flatten(body.rotor_speed)[0] * draw.uniform(0.5, 1.5, 4)).tolist()) for body in bodies]
    airs = [pack(Disturbance, draw.normal(size=12).tolist()) for _ in bodies]
    plain = [advance(*case, f, 1e-3) for case in zip(bodies, commands, airs, strict=True)]
    wanted = np.array([flatten(body) for body in plain])
    scale = np.maximum(np.abs(wanted), 10.0)

    result = on_arrays(
        pack(Body, columns(bodies)), pack(Rotors, columns(commands)), pack(Disturbance, columns(airs)), f, 1e-3
    )
    close(np.stack(flatten(result), axis=1) / scale, wanted / scale, 1.0)

    for body, command, air, row, size_of in zip(bodies, commands, airs, wanted, scale, strict=True):
        symbols = expression(flatten(body), flatten(command), flatten(air), flatten(f), 1e-3)
        close(np.array(symbols).ravel() / size_of, row / size_of, 1.0)
        close(np.array(flatten(native(body, command, air, f, 1e-3))) / size_of, row / size_of, 1.0)


@pytest.mark.parametrize("name", LAWS)
def test_laws(name):
    assert list(backends_agree(LAWS[name])) == []


def cascade_case(cascade, vehicle, draw):
    gains = pack(cascade.Gains, [draw.uniform(0.5, 2.0) for _ in range(size(cascade.Gains))])
    constants = cascade.prepare(gains, H)
    direction = np.array([*draw.uniform(-0.3, 0.3, 2), 1.0])
    direction /= np.linalg.norm(direction, axis=0)
    turn = draw.uniform(-3.0, 3.0)
    m = pack(
        Measurement,
        [
            *draw.normal(size=6),
            *draw.uniform(-0.4, 0.4, 2),
            turn,
            *draw.normal(size=3),
            *direction,
            np.cos(turn),
            np.sin(turn),
            0.0,
        ],
    )
    reference = pack(
        Reference, [*draw.normal(size=9), *draw.uniform(-0.3, 0.3, 2), draw.normal(), 0.1, draw.integers(2)]
    )
    hover = vehicle.mass * vehicle.gravity / 4
    memory = pack(cascade.Memory, (hover * draw.uniform(0.5, 1.5, size(cascade.Memory))).tolist())
    in_force = Rotors(*(hover * draw.uniform(0.5, 1.5, 4)).tolist())
    return memory, constants, reference, m, in_force


@cache
def both_of(pair):
    """The step of a cascade in CasADi and on arrays; it knows no airframe."""
    cascade = close_cascade(LAWS[pair[0]], LAWS[pair[1]])
    kinds = (cascade.Memory, cascade.Constants, Nominal, Reference, Measurement, Rotors, float)
    return symbolic.symbolic_function("step", cascade.step, kinds), array.rebinder()(cascade.step)


PAIRS = [(name, name) for name in LAWS] + [("ladrc", "hybrid"), ("pid", "ladrc"), ("adrc", "hybrid_gsta")]
# Compiled as a whole, for 4 s: the step of every law is compiled above, and kernels of other pairs are flown beside Python.
COMPILED = (("adrc", "hybrid_gsta"),)


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
@pytest.mark.parametrize("frame", ["hummingbird", "iris", "crazyflie-pybullet", "paper-literal"])
def test_cascade(pair, frame):
    cascade = close_cascade(LAWS[pair[0]], LAWS[pair[1]])
    vehicle = airframe(frame)
    knowledge = nominal(vehicle, ControlOptions(), H)
    draw = np.random.default_rng(3)
    expression, on_arrays = both_of(pair)
    native = lanes.compiled(cascade.step) if frame == "hummingbird" and pair in COMPILED else None
    for _ in range(SAMPLES):
        memory, constants, reference, m, in_force = cascade_case(cascade, vehicle, draw)
        arguments = (memory, constants, knowledge, reference, m, in_force, H)
        wanted = np.array(flatten(cascade.step(*arguments)))
        scale = np.maximum(np.abs(wanted), 10.0)
        symbols = expression(*[flatten(part) if isinstance(part, tuple) else part for part in arguments])
        close(np.array(symbols).ravel() / scale, wanted / scale, 1.0)
        close(np.array([float(leaf) for leaf in flatten(on_arrays(*arguments))]) / scale, wanted / scale, 1.0)
        if native is not None:
            close(np.array(flatten(native(*arguments))) / scale, wanted / scale, 1.0)
