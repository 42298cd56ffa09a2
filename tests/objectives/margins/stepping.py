"""The closed loop stepped from any state in plain Python or on arrays, with signals added by hand where the margins inject theirs."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.period import NO_METERS, NoMeters, Term, state_type
from objectives.margins.trim import Trim
from plant.backends.rebind import PRIMITIVES, Rebinder
from plant.loop import Timing
from plant.quadrotor.allocation import speed_commands
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.cascade import Cascade, Tilt, commanded_torque, tilt_for
from plant.quadrotor.closed_loop import Limits, close_loop
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.features import BARE, VehicleFeatures
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.rigid_body import Dynamics
from plant.quadrotor.sample import Targets
from plant.quadrotor.sensors import Noise
from plant.records import flatten, pack, size
from plant.references.track import Reference
from plant.vectors import Vec3, axpy_rotors

Array = NDArray[np.float64]
ZERO = Vec3(0.0, 0.0, 0.0)
FAR = Limits(1e9, -1.0)


class Stepper:
    """One period after another of a cascade in a trim.

    dynamics: constants of the equations of motion. terms and gain: numbers that are flown in place of the nonlinear terms, or None
    for the terms themselves. names: what mathematical names mean, those of plain Python or of the array backend. features: of the
    vehicle.
    """

    def __init__(
        self,
        cascade: Cascade,
        nominal: Nominal,
        timing: Timing,
        dynamics: Dynamics,
        trim: Trim,
        terms: tuple[Term, ...] = (),
        gain: Array | None = None,
        names: dict[str, Any] = PRIMITIVES,
        features: VehicleFeatures = BARE,
    ) -> None:
        self.cascade, self.nominal, self.timing, self.dynamics, self.trim = cascade, nominal, timing, dynamics, trim
        self.terms, self.gain = terms, gain
        self.loop, self.drive = close_loop(cascade, NO_METERS, features), features.drive
        self.state = state_type(cascade, features)
        self.disturbance = Disturbance(trim.air, ZERO, ZERO, ZERO)
        self._names = names
        self._plain = Rebinder(names)

    def reference(self, at: Vec3 = ZERO, velocity: Vec3 = ZERO) -> Reference:
        """The set points of the trim."""
        return Reference(at, velocity, ZERO, 0.0, 0.0, self.trim.yaw, 0.0, float(self.trim.hold))

    def _straight(self, constants: Any, term: Term) -> Callable[..., Any]:
        def line(s: Any, own: Any) -> Any:
            assert self.gain is not None
            axis = next(axis for axis in constants._fields if getattr(constants, axis) is own)
            index = next(i for i, t in enumerate(self.terms) if (t.axis, t.nonlinearity) == (axis, term.nonlinearity))
            return self.gain[index] * s

        return line

    def step(
        self,
        state: Any,
        gains: Any,
        push: Callable[..., Any] | None = None,
        twist: Callable[..., Any] | None = None,
        reference: Reference | None = None,
    ) -> tuple[Array, Array, Array]:
        """Next state, command at the break points and output (place and angles), one row each.

        push(demand x, demand y) -> what is added to them [m/s2]; twist(lift, torques, sub-step) -> what is added to these [m/s2, N m].
        """
        h, plant_step = self.timing
        before = pack(self.state, list(state))
        constants = self._plain(self.cascade.prepare)(pack(self.cascade.Gains, list(gains)), h)
        aim = self._plain(tilt_for)

        def pushed(acceleration: Vec3, heading: Vec3, gravity: float) -> Tilt:
            x, y = push(acceleration.x, acceleration.y) if push else (0.0, 0.0)
            return aim(acceleration._replace(x=acceleration.x + x, y=acceleration.y + y), heading, gravity)

        stand_ins: dict[Callable[..., Any], Callable[..., Any]] = {tilt_for: pushed}
        if self.gain is not None:
            stand_ins |= {term.nonlinearity.function: self._straight(constants, term) for term in self.terms}
        flight = self.loop.Flight(
            before.body,
            before.in_force,
            before.queue,
            before.in_force,
            before.pending,
            before.gyro,
            before.notches,
            before.battery,
            before.control,
            NoMeters(),
            0.0,
            0.0,
        )
        after = Rebinder(self._names, stand_ins=stand_ins)(self.loop.decide)(
            flight,
            constants,
            self.nominal,
            reference or self.reference(),
            pack(Noise, [0.0] * size(Noise)),
            pack(Targets, [0.0] * size(Targets)),
            FAR,
            0.0,
            h,
        )
        lift = sum(after.in_force) / self.nominal.vehicle.mass
        torque = commanded_torque(after.in_force, self.nominal.vehicle)
        body, demand = after.body, after.control.acceleration
        for sub_step in range(round(h / plant_step)):
            added = twist(lift, torque, sub_step) if twist else (0.0, 0.0, 0.0, 0.0)
            thrust = after.in_force
            for amount, column in zip(
                (self.nominal.vehicle.mass * added[0], *added[1:]), self.nominal.allocation, strict=True
            ):
                thrust = axpy_rotors(thrust, amount, column)
            speed = self._plain(speed_commands)(thrust, self.nominal)
            speed = self._plain(self.drive.command_of)(speed, self.nominal.curve)
            body = self._plain(self.loop.advance)(body, speed, self.disturbance, self.dynamics, plant_step)
        following = flatten(
            self.state(
                body,
                after.queue,
                after.in_force,
                after.pending,
                after.gyro,
                after.notches,
                after.battery,
                after.control,
            )
        )
        seen = [*before.body.position, *self._plain(euler_angles)(before.body.attitude)]
        return np.array(following), np.array([demand.x, demand.y, lift, *torque]), np.array(seen)

    def injected(self, state: Array, gains: Array, v: Array) -> Array:
        """Next state, command and output, one after the other, with constant signals v (6,) added."""
        return np.concatenate(self.step(state.tolist(), gains.tolist(), lambda *_: v[:2], lambda *_: v[2:]))
