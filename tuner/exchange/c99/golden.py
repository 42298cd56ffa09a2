"""Golden vectors: what the controller takes, gives and keeps over two short flights, as the model functions work it out.

The flights are closed loops, so that the controller mostly works between its limits, where most constants show; leaps of the
reference and every eighth measurement, which is far off, take it to them. Another eighth of the instants lies next to what is
asked for, where sliding mode laws are linear. Vectors of the measurement's own function go with them.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plant.backends.c_code import DOUBLE, Real, literal
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.integrator import runge_kutta_step
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.rigid_body import Body, dynamics
from plant.quadrotor.sensors import Measurement
from plant.records import pack, size
from plant.references.track import Reference
from plant.seeds import generator
from plant.vectors import Quaternion, Rotors, Vec3
from tuner.exchange.c99.entries import (
    AttitudeApplied,
    AttitudeMeasurement,
    AttitudeSetpoint,
    Entries,
    commanded,
    entries,
    measurement_of,
)
from tuner.exchange.c99.precision import as_signals, matrix, rebinder, signals
from tuner.exchange.c99.tracing import constants_of, nominal_of
from tuner.exchange.texts import filled
from tuner.gains import Controller

STEPS, ATTITUDES = 200, 48
MEASURED = (Vec3, Vec3, Quaternion, Vec3)
# Yaw of the start [rad], so that it passes half a turn; torque limit of the attitude flight as an angular acceleration [rad/s2].
YAW, MOST = 3.05, 40.0
# RMS of the noise in the measurement's own units, and how many times more it is where a measurement is far off; how far off
# what is asked for instants next to it are, in shares of the noise: within h^2 k2 of the sliding surface.
NOISE, FAR_OFF, OFTEN, NEXT_TO = 0.01, 150.0, 8, 3
NEAR_GOAL, NEAR_ANGLE = 1e-4, 1e-2


@dataclass(frozen=True)
class Vectors:
    """One entry point: rows of what it takes, gives and then keeps, in the order of the members, (steps, .).

    start: what its init takes; initial: the state after it, and the output that a refused step would then give.
    """

    start: np.ndarray
    initial: np.ndarray
    inputs: np.ndarray
    outputs: np.ndarray
    states: np.ndarray


@dataclass(frozen=True)
class Golden:
    """Both flights; positions, velocities, quaternions and rates (rows, 13), and the measurements they give (rows, 18)."""

    step: Vectors
    attitude_step: Vectors
    measure_inputs: np.ndarray
    measure_outputs: np.ndarray


def golden(controller: Controller, real: Real, steps: int = STEPS) -> Golden:
    """Fly and note."""
    bound = entries(controller.cascade)
    with np.errstate(all="ignore"):
        cascade, attitude = _cascade(controller, bound, real, steps), _attitude(controller, bound, real, steps)
        return Golden(cascade, attitude, *_measurements(real))


def _measurements(real: Real) -> tuple[np.ndarray, np.ndarray]:
    """Measurements of vehicles in all attitudes."""
    rows = generator(0, "export/golden/measure", 0).standard_normal((13, ATTITUDES))
    rows[6:10] /= np.sqrt((rows[6:10] ** 2).sum(axis=0))
    given = [signals(kind, part, real) for kind, part in zip(MEASURED, np.split(rows, (3, 6, 10)), strict=True)]
    measured = as_signals(rebinder(real)(measurement_of)(*given), real, ATTITUDES)
    return np.concatenate([matrix(part) for part in given]).T, matrix(measured).T


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


def _cascade(controller: Controller, bound: Entries, real: Real, steps: int) -> Vectors:
    h, knowledge = controller.control_period, nominal_of(controller)
    constants, bind = constants_of(controller), rebinder(real)
    init, step, sense = bind(bound.init), bind(bound.step), rebinder(DOUBLE)(measurement_of)
    noise = _noise("step", steps, size(Measurement))
    body, state, log = _hovering(knowledge), None, Log()
    for k in range(steps):
        seen = sense(
            *(as_signals(part, DOUBLE, 1) for part in (body.position, body.velocity, body.attitude, body.rate))
        )
        exact = matrix(as_signals(seen, DOUBLE, 1))
        exact[:, 0] += noise[k]
        m = signals(Measurement, exact, real)
        if state is None:
            state = as_signals(init(constants, knowledge, m), real, 1)
            log.begin((m,), (state, as_signals(commanded(_hover(knowledge), knowledge), real, 1)))
        wanted = _reference(k / steps)
        if k % OFTEN == NEXT_TO:
            wanted = _placed(wanted, exact[:6, 0] + NEAR_GOAL * noise[k, 6:12])
        reference = as_signals(wanted, real, 1)
        command, state = (as_signals(part, real, 1) for part in step(state, constants, knowledge, reference, m, h))
        if not log.note((reference, m), command, state):
            break
        body = _flown(controller, body, [float(leaf[0]) for leaf in command.rotor_thrust])
    return log.vectors()


def _flown(controller: Controller, body: Body, thrust: list[float]) -> Body:
    """The body one period later, with the rotor thrusts [N] commanded over it, in a steady wind."""
    vehicle = controller.airframe.vehicle
    speed = Rotors(*[float(np.sqrt(value / vehicle.thrust_coefficient)) for value in thrust])
    disturbance = pack(Disturbance, [0.3] * size(Disturbance))
    for _ in range(round(controller.control_period / controller.plant_step)):
        body = runge_kutta_step(body, speed, disturbance, dynamics(vehicle), controller.plant_step)
    return body


class Log:
    """Rows of a flight; one that becomes infinite or NaN, which the exported C refuses, ends it."""

    def __init__(self) -> None:
        self._start = self._initial = np.zeros(0)
        self._rows: list[tuple[np.ndarray, ...]] = []

    def begin(self, taken: tuple[Any, ...], memory: tuple[Any, ...]) -> None:
        """Note what init takes, and the state after it."""
        self._start, self._initial = (
            np.concatenate([matrix(part)[:, 0] for part in group]) for group in (taken, memory)
        )

    def note(self, taken: tuple[Any, ...], given: Any, state: Any) -> bool:
        """Note a step; False where it is not finite, and then the flight is over."""
        groups = (taken, (given,), (state,))
        row = tuple(np.concatenate([matrix(part)[:, 0] for part in group]) for group in groups)
        finite = all(np.isfinite(part).all() for part in row)
        if finite:
            self._rows.append(row)
        return finite

    def vectors(self) -> Vectors:
        """Return the rows."""
        inputs, outputs, states = (np.array(column) for column in zip(*self._rows, strict=True))
        return Vectors(self._start, self._initial, inputs, outputs, states)


def _hover(knowledge: Nominal) -> Rotors:
    return Rotors(knowledge.hover, knowledge.hover, knowledge.hover, knowledge.hover)


def _hovering(knowledge: Nominal) -> Body:
    """At rest at the origin, turned by YAW."""
    speed = float(np.sqrt(knowledge.hover / knowledge.vehicle.thrust_coefficient))
    half = 0.5 * YAW
    still = Vec3(0.0, 0.0, 0.0)
    # Cosine of half of YAW to the digits that make a unit quaternion with its sine.
    c = 1.0 - half * half / 2.0 + half**4 / 24.0 - half**6 / 720.0 + half**8 / 40320.0 - half**10 / 3628800.0
    s = float(np.sqrt(1.0 - c * c))
    return Body(still, still, Quaternion(c, 0.0, 0.0, s), still, Rotors(speed, speed, speed, speed))


def _attitude(controller: Controller, bound: Entries, real: Real, steps: int) -> Vectors:
    h, knowledge = controller.control_period, nominal_of(controller)
    inertia = np.array(knowledge.vehicle.inertia)
    constants, bind = constants_of(controller), rebinder(real)
    init, step = bind(bound.attitude_init), bind(bound.attitude_step)
    noise = _noise("attitude_step", steps, 6)
    angles, rate = np.array([0.1, -0.1, YAW]), np.zeros(3)
    effect, excess = np.zeros(3), np.zeros(3)
    state, log = None, Log()
    for k in range(steps):
        goal = _setpoint(k / steps)
        seen = np.concatenate([angles, rate]) + noise[k]
        if k % OFTEN == NEXT_TO:
            seen = np.array([*goal[:3], 0.0, 0.0, goal.yaw_rate]) + NEAR_ANGLE * noise[k]
        m = signals(AttitudeMeasurement, seen[:, None], real)
        if state is None:
            state = as_signals(init(constants, m), real, 1)
            log.begin((m,), (state, as_signals(Vec3(0.0, 0.0, 0.0), real, 1)))
        setpoint = as_signals(goal, real, 1)
        applied = signals(AttitudeApplied, np.concatenate([effect, excess])[:, None], real)
        torque, state = (
            as_signals(part, real, 1) for part in step(state, constants, knowledge, setpoint, m, applied, h)
        )
        if not log.note((setpoint, m, applied), torque, state):
            break
        demand = matrix(torque)[:, 0].astype(float)
        effect = np.clip(demand, -MOST * inertia, MOST * inertia)
        excess = effect - demand
        rate = rate + h * (effect / inertia + 0.5)
        angles = angles + h * rate
    return log.vectors()


def _setpoint(share: float) -> AttitudeSetpoint:
    """Reference of the angles at a share of the flight."""
    return AttitudeSetpoint(0.3 if share < 0.5 else -0.2, -0.2 if share < 0.3 else 0.1, -3.0, 0.2)


def golden_header(vectors: Golden, real: Real, prefix: str, words: dict[str, str]) -> str:
    """Write golden.h; prefix: of all names; words: p, P, digest, airframe, laws."""
    texts = [
        entry_vectors(name, entry, real, prefix)
        for name, entry in (("", vectors.step), ("attitude_", vectors.attitude_step))
    ]
    defines, arrays = ([line for text in texts for line in text[i]] for i in (0, 1))
    defines.append(f"#define GOLDEN_MEASUREMENTS {len(vectors.measure_inputs)}u")
    arrays.append(_array("golden_measure_inputs", vectors.measure_inputs, real, prefix))
    arrays.append(_array("golden_measure_outputs", vectors.measure_outputs, real, prefix))
    what = f"airframe      {words['airframe']}, laws {words['laws']}"
    return header_text(defines, arrays, real, {**words, "what": what})


def header_text(defines: list[str], arrays: list[str], real: Real, words: dict[str, str]) -> str:
    """Write golden.h around its arrays; words: p, P, digest, tool, and in `what` what the gains are of."""
    return filled("c99", "golden.h", **words, real=real.name, defines="\n".join(defines), arrays="\n\n".join(arrays))


def entry_vectors(name: str, entry: Vectors, real: Real, prefix: str) -> tuple[list[str], list[str]]:
    """Write sizes and arrays of the vectors of one entry point; name: "" or a word with _ behind it."""
    start, initial = f"golden_{name}start[{len(entry.start)}]", f"golden_{name}initial[{len(entry.initial)}]"
    defines = [
        f"#define GOLDEN_{name.upper()}STEPS {len(entry.inputs)}u",
        f"#define GOLDEN_{name.upper()}INITIAL {len(entry.initial)}u",
    ]
    arrays = [
        f"static const {prefix}_real {start} = {{{_row(entry.start, real)}}};",
        f"static const {prefix}_real {initial} = {{{_row(entry.initial, real)}}};",
        _array(f"golden_{name}inputs", entry.inputs, real, prefix),
    ]
    for kind, table in (("outputs", entry.outputs), ("states", entry.states)):
        defines.append(f"#define GOLDEN_{name.upper()}{kind.upper()} {table.shape[1]}u")
        arrays.append(_array(f"golden_{name}{kind}", table, real, prefix))
    return defines, arrays


def differs(real: Real, words: dict[str, str]) -> str:
    """Write the function that compares numbers bit for bit."""
    return filled("c99", "differs.c", **words, digits=17 if real.name == "double" else 9).rstrip()


def _array(name: str, table: np.ndarray, real: Real, prefix: str) -> str:
    rows = ",\n".join(f"    {{{_row(row, real)}}}" for row in table)
    return f"static const {prefix}_real {name}[{len(table)}][{table.shape[1]}] = {{\n{rows}\n}};"


def _row(values: np.ndarray, real: Real) -> str:
    # Numbers as they are: what is too small to be normal stays so.
    return ", ".join(literal(float(value), real, raised=False).strip("()") for value in values)
