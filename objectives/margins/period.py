"""One control period of the closed loop that flies, in CasADi.

Its functions have exact derivatives.
The controller's part is `ClosedLoop.decide` with meters that keep nothing, the plant's part the Runge-Kutta step: the model's own
functions, rebound, with signals added and read by `injection`.
"""

from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from objectives.margins.derivative import Batch, Derivative, column_of, columns, record_of
from objectives.margins.frequency import LOWEST
from objectives.margins.injection import SMOOTH, InstantReadings, SignalInjection, Signals, Term, terms_of
from plant.backends import array, symbolic
from plant.loop import ClosedLoop, MeterModel, Timing
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES, Cascade, commanded_torque
from plant.quadrotor.closed_loop import Limits, close_loop
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.features import BARE, VehicleFeatures
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.rigid_body import Body, Dynamics
from plant.quadrotor.sample import Targets
from plant.quadrotor.sensors import Noise
from plant.records import pack, record_type, size, zeros
from plant.references.track import Reference
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
    "constants_of",
    "period_map",
    "state_type",
    "terms_of",
]

Array = NDArray[np.float64]
CHANNELS = AXES
N_CHANNELS = len(CHANNELS)
# Channels that are inputs of the plant itself; x and y are demands inside the controller.
PLANT_INPUTS = tuple(CHANNELS.index(name) for name in ("z", *ATTITUDE_AXES))
BODY, ROTORS = size(Body), size(Rotors)
STILL = Vec3(0.0, 0.0, 0.0)


class NoMeters(NamedTuple):
    """Meters that keep nothing."""


def _keep_nothing(*_: Any) -> NoMeters:
    return NoMeters()


NO_METERS = MeterModel(NoMeters, _keep_nothing, _keep_nothing)


def state_type(cascade: Cascade, fitted: VehicleFeatures = BARE) -> Any:
    """Return the record of the state between control periods.

    It is all that one hands to the next; meters and status are no part of it.
    fitted: what the vehicle is fitted with.
    """
    parts = {
        "body": Body,
        "queue": fitted.line.Queue,
        "in_force": Rotors,
        "pending": Rotors,
        "gyro": fitted.gyro.Memory,
        "notches": fitted.notches.Memory,
        "battery": fitted.supply.Memory,
        "control": cascade.Memory,
    }
    return record_type("SampledState", parts)


class PeriodMap:
    """One control period of a cascade, of a vehicle fitted so.

    Control period and plant step are those of `timing`.
    terms: its nonlinear terms. state: record type of the sampled state. Its parts are functions of batches:

        at_rest(body, gains, nominal, reference, dynamics) -> state
        decide(x with v, w, r, gains, nominal, reference) -> (speeds and next memory, readings c, s, y, e), derivative, f(s)
        fly(body, speeds and load, disturbance, dynamics) -> body one plant step later, derivative
    """

    def __init__(self, cascade: Cascade, timing: Timing, fitted: VehicleFeatures = BARE) -> None:
        self.cascade = cascade
        self.timing = timing
        self.terms = terms_of(cascade)
        self.state = state_type(cascade, fitted.feedback)
        self.plant_inputs, self.lowest = PLANT_INPUTS, LOWEST
        self.channels: tuple[str, ...] = CHANNELS
        self.control_period, addresses = timing.control_period, gain_addresses(cascade)
        self.columns = {axis: [gain.column for gain in addresses if gain.axis == axis] for axis in CHANNELS}
        self._loop: ClosedLoop = close_loop(cascade, NO_METERS, fitted.feedback)
        self._drive = fitted.drive

    def constants(self, gains: Array) -> Any:
        """Return the constants of all axes for gains rows (n, g): leaves are arrays (n, 1, 1) or numbers."""
        return constants_of(self.cascade, gains, self.control_period)

    @cached_property
    def at_rest(self) -> Batch:
        """State in which a flight starts."""
        bind = symbolic.rebinder()
        body, gains, nominal, reference, dynamics = columns(
            BODY, size(self.cascade.Gains), size(Nominal), size(Reference), size(Dynamics)
        )
        constants = bind(self.cascade.prepare)(record_of(self.cascade.Gains, gains), self.timing.control_period)
        flight = bind(self._loop.start)(
            record_of(Body, body),
            constants,
            record_of(Nominal, nominal),
            record_of(Reference, reference),
            zeros(Noise),
            zeros(Targets),
            record_of(Dynamics, dynamics),
        )
        state = self.state(**{part: getattr(flight, part) for part in self.state._fields})
        return Batch("rest", [body, gains, nominal, reference, dynamics], [column_of(state)])

    def commands(self, speed: Array, dynamics: Array) -> Array:
        """Return the commands (4,) of rotor speeds (4,) [rad/s]; dynamics: of the vehicle."""
        held, flown = pack(Rotors, speed.tolist()), pack(Dynamics, dynamics.tolist())
        return np.array(self._drive.command_of(held, flown.curve))

    @cached_property
    def decide(self) -> Derivative:
        """The controller's instant, differentiated by state, v, w and r.

        Outputs are speeds, the state behind the body, then c, s, y, e; and f(s).
        """
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
        before, assumed = record_of(self.state, state), record_of(Nominal, nominal)
        goal = injection.shifted(record_of(Reference, reference))
        after = self._instant(injection, before, constants, assumed, goal)
        seen = _readings(injection, before, after, assumed, goal)
        memory = [column_of(getattr(after, part)) for part in ("speed", *self.state._fields[1:])]
        outputs = ca.vertcat(*memory, seen.command, seen.signals, seen.output, seen.error)
        inputs = ca.vertcat(state, v, w, r)
        return Derivative("decide", inputs, [inputs, gains, nominal, reference], outputs, seen.values)

    def _instant(self, injection: SignalInjection, before: Any, constants: Any, assumed: Any, goal: Reference) -> Any:
        """Flight record after the controller's instant."""
        idle = Rotors(0.0, 0.0, 0.0, 0.0)
        control = _unclipped(before.control)
        flight = self._loop.Flight(
            before.body,
            idle,
            before.queue,
            before.in_force,
            before.pending,
            before.gyro,
            before.notches,
            before.battery,
            control,
            NoMeters(),
            0.0,
            0.0,
        )
        return symbolic.rebinder(injection.stand_ins())(self._loop.decide)(
            flight,
            constants,
            assumed,
            goal,
            zeros(Noise),
            zeros(Targets),
            Limits(1.0, 0.0),
            0.0,
            self.timing.control_period,
        )

    @cached_property
    def fly(self) -> Derivative:
        """Body after a plant step, differentiated by body, commanded speeds and load.

        The load adds to the accelerations.
        """
        inputs, disturbance, constants = columns(BODY + ROTORS + N_CHANNELS, size(Disturbance), size(Dynamics))
        pushed = disturbance + ca.vertcat(ca.SX.zeros(size(Disturbance) - N_CHANNELS), inputs[BODY + ROTORS :])
        end = symbolic.rebinder(SMOOTH)(self._loop.advance)(
            record_of(Body, inputs[:BODY]),
            record_of(Rotors, inputs[BODY : BODY + ROTORS]),
            record_of(Disturbance, pushed),
            record_of(Dynamics, constants),
            self.timing.plant_step,
        )
        return Derivative("fly", inputs, [inputs, disturbance, constants], column_of(end), ca.SX(0, 1))


def constants_of(cascade: Cascade, gains: Array, control_period: float) -> Any:
    """Return the constants of all axes for gains rows (n, g).

    The leaves of the record are arrays (n, 1, 1) or numbers.
    """
    return array.rebinder()(cascade.prepare)(pack(cascade.Gains, gains.T[..., None, None]), control_period)


@lru_cache(maxsize=32)
def period_map(cascade: Cascade, timing: Timing, fitted: VehicleFeatures) -> PeriodMap:
    """Return the control period of a cascade.

    Trims and vehicles of one dead time share it, because deriving its functions takes 0.1 s.
    """
    return PeriodMap(cascade, timing, fitted)


def _unclipped(control: Any) -> Any:
    """Return the cascade's memory with exactly nothing taken away by limits.

    Allocation and its inverse leave rounding errors of 1e-17 there, which laws that restart an integral by them divide by.
    """
    return control._replace(actuators=control.actuators._replace(acceleration_excess=STILL, torque_excess=STILL))


def _readings(injection: SignalInjection, before: Any, after: Any, assumed: Any, goal: Reference) -> InstantReadings:
    """Return an instant's readings, from state `before` to flight record `after`."""
    plain = symbolic.rebinder()
    torque = plain(commanded_torque)(after.in_force, assumed.vehicle)
    lift = plain(rotors_sum)(after.in_force) / assumed.vehicle.mass
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
