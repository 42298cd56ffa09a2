"""Studies drawn at random, quadrotors and plants, as loops that are flown and the margins that are reported of them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from objectives.margins.describing import Case
from objectives.margins.loop_margins import gains_of_terms
from objectives.margins.margins import MarginModel
from objectives.margins.period import NO_METERS, NoMeters, PeriodMap, period_map, state_type, terms_of
from objectives.margins.plant_margins import PlantMargins
from objectives.margins.plant_period import PlantPeriod
from objectives.margins.results import Margins
from objectives.margins.trim import Trim, setting_of, smooth_dynamics
from objectives.plant_system import PlantSystem
from plant.backends import array
from plant.backends.rebind import Rebinder
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.closing import resting, to_plant
from plant.model.controller import to_channel
from plant.quadrotor.airframes import load
from plant.quadrotor.allocation import speed_commands
from plant.quadrotor.cascade import Cascade, close_cascade, commanded_torque, tilt_for
from plant.quadrotor.closed_loop import Limits, close_loop
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.features import VehicleFeatures, vehicle_features
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions, Nominal, nominal
from plant.quadrotor.sample import Targets
from plant.quadrotor.sensors import Noise
from plant.quadrotor.trim import trim_of
from plant.records import flatten, pack, paths, size, zeros
from plant.references.track import Reference
from plant.vectors import Rotors, Vec3, axpy_rotors
from tests.objectives.margins import random_plants
from tests.objectives.margins.flown_loops import FlownLoop, linearized
from tests.objectives.margins.test_random_plants import study_of

Array = np.ndarray
AIRFRAMES = ("hummingbird", "f450", "racer5", "iris")
POSITION = ("pid", "ladrc", "px4_position", "hybrid")
ATTITUDE = ("pid", "ladrc", "px4", "ardupilot", "betaflight", "hybrid")
PERIODS = {"betaflight": (2.5e-4, 1e-3), "ladrc": (1e-3, 4e-3)}
OTHER_PERIODS = (1e-3, 2.5e-3)
CASE = Case(0.2)
# Gains rows of a drawn cascade, the first stable one of which is taken.
N_TRIED = 12
ZERO = Vec3(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Drawn:
    """A loop drawn at random with what is reported of it.

    Attributes:
        name: Description for messages.
        loop: The loop that is flown.
        margins: Margins of one gains row.
        period: Control period [s].
    """

    name: str
    loop: FlownLoop
    margins: Margins
    period: float


def drawn_quadrotor(number: int) -> Drawn:
    """Return quadrotor `number`, its position loops at every to every 16th period, with stable loops."""
    rng = np.random.default_rng([2031, number])
    while True:
        found = _quadrotor(rng, number)
        if found is not None:
            return found


def _quadrotor(rng: np.random.Generator, number: int) -> Drawn | None:
    position, attitude = str(rng.choice(POSITION)), str(rng.choice(ATTITUDE))
    h = float(np.exp(rng.uniform(*np.log(PERIODS.get(attitude, OTHER_PERIODS)))))
    every, frame = 1 + number % 16, str(rng.choice(AIRFRAMES))
    options = ControlOptions(
        delay=bool(rng.integers(2)),
        attitude_rate=str(rng.choice(["measured", "observer"])) if attitude == "ladrc" else "measured",
        yaw_torque_cutoff=float(rng.choice([0.0, rng.uniform(0.25, 5.0)])),
        rpm_notches=int(rng.integers(3)),
        rpm_notch_q=float(rng.uniform(2.0, 8.0)),
    )
    vehicle = load(frame).vehicle._replace(
        dead_time=float(rng.choice([0.0, rng.uniform(0.0, 0.004)])),
        gyro_cutoff=float(rng.choice([0.0, rng.uniform(60.0, 200.0)])),
        thrust_linear=float(rng.choice([0.0, rng.uniform(0.1, 0.6)])),
    )
    trim = Trim(wind=Vec3(float(rng.uniform(0.0, 4.0)), 0.0, 0.0)) if rng.integers(2) else Trim()
    cascade, timing = close_cascade(LAWS[position], LAWS[attitude], every), Timing(h, h)
    default = np.array(default_row(cascade, vehicle))
    rows = default * np.exp(rng.uniform(-0.4, 0.4, (N_TRIED, len(default))))
    name = f"{number}: {frame}, {position} every {every} over {attitude} at {1.0 / h:.0f} Hz, {options}, {trim}"
    try:
        knowledge = nominal(vehicle, options, h)
        model = MarginModel(cascade, knowledge, timing, vehicle, trim, cases=(CASE,))
        all_margins = model.evaluate(rows)
    except InputError:
        return None
    is_stable = all_margins.stable.all(axis=1)
    if not is_stable.any():
        return None
    first = int(np.flatnonzero(is_stable)[0])
    row, margins = rows[first], all_margins.of(first)
    features = vehicle_features(vehicle, h, knowledge.harmonics, knowledge.vehicle).feedback
    straight = gains_of_terms(period_map(cascade.at_one_rate, timing, features), row[None], (CASE,))[0, 0]
    step = _Quadrotor(cascade, knowledge, timing, features, trim, row, straight)
    setting, balance = setting_of(trim, knowledge, vehicle), trim_of(vehicle, trim.air, trim.yaw)
    flown = PeriodMap(cascade, timing, features)
    (found,) = flown.at_rest(balance.body[0], row[None], setting.nominal, setting.reference, setting.dynamics)
    state = found[0]
    for k in range(6 * every):
        state = step(state[:, None], k, np.zeros((6, 1)))[0][:, 0]
    quaternion = paths(step.state).index("body.attitude.w")
    return Drawn(name, linearized(step, state, every, 6, quaternion), margins, h)


class _Quadrotor:
    """Control periods of a cascade in a trim, signals added where margins break the loops; nonlinear terms are straight lines."""

    def __init__(
        self,
        cascade: Cascade,
        knowledge: Nominal,
        timing: Timing,
        features: VehicleFeatures,
        trim: Trim,
        row: Array,
        straight: Array,
    ) -> None:
        self._cascade, self._known, self._timing, self._trim, self._row = cascade, knowledge, timing, trim, row
        self._loop, self._straight, self._terms = close_loop(cascade, NO_METERS, features), straight, terms_of(cascade)
        self._dynamics = smooth_dynamics(knowledge.vehicle)
        self.state = state_type(cascade, features)

    def __call__(self, states: Array, _period: int, v: Array) -> tuple[Array, Array]:
        """Return the states (n, lanes) a control period later, and commands (6, lanes)."""
        before, h, known = pack(self.state, list(states)), self._timing.control_period, self._known
        plain = Rebinder(array.NAMES)
        constants = plain(self._cascade.prepare)(pack(self._cascade.Gains, self._row.tolist()), h)
        idle = {"speed": before.in_force, "meters": NoMeters(), "status": 0.0, "end_time": 0.0}
        flight = self._loop.Flight(**{part: getattr(before, part) for part in self.state._fields}, **idle)
        air = Disturbance(self._trim.air, ZERO, ZERO, ZERO)
        goal = Reference(ZERO, ZERO, ZERO, 0.0, 0.0, self._trim.yaw, 0.0, 1.0)
        after = Rebinder(array.NAMES, stand_ins=self._stand_ins(v, constants))(self._loop.decide)(
            flight, constants, known, goal, zeros(Noise), zeros(Targets), Limits(1e9, -1.0), 0.0, h
        )
        body = after.body
        for _ in range(self._timing.steps):
            body = plain(self._loop.advance)(body, after.speed, air, self._dynamics, self._timing.plant_step)
        demand, lift = after.control.acceleration, sum(after.in_force) / known.vehicle.mass
        torque = plain(commanded_torque)(after.in_force, known.vehicle)
        following = self.state(body, *[getattr(after, part) for part in self.state._fields[1:]])
        return _rows(flatten(following), states), _rows([demand.x, demand.y, lift, *torque], states)

    def _stand_ins(self, v: Array, constants: Any) -> dict[Any, Any]:
        plain, mass = Rebinder(array.NAMES), self._known.vehicle.mass

        def tilt(acceleration: Vec3, heading: Vec3, gravity: float) -> Any:
            x, y = acceleration.x + v[0], acceleration.y + v[1]
            return plain(tilt_for)(acceleration._replace(x=x, y=y), heading, gravity)

        def speeds(thrust: Rotors, known: Nominal) -> Any:
            for amount, column in zip((mass * v[2], *v[3:]), known.allocation, strict=True):
                thrust = axpy_rotors(thrust, amount, column)
            return plain(speed_commands)(thrust, known)

        def line(nonlinearity: Any) -> Any:
            def straight(s: Any, own: Any) -> Any:
                axis = next(axis for axis in constants._fields if getattr(constants, axis) is own)
                names = [(term.axis, term.nonlinearity) for term in self._terms]
                return self._straight[names.index((axis, nonlinearity))] * s

            return straight

        lines = {term.nonlinearity.function: line(term.nonlinearity) for term in self._terms}
        return {tilt_for: tilt, speed_commands: speeds, **lines}


def _rows(values: Any, like: Array) -> Array:
    return np.array([np.broadcast_to(value, like.shape[1:]) for value in values])


def drawn_plant(number: int) -> Drawn:
    """Return plant `number` of `random_plants`: one channel, a slow one, or a slow one over a fast one."""
    draw = random_plants.drawn(number)
    system, row = study_of(draw).system, np.array(draw.gains)
    margins = PlantMargins(system, row, row).as_flown().evaluate(row[None])
    step, names = _Plant(system, row), system.plan.names
    flight = step.start()
    return Drawn(f"plant {number}: {draw}", linearized(step, flight, draw.every, len(names)), margins, draw.h)


class _Plant:
    """Control periods of a plant at rest, signals added where margins break the loops."""

    def __init__(self, system: PlantSystem, row: Array) -> None:
        self._system, self._row, period = system, row, PlantPeriod(system)
        self._loop, self._kinds, self.state = period.loop, period.loop.records, period.state
        self._dynamics, self._body = resting(self._loop, system.parameters)
        shown = self._body.shown
        goals = {each.name: getattr(shown, each.output) for each in system.plan.channels}
        still = zeros(self._kinds.Reference)
        self._goal = still._replace(**{name: getattr(still, name)._replace(value=at) for name, at in goals.items()})

    def start(self) -> Array:
        """Return the state (n,) at rest."""
        kinds, known = self._kinds, self._system.nominal
        constants = self._loop.prepare(pack(kinds.Gains, self._row.tolist()), self._system.timing.control_period)
        still = [zeros(kind) for kind in (kinds.Noise, kinds.Targets, kinds.Dynamics)]
        flight = self._loop.start(self._body, constants, known, self._goal, *still)
        return np.array(flatten(self.state(*[getattr(flight, part) for part in self.state._fields])), dtype=float)

    def __call__(self, states: Array, _period: int, v: Array) -> tuple[Array, Array]:
        """Return the states (n, lanes) a control period later, and commands (channels, lanes)."""
        kinds, (h, plant_step) = self._kinds, self._system.timing
        seen: dict[int, Array] = {}

        def added(command: Any, channel: int) -> Any:
            seen[int(channel)] = command
            return command + v[int(channel)]

        stand_ins = {to_plant: added, to_channel: added}
        bound, plain = Rebinder(array.NAMES, stand_ins=stand_ins), Rebinder(array.NAMES)
        constants = plain(self._loop.prepare)(pack(kinds.Gains, self._row.tolist()), h)
        before = pack(self.state, list(states))
        idle = {"speed": before.control.command, "meters": NoMeters(), "status": 0.0, "end_time": 0.0}
        flight = self._loop.Flight(**{part: getattr(before, part) for part in self.state._fields}, **idle)
        limits = pack(kinds.Limits, [1e9] * size(kinds.Limits))
        noise, targets = zeros(kinds.Noise), zeros(kinds.Targets)
        after = bound(self._loop.decide)(
            flight, constants, self._system.nominal, self._goal, noise, targets, limits, 0.0, h
        )
        body = after.body
        for _ in range(self._system.timing.steps):
            body = plain(self._loop.advance)(body, after.speed, zeros(kinds.Disturbance), self._dynamics, plant_step)
        following = self.state(body, *[getattr(after, part) for part in self.state._fields[1:]])
        return _rows(flatten(following), states), _rows([seen[i] for i in range(len(v))], states)
