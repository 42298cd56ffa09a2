"""One control period of the closed loop that flies, as CasADi functions with exact derivatives.

The controller's part is `ClosedLoop.decide` with meters that keep nothing, the plant's part the Runge-Kutta step: the model's own
functions, rebound, with signals added and read by `injection`.
"""

from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from objectives.margins.derivative import Batch, Derivative, column_of, columns, record_of
from objectives.margins.injection import SMOOTH, InstantReadings, SignalInjection, Signals, Term, terms_of
from plant.attitude import euler_angles
from plant.backends import symbolic
from plant.cascade import AXES, Cascade, commanded_torque
from plant.closed_loop import Limits, close_loop, rotor_line
from plant.disturbance import Disturbance
from plant.fittings import BARE, Fittings
from plant.integrator import runge_kutta_step
from plant.loop import ClosedLoop, MeterModel, Timing
from plant.nominal import Nominal
from plant.records import record_type, size, zeros
from plant.references.track import Reference
from plant.rigid_body import Body, Dynamics
from plant.sensors import Noise
from plant.targets import Targets
from plant.vectors import Rotors, Vec3, rotors_sum

__all__ = [
    "BODY",
    "CHANNELS",
    "NO_METERS",
    "N_CHANNELS",
    "ROTORS",
    "NoMeters",
    "PeriodMap",
    "Term",
    "period_map",
    "state_type",
    "terms_of",
]

Array = NDArray[np.float64]
CHANNELS = AXES
N_CHANNELS = len(CHANNELS)
BODY, ROTORS = size(Body), size(Rotors)
STILL = Vec3(0.0, 0.0, 0.0)


class NoMeters(NamedTuple):
    """Meters that keep nothing."""


def _keep_nothing(*_: Any) -> NoMeters:
    return NoMeters()


NO_METERS = MeterModel(NoMeters, _keep_nothing, _keep_nothing)


def state_type(cascade: Cascade, fitted: Fittings = BARE) -> Any:
    """Return the record of all that one control period hands to the next; meters and status are no part of it.

    fitted: what the vehicle is fitted with.
    """
    parts = {
        "body": Body,
        "queue": rotor_line(fitted.late).Queue,
        "in_force": Rotors,
        "pending": Rotors,
        "gyro": fitted.gyro.Memory,
        "notches": fitted.notches.Memory,
        "battery": fitted.supply.Memory,
        "control": cascade.Memory,
    }
    return record_type("SampledState", parts)


class PeriodMap:
    """One control period of a cascade at a control period and plant step, of a vehicle fitted so.

    terms: its nonlinear terms. state: record type of the sampled state. Its parts are functions of batches:

        at_rest(body, gains, nominal, reference) -> state
        decide(x with v, w, r, gains, nominal, reference) -> (speeds and next memory, readings c, s, y, e), derivative, f(s)
        fly(body, speeds and load, disturbance, dynamics) -> body one plant step later, derivative
    """

    def __init__(self, cascade: Cascade, timing: Timing, fitted: Fittings = BARE) -> None:
        self.cascade = cascade
        self.timing = timing
        self.terms = terms_of(cascade)
        self.state = state_type(cascade, fitted.feedback)
        self._loop: ClosedLoop = close_loop(cascade, NO_METERS, fitted.feedback)

    @cached_property
    def at_rest(self) -> Batch:
        """State in which a flight starts."""
        bind = symbolic.rebinder()
        body, gains, nominal, reference = columns(BODY, size(self.cascade.Gains), size(Nominal), size(Reference))
        constants = bind(self.cascade.prepare)(record_of(self.cascade.Gains, gains), self.timing.control_period)
        flight = bind(self._loop.start)(
            record_of(Body, body), constants, record_of(Nominal, nominal), record_of(Reference, reference), zeros(Noise),
            zeros(Targets),
        )  # fmt: skip
        state = self.state(**{part: getattr(flight, part) for part in self.state._fields})
        return Batch("rest", [body, gains, nominal, reference], [column_of(state)])

    @cached_property
    def decide(self) -> Derivative:
        """Speeds, the state behind the body, then c, s, y, e, differentiated by state, v, w and r; and f(s)."""
        state, v, w, r, gains, nominal, reference = columns(
            size(self.state),
            N_CHANNELS,
            len(self.terms),
            N_CHANNELS,
            size(self.cascade.Gains),
            size(Nominal),
            size(Reference),
        )
        plain = symbolic.rebinder()
        constants = plain(self.cascade.prepare)(record_of(self.cascade.Gains, gains), self.timing.control_period)
        injection = SignalInjection(self.terms, constants, Signals(v, w, r))
        before, known = record_of(self.state, state), record_of(Nominal, nominal)
        goal = injection.shifted(record_of(Reference, reference))
        after = self._instant(injection, before, constants, known, goal)
        seen = _readings(injection, before, after, known, goal)
        memory = [column_of(getattr(after, part)) for part in ("speed", *self.state._fields[1:])]
        outputs = ca.vertcat(*memory, seen.command, seen.signals, seen.output, seen.error)
        inputs = ca.vertcat(state, v, w, r)
        return Derivative("decide", inputs, [inputs, gains, nominal, reference], outputs, seen.values)

    def _instant(self, injection: SignalInjection, before: Any, constants: Any, known: Any, goal: Reference) -> Any:
        """Flight record after the controller's instant."""
        idle = Rotors(0.0, 0.0, 0.0, 0.0)
        control = _unclipped(before.control)
        flight = self._loop.Flight(
            before.body, idle, before.queue, before.in_force, before.pending, before.gyro, before.notches, before.battery,
            control, NoMeters(), 0.0, 0.0,
        )  # fmt: skip
        return symbolic.rebinder(injection.stand_ins())(self._loop.decide)(
            flight,
            constants,
            known,
            goal,
            zeros(Noise),
            zeros(Targets),
            Limits(1.0, 0.0),
            0.0,
            self.timing.control_period,
        )

    @cached_property
    def fly(self) -> Derivative:
        """Body after a plant step, differentiated by body, speeds asked for and load, which adds to the accelerations."""
        inputs, disturbance, constants = columns(BODY + ROTORS + N_CHANNELS, size(Disturbance), size(Dynamics))
        pushed = disturbance + ca.vertcat(ca.SX.zeros(size(Disturbance) - N_CHANNELS), inputs[BODY + ROTORS :])
        end = symbolic.rebinder(SMOOTH)(runge_kutta_step)(
            record_of(Body, inputs[:BODY]), record_of(Rotors, inputs[BODY : BODY + ROTORS]), record_of(Disturbance, pushed),
            record_of(Dynamics, constants), self.timing.plant_step,
        )  # fmt: skip
        return Derivative("fly", inputs, [inputs, disturbance, constants], column_of(end), ca.SX(0, 1))


@lru_cache(maxsize=8)
def period_map(cascade: Cascade, timing: Timing, fitted: Fittings) -> PeriodMap:
    """Return the control period of a cascade; steady states and vehicles share one, for its functions take 0.1 s to derive."""
    return PeriodMap(cascade, timing, fitted)


def _unclipped(control: Any) -> Any:
    """The cascade's memory with nothing taken away by limits, to the last bit.

    Allocation and its inverse leave rounding errors of 1e-17 there, which laws that restart an integral by them divide by.
    """
    return control._replace(actuators=control.actuators._replace(acceleration_excess=STILL, torque_excess=STILL))


def _readings(injection: SignalInjection, before: Any, after: Any, known: Any, goal: Reference) -> InstantReadings:
    """Return the readings of the instant that turned the state `before` into the flight record `after`."""
    plain = symbolic.rebinder()
    torque = plain(commanded_torque)(after.in_force, known.vehicle)
    lift = plain(rotors_sum)(after.in_force) / known.vehicle.mass
    demand, tilt = after.control.acceleration, after.control.tilt
    output = (*before.body.position, *plain(euler_angles)(before.body.attitude))
    goals = (*goal.position, tilt.roll, tilt.pitch, goal.yaw)
    seen = [injection.seen[i] for i in range(len(injection.seen))]
    return InstantReadings(
        ca.vertcat(demand.x, demand.y, lift, *torque),
        column_of(tuple(s for s, _ in seen)),
        column_of(tuple(value for _, value in seen)),
        ca.vertcat(*output),
        ca.vertcat(*[y - set_point for y, set_point in zip(output, goals, strict=True)]),
    )
