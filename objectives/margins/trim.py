"""Steady flight: the fixed point of the one-period map about which the loop is linearized, found by Newton's method.

Flying at a constant velocity through a steady wind is, seen from a frame that moves along, holding a place in the wind minus the
velocity: the plant feels its air-relative velocity only, and laws see errors. So the fixed point is sought with the place held.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import atan, cos, degrees, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.margins.closing import close_terms
from objectives.margins.linearise import OperatingPoint, PeriodStep, Plant, one_period, plant_about
from objectives.margins.period import BODY, ROTORS, PeriodMap
from plant.errors import InputError
from plant.quadrotor.cascade import MIN_LIFT
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.rigid_body import Dynamics, dynamics
from plant.quadrotor.trim import steady_flight, within_limits
from plant.quadrotor.vehicle import Vehicle
from plant.records import flatten, index, size
from plant.references.spec import HOLD
from plant.references.track import Reference
from plant.vectors import Vec3

Array = NDArray[np.float64]

ITERATIONS = 40
# Largest change of any state over a period, relative to 1 + |state|, that counts as steady.
STEADY = 1e-8
# Size of a term's signal, in its unit, below which it is at rest.
AT_REST = 1e-12
# What a term's value may lack of f(s), in its unit, and the body of its balance, relative to 1 + |value|.
SETTLED = 1e-6
# Size of a state or of a term's value at which Newton's method has run away.
ASTRAY = 1e7
ZERO = Vec3(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Trim:
    """Steady flight in which margins are judged; by default hover in still air.

    yaw [rad]; velocity over ground and wind [m/s], world ENU; hold: whether the position loops are closed, False for the
    attitude mode, which has a steady state only in still air.
    """

    yaw: float = 0.0
    velocity: Vec3 = field(default=ZERO)
    wind: Vec3 = field(default=ZERO)
    hold: bool = True

    def __post_init__(self) -> None:
        numbers = {"yaw": self.yaw, "velocity": self.velocity, "wind": self.wind}
        for key, value in numbers.items():
            if not np.all(np.isfinite(value)):
                raise InputError(f"given {value}; numbers must be finite", key=key)
        if not self.hold and self.moves:
            raise InputError(
                "given wind or velocity in attitude mode, where nothing holds the place; allowed: none", key="hold"
            )

    @property
    def air(self) -> Vec3:
        """Air velocity as felt by a frame that moves along [m/s]."""
        return Vec3(*[w - v for w, v in zip(self.wind, self.velocity, strict=True)])

    @property
    def moves(self) -> bool:
        """True where the air moves past the vehicle."""
        return any(self.air)


def mean_pole(rise: float, fall: float) -> float:
    """Return the equivalent pole [1/s] of a rotor with two rates.

    It acts on small oscillations of a rotor that speeds up and slows down at different rates.
    x' = a e + b |e| with a = (rise + fall)/2, b = (rise - fall)/2, e = command - x. An oscillation e = E (sin t - r) shifts its
    own mean until a r = b mean|sin t - r|, and its first harmonic then sees a + 2 b mean(|sin t - r| sin t). That depends on no
    amplitude: 80 and 40 1/s act as 55 1/s, not as 60.
    """
    a, b = 0.5 * (rise + fall), 0.5 * (rise - fall)
    t = np.linspace(0.0, 2.0 * np.pi, 4096, endpoint=False)
    shift = 0.0
    for _ in range(ITERATIONS):
        shift = b / a * float(np.mean(np.abs(np.sin(t) - shift), axis=0))
    return a + b * 2.0 * float(np.mean(np.abs(np.sin(t) - shift) * np.sin(t), axis=0))


def smooth_dynamics(vehicle: Vehicle) -> Dynamics:
    """Return the dynamics' constants with one rotor pole for both directions."""
    f = dynamics(vehicle)
    pole = mean_pole(f.rise, f.fall)
    return f._replace(rise=pole, fall=pole)


def setting_of(trim: Trim, nominal: Nominal, vehicle: Vehicle) -> OperatingPoint:
    """Return a trim as rows of numbers."""
    reference = Reference(ZERO, ZERO, ZERO, 0.0, 0.0, trim.yaw, 0.0, float(trim.hold))
    air = Disturbance(trim.air, ZERO, ZERO, ZERO)
    rows = [nominal, reference, air, smooth_dynamics(vehicle)]
    return OperatingPoint(*[np.array(flatten(row), dtype=float) for row in rows])


def balanced_plant(period: PeriodMap, trim: Trim, nominal: Nominal, setting: OperatingPoint) -> Plant:
    """Return the plant about its balance of air, weight and rotors.

    Its attitude and rotor speeds leave it at rest, whatever the gains.
    Raises InputError where there are none within the limits of tilt, of rotor speed and of how little lift the controller asks
    for.
    """
    flight = steady_flight(setting.dynamics[None], np.array([trim.air]), trim.yaw)
    # Lift as the controller counts it, by its own mass and thrust coefficient.
    assumed, speeds = nominal.vehicle, flight.body[0, -ROTORS:]
    lift = assumed.thrust_coefficient * float(np.sum(speeds**2, axis=0)) * cos(flight.tilt[0])
    if not (within_limits(flight, nominal)[0] and lift > MIN_LIFT * assumed.mass * assumed.gravity):
        raise InputError(
            f"no steady flight in an air flow of {sqrt(sum(part * part for part in trim.air)):.3g} m/s within the limits of tilt "
            f"({degrees(atan(nominal.tilt_tangent)):.3g} deg), rotor speed and least lift ({MIN_LIFT:.0%} of the weight that "
            "the controller assumes); give less wind or velocity, or a vehicle that its rotors carry and that is no feather to "
            "its controller",
            key="trim",
        )
    return plant_about(period, flight.body[0], setting)


@dataclass(frozen=True)
class TrimPoint:
    """Steady flight of n gains rows.

    Attributes:
        state: States (n, x).
        w: Outputs of the nonlinear terms there (n, terms).
        steady: Mask (n,) of the rows that are steady.
        step: The period there.
    """

    state: Array
    w: Array
    steady: NDArray[np.bool_]
    step: PeriodStep


class RatePhases(NamedTuple):
    """The control periods of a common period in steady flight.

    state: states (n, x) at its start. steady: mask (n,) of the rows that are steady.
    """

    steps: tuple[PeriodStep, ...]
    state: Array
    steady: NDArray[np.bool_]


def find_trim(
    period: PeriodMap, gains: Array, setting: OperatingPoint, plant: Plant, secant: Callable[[], Array]
) -> TrimPoint:
    """Return the trim of gains rows (n, g) of a plant in balance.

    It starts from where their flights start.
    A flight starts in balance, with the trim command given to every law, so most laws are at their fixed point at once; of others
    Newton's method finds it. A row's result does not depend on the others. A row that runs away, or ends outside the limits, is
    not steady. secant() -> (n, terms): gains that represent the nonlinear terms while their signals are at rest.
    """
    starts = np.broadcast_to(plant.body, (len(gains), BODY))
    (state,) = period.at_rest(starts, gains, setting.nominal, setting.reference, setting.dynamics)
    w = np.zeros((len(gains), len(period.terms)))
    step = one_period(period, state, w, gains, setting, plant)
    if not _is_steady(state, w, step).all():
        state, w = _iterate(period, state, w, gains, setting, plant, secant())
        step = one_period(period, state, w, gains, setting, plant)
    return TrimPoint(state, w, _is_steady(state, w, step) & _is_balanced(state, plant), step)


def _is_balanced(state: Array, plant: Plant) -> NDArray[np.bool_]:
    """Return the mask of rows whose plant is where it was linearized.

    Its place does not count; it is at the commanded yaw in particular.
    """
    off = np.abs(state[:, :BODY] - plant.body) / (1.0 + np.abs(plant.body))
    return np.all(off[:, size(Vec3) :] < SETTLED, axis=1)


def _iterate(
    period: PeriodMap, state: Array, w: Array, gains: Array, setting: OperatingPoint, plant: Plant, secant: Array
) -> tuple[Array, Array]:
    """States and term values of steady flight, with limits out of reach: the way there may lead beyond them."""
    free = replace(setting, nominal=_without_limits(setting.nominal))
    going = np.ones(len(gains), dtype=bool)
    for _ in range(ITERATIONS):
        step = one_period(period, state, w, gains, free, plant)
        # Each row stops by itself.
        going &= ~_is_steady(state, w, step)
        if not going.any():
            break
        next_state, next_w = _newton(state, w, step, secant, bool(setting.reference[HOLD] > 0.5))
        going &= _is_sound(next_state) & _is_sound(next_w)
        state, w = (np.where(going[:, None], new, old) for new, old in ((next_state, state), (next_w, w)))
    return state, w


def _is_sound(values: Array) -> NDArray[np.bool_]:
    """Return the mask of rows (n, m) that steady flight can have; NaN is not."""
    return np.all(np.abs(values) < ASTRAY, axis=1)


def _without_limits(nominal: Array) -> Array:
    """The same controller with limits that are out of reach."""
    wide = nominal.copy()
    for path, value in {"thrust_min": -1e6, "thrust_max": 1e6, "tilt_tangent": 1e6}.items():
        wide[index(Nominal, path)] = value
    return wide


def _given(step: PeriodStep) -> Array:
    """Return the values of the terms, nothing for a signal at rest: a sign jumps there."""
    return np.where(np.abs(step.signals) < AT_REST, 0.0, step.values)


def _is_steady(state: Array, w: Array, step: PeriodStep) -> NDArray[np.bool_]:
    drift, lag = np.abs(step.state - state) / (1.0 + np.abs(state)), np.abs(_given(step) - w)
    return np.all(drift < STEADY, axis=1) & np.all(lag < SETTLED, axis=1)


def _newton(state: Array, w: Array, step: PeriodStep, secant: Array, held: bool) -> tuple[Array, Array]:
    """Return state and w after one step of Newton's method.

    It solves x = F(x, w) and w = f(s), each f taken for a line through 0 and through where it is.
    """
    drift, lag = step.state - state, _given(step) - w
    s = step.signals
    at_rest = np.abs(s) < AT_REST
    ratio = np.where(at_rest, secant, step.values / np.where(at_rest, 1.0, s))
    closed = close_terms(step.loops, ratio)
    # w changes by its lag, and by ratio times the change of s; what adds to w enters through the same columns.
    pushed = drift + _applied(closed.b[:, :, closed.terms], lag)
    system = np.eye(state.shape[1]) - closed.a
    # A state that nothing moves, like an integral of gain zero, and one that moves nothing keep their value.
    rows, columns = np.arange(state.shape[1]), np.abs(system).max(axis=1) < 1e-13
    idle = columns | (np.abs(system).max(axis=2) < 1e-13)
    system[:, rows, rows] += idle
    change = _solved(system, pushed, held)
    return state + change, w + lag + ratio * _applied(closed.c[:, closed.terms], change)


def _applied(matrices: Array, vectors: Array) -> Array:
    return (matrices @ vectors[..., None])[..., 0]


def _solved(system: Array, right: Array, held: bool) -> Array:
    """Solution of the Newton system; in attitude mode every place is a steady state, and the nearest is taken."""
    if not held:
        return _nearest(system, right)
    try:
        return np.asarray(np.linalg.solve(system, right[..., None])[..., 0], dtype=float)
    except np.linalg.LinAlgError:
        # One of the batch has no solution: one by one, so that the others keep theirs to the last bit.
        change = np.empty(right.shape)
        for i in range(len(system)):
            try:
                change[i] = np.linalg.solve(system[i], right[i])
            except np.linalg.LinAlgError:
                change[i] = _nearest(system[i], right[i])
        return change


def _nearest(system: Array, right: Array) -> Array:
    """Least solution of those that come closest."""
    return _applied(np.linalg.pinv(system, rcond=1e-10).astype(float), right)
