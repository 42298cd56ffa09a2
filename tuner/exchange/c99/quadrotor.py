"""Flight controllers of quadrotors as tables of entry points."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from plant.backends import vector_math
from plant.backends.c_code import DOUBLE, Real, literal
from plant.backends.rebind import Rebinder
from plant.backends.tracing import Constant, Graph, rebinder
from plant.backends.tracing_routines import Routine
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES, POSITION_AXES
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.integrator import runge_kutta_step
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.rigid_body import Body, dynamics
from plant.quadrotor.sensors import Measurement
from plant.records import flatten, pack, size
from plant.references.track import Reference
from plant.seeds import generator
from plant.vectors import Quaternion, Rotors, Vec3
from tuner.exchange.c99 import precision
from tuner.exchange.c99.entries import (
    AttitudeApplied,
    AttitudeMeasurement,
    AttitudeSetpoint,
    Command,
    commanded,
    constants_of,
    entries,
    measurement_of,
    nominal_of,
)
from tuner.exchange.c99.golden import FAR_OFF, NEXT_TO, OFTEN
from tuner.exchange.c99.precision import as_signals, matrix, signals
from tuner.exchange.c99.routines import Style
from tuner.exchange.c99.sources import Code, Entry, Instant, Program, digest_of, gain_texts, write_code
from tuner.exchange.c99.tracing import Results, named
from tuner.exchange.texts import c_comment, c_string
from tuner.gains import Controller

ATTITUDES = 48
MEASURED = (Vec3, Vec3, Quaternion, Vec3)
# Yaw of the start [rad], so that it passes half a turn; torque limit of the attitude flight as an angular acceleration [rad/s2].
YAW, MAX_ACCELERATION = 3.05, 40.0
# RMS of the noise in the measurement's own units; how far off what is asked for instants next to it are, in shares of the noise:
# within h^2 k2 of the sliding surface.
NOISE = 0.01
NEAR_GOAL, NEAR_ANGLE = 1e-4, 1e-2
# |q|^2 of a measured attitude may be off 1 by this much; beyond it is no attitude.
UNIT_WITHIN = 0.01
# Records that the header declares by itself.
DECLARED = {
    Vec3: "vec3",
    Reference: "reference",
    Measurement: "measurement",
    Command: "command",
    Quaternion: "quaternion",
    AttitudeSetpoint: "attitude_setpoint",
    AttitudeMeasurement: "attitude_measurement",
    AttitudeApplied: "attitude_applied",
}


def c_sources(controller: Controller, real: str = "float", prefix: str = "gainproof", digest: str = "") -> Code:
    """Write the controller in C99.

    Args:
        controller: The controller with its gains.
        real: "float" or "double", the type of all numbers.
        prefix: Prefix of all names, a C identifier in lower case; the files are PREFIX_controller.h and .c.
        digest: Digest of the gains.json that the gains come from, `digest_of` where there is none.
    """
    return write_code(quadrotor_program(controller), real, prefix, digest or digest_of(controller.gains))


def quadrotor_program(controller: Controller) -> Program:
    """Return the table of the controller, traced."""
    cascade, airframe = controller.cascade, controller.airframe
    bound = entries(cascade)
    outer = Routine("position_loop", cascade.position.step, cascade.position.Memory, watched=True)
    inner = Routine("attitude_loop", cascade.attitude.step, cascade.attitude.Memory, watched=True)
    angle = Routine("atan2", vector_math.atan2)
    constants, knowledge = named("constants", constants_of(controller)), named("", nominal_of(controller))
    h = Constant(controller.control_period, "h")

    def run(graph: Graph, function: Callable[..., Any], axes: tuple[str, ...], *arguments: Any) -> Any:
        return _bind(graph, controller, axes, outer, inner, angle)(function)(*arguments)

    def init(graph: Graph, m: Any) -> Results:
        after = run(graph, bound.init, (), constants, knowledge, m)
        return ("next.", after), ("next.command.", commanded(after.in_force, knowledge))

    def step(graph: Graph, state: Any, reference: Any, m: Any) -> Results:
        command, after = run(graph, bound.step, AXES, state, constants, knowledge, reference, m, h)
        return ("next.command.", command), ("next.", after)

    def attitude_init(graph: Graph, m: Any) -> Results:
        after = run(graph, bound.attitude_init, (), constants, m)
        return ("next.", after), ("next.torque.", Vec3(0.0, 0.0, 0.0))

    def attitude_step(graph: Graph, state: Any, setpoint: Any, m: Any, applied: Any) -> Results:
        given = setpoint, m, applied
        torque, after = run(graph, bound.attitude_step, ATTITUDE_AXES, state, constants, knowledge, *given, h)
        return ("next.torque.", torque), ("next.", after)

    def measure(graph: Graph, position: Any, velocity: Any, attitude: Any, rate: Any) -> Results:
        return (("next.", run(graph, measurement_of, (), position, velocity, attitude, rate)),)

    seen, angles = {"m": Measurement}, {"m": AttitudeMeasurement}
    cascaded, inside = {"state": bound.State, "memory": "control."}, {"state": bound.AttitudeState}
    command, torque = ("command", Command), ("torque", Vec3)
    return Program(
        airframe.title,
        controller.control_period,
        (
            Entry("init", init, seen, **cascaded),
            Entry(
                "step",
                step,
                {"reference": Reference, **seen},
                command,
                **cascaded,
                flight=partial(cascade_flight, controller),
            ),
            Entry("attitude_init", attitude_init, angles, **inside),
            Entry(
                "attitude_step",
                attitude_step,
                {"setpoint": AttitudeSetpoint, **angles, "applied": AttitudeApplied},
                torque,
                **inside,
                flight=partial(attitude_flight, controller),
            ),
            Entry(
                "measure",
                measure,
                {"position": Vec3, "velocity": Vec3, "attitude": Quaternion, "rate": Vec3},
                ("m", Measurement),
                guard=_check_length,
                flight=measurements,
            ),
        ),
        routines=(outer, inner),
        helpers=(angle,),
        gains=gain_texts(gain_addresses(cascade), controller.gains),
        declared=DECLARED | {bound.State: "state", bound.AttitudeState: "attitude_state"},
        types={"memory": cascade.Memory, "rotors": Rotors, "loop_memory": cascade.attitude.Memory},
        words={
            "airframe": c_comment(airframe.name),
            "airframe_text": c_string(airframe.name),
            "position": cascade.position.name,
            "attitude": cascade.attitude.name,
        },
        numbers={"mass": airframe.vehicle.mass},
    )


def _check_length(style: Style) -> list[str]:
    """Return the lines that refuse an attitude far from unit length."""
    p = style.prefix
    square = " + ".join(f"attitude->{part} * attitude->{part}" for part in Quaternion._fields)
    low, high = literal(1.0 - UNIT_WITHIN, style.real), literal(1.0 + UNIT_WITHIN, style.real)
    return [
        f"const {p}_real square = {square};",
        f"if (!(square > {low} && square < {high})) /* no attitude, or NaN */",
        f"    return {p.upper()}_REFUSED;",
    ]


def _bind(
    graph: Graph, controller: Controller, axes: tuple[str, ...], outer: Routine, inner: Routine, angle: Routine
) -> Rebinder:
    """Return a rebinder to a graph; loops are calls in the order of the axes, and the arc tangent is one."""
    order = iter(axes)

    def loop(*arguments: Any) -> Any:
        axis = next(order)
        return (outer if axis in POSITION_AXES else inner).call(axis, graph, *arguments)

    numbers: Iterator[int] = iter(range(1000))

    def atan2(y: Any, x: Any) -> Any:
        return angle.call(f"angle{next(numbers)}", graph, y, x)

    cascade = controller.cascade
    return rebinder({cascade.position.step: loop, cascade.attitude.step: loop, vector_math.atan2: atan2})


def cascade_flight(controller: Controller, real: Real, steps: int) -> Iterator[Instant]:
    """Yield the instants of the whole cascade in a steady wind."""
    bound = entries(controller.cascade)
    h, knowledge = controller.control_period, nominal_of(controller)
    constants, bind = constants_of(controller), precision.rebinder(real)
    init, step, sense = bind(bound.init), bind(bound.step), precision.rebinder(DOUBLE)(measurement_of)
    noise = _noise("step", steps, size(Measurement))
    body, state = _hovering(knowledge), None
    for k in range(steps):
        seen = sense(
            *(as_signals(part, DOUBLE, 1) for part in (body.position, body.velocity, body.attitude, body.rate))
        )
        exact = matrix(as_signals(seen, DOUBLE, 1))
        exact[:, 0] += noise[k]
        m = signals(Measurement, exact, real)
        if state is None:
            state = as_signals(init(constants, knowledge, m), real, 1)
            hover = commanded(Rotors(*[knowledge.hover] * 4), knowledge)
            yield (m,), (), (state, as_signals(hover, real, 1))
        wanted = _reference(k / steps)
        if k % OFTEN == NEXT_TO:
            wanted = _placed(wanted, exact[:6, 0] + NEAR_GOAL * noise[k, 6:12])
        reference = as_signals(wanted, real, 1)
        command, state = (as_signals(part, real, 1) for part in step(state, constants, knowledge, reference, m, h))
        yield (reference, m), (command,), (state,)
        body = _flown(controller, body, [float(leaf[0]) for leaf in command.rotor_thrust])


def attitude_flight(controller: Controller, real: Real, steps: int) -> Iterator[Instant]:
    """Yield the instants of the attitude loops on three inertias."""
    bound = entries(controller.cascade)
    h, knowledge = controller.control_period, nominal_of(controller)
    inertia = np.array(knowledge.vehicle.inertia)
    constants, bind = constants_of(controller), precision.rebinder(real)
    init, step = bind(bound.attitude_init), bind(bound.attitude_step)
    noise = _noise("attitude_step", steps, 6)
    angles, rate = np.array([0.1, -0.1, YAW]), np.zeros(3)
    effect, excess = np.zeros(3), np.zeros(3)
    state = None
    for k in range(steps):
        goal = _setpoint(k / steps)
        seen = np.concatenate([angles, rate]) + noise[k]
        if k % OFTEN == NEXT_TO:
            seen = np.array([*goal[:3], 0.0, 0.0, goal.yaw_rate]) + NEAR_ANGLE * noise[k]
        m = signals(AttitudeMeasurement, seen[:, None], real)
        if state is None:
            state = as_signals(init(constants, m), real, 1)
            yield (m,), (), (state, as_signals(Vec3(0.0, 0.0, 0.0), real, 1))
        setpoint = as_signals(goal, real, 1)
        applied = signals(AttitudeApplied, np.concatenate([effect, excess])[:, None], real)
        torque, state = (
            as_signals(part, real, 1) for part in step(state, constants, knowledge, setpoint, m, applied, h)
        )
        yield (setpoint, m, applied), (torque,), (state,)
        demand = matrix(torque)[:, 0].astype(float)
        effect = np.clip(demand, -MAX_ACCELERATION * inertia, MAX_ACCELERATION * inertia)
        excess = effect - demand
        rate = rate + h * (effect / inertia + 0.5)
        angles = angles + h * rate


def measurements(real: Real, _: int) -> Iterator[Instant]:
    """Yield measurements of vehicles in all attitudes."""
    rows = generator(0, "export/golden/measure", 0).standard_normal((13, ATTITUDES))
    rows[6:10] /= np.sqrt((rows[6:10] ** 2).sum(axis=0))
    given = [signals(kind, part, real) for kind, part in zip(MEASURED, np.split(rows, (3, 6, 10)), strict=True)]
    measured = as_signals(precision.rebinder(real)(measurement_of)(*given), real, ATTITUDES)
    yield (), (), ()
    for i in range(ATTITUDES):
        taken = tuple(pack(type(part), [leaf[i : i + 1] for leaf in flatten(part)]) for part in (*given, measured))
        yield taken[:-1], taken[-1:], ()


def _noise(name: str, steps: int, width: int) -> np.ndarray:
    noise = NOISE * generator(0, f"export/golden/{name}", 0).standard_normal((steps, width))
    noise[OFTEN - 1 :: OFTEN] *= FAR_OFF
    return noise


def _reference(share: float) -> Reference:
    """Reference at a share of the flight: a step aside with a turn, a leap, then angles."""
    goal, push = Vec3(0.25, -0.15, 0.1), Vec3(0.3, -0.2, 0.1)
    if 0.3 < share < 0.4:
        goal = Vec3(4.0, -3.0, 5.0)
    if 0.5 < share < 0.55:
        goal = Vec3(-2.0, 3.0, -6.0)
    hold = 1.0 if share < 0.7 else 0.0
    return Reference(goal, Vec3(0.05, -0.1, 0.02), push, 0.08, -0.06, -3.0 if share > 0.1 else YAW, 0.1, hold)


def _placed(reference: Reference, place: np.ndarray) -> Reference:
    """The reference, but for its position and velocity."""
    return reference._replace(position=Vec3(*place[:3].tolist()), velocity=Vec3(*place[3:].tolist()))


def _flown(controller: Controller, body: Body, thrust: list[float]) -> Body:
    """Return the body one period later in a steady wind; thrust: of the rotors [N], commanded over it."""
    vehicle = controller.airframe.vehicle
    speed = Rotors(*[float(np.sqrt(value / vehicle.thrust_coefficient)) for value in thrust])
    disturbance = pack(Disturbance, [0.3] * size(Disturbance))
    for _ in range(round(controller.control_period / controller.plant_step)):
        body = runge_kutta_step(body, speed, disturbance, dynamics(vehicle), controller.plant_step)
    return body


def _hovering(knowledge: Nominal) -> Body:
    """At rest at the origin, turned by YAW."""
    speed = float(np.sqrt(knowledge.hover / knowledge.vehicle.thrust_coefficient))
    half = 0.5 * YAW
    still = Vec3(0.0, 0.0, 0.0)
    # Cosine of half of YAW to the digits that make a unit quaternion with its sine.
    c = 1.0 - half * half / 2.0 + half**4 / 24.0 - half**6 / 720.0 + half**8 / 40320.0 - half**10 / 3628800.0
    s = float(np.sqrt(1.0 - c * c))
    return Body(still, still, Quaternion(c, 0.0, 0.0, s), still, Rotors(speed, speed, speed, speed))


def _setpoint(share: float) -> AttitudeSetpoint:
    """Reference of the angles at a share of the flight."""
    return AttitudeSetpoint(0.3 if share < 0.5 else -0.2, -0.2 if share < 0.3 else 0.1, -3.0, 0.2)
