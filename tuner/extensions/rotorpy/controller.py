"""A controller of ours in RotorPy's terms: the export 'rotorpy' copies this file and the model functions that it calls.

RotorPy (S. Folk, J. Paulos, V. Kumar, RotorPy, 2023) calls `update(t, state, flat_output)` once a simulation step. Its frames
are ours, world ENU and body FLU; its quaternion is (x, y, z, w), body to world, ours is (w, x, y, z).
"""

from collections.abc import Mapping, Sequence
from math import cos, floor, sin
from typing import Any

import numpy as np

from plant.laws.law import Law
from plant.quadrotor.allocation import speed_commands
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.cascade import close_cascade, commanded_torque, hovering
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.rigid_body import Body
from plant.quadrotor.sensors import Measurement, Noise, measure
from plant.quadrotor.vehicle import Vehicle
from plant.records import pack
from plant.references.track import Reference
from plant.vectors import Quaternion, Rotors, Vec3, rotors_sum

_STILL = Vec3(0.0, 0.0, 0.0)
_NO_NOISE = Noise(_STILL, _STILL, _STILL, _STILL)
_NO_SPEED = Rotors(0.0, 0.0, 0.0, 0.0)
# A call this close to a control instant, as a share of the control period, counts as on it: RotorPy adds its steps up.
_ON_TIME = 1e-3


class FlightController:
    """Flies a cascade with given gains; its command is held over each control period.

    control_abstraction = "cmd_ctbm". The simulation rate must be a whole multiple of the control rate, 1 / control_period.
    """

    def __init__(
        self,
        position: Law,
        attitude: Law,
        gains: Sequence[float],
        vehicle: Vehicle,
        options: ControlOptions,
        control_period: float,
        position_every: int = 1,
    ) -> None:
        """Close the loops of the laws at their gains.

        Args:
            position: Law of the position loops.
            attitude: Law of the attitude loops.
            gains: Gains in column order.
            vehicle: The vehicle as the controller models it.
            options: Options of the controller.
            control_period: Control period [s].
            position_every: Control periods between two steps of the position loops.
        """
        self._cascade = close_cascade(position, attitude, position_every)
        self._nominal = nominal(vehicle, options, control_period)
        self._period = control_period
        self._constants = self._cascade.prepare(pack(self._cascade.Gains, gains), control_period)
        self.reset()

    def reset(self) -> None:
        """Forget the flight; the next update starts another one."""
        hover = self._nominal.hover
        self._memory: Any = None
        self._instant = -1
        self._in_force = self._pending = Rotors(hover, hover, hover, hover)

    def update(
        self, t: float, state: Mapping[str, Any], flat_output: Mapping[str, Any]
    ) -> dict[str, float | np.ndarray]:
        """Return the command at time t [s].

        state: x [m], v [m/s], q (x, y, z, w), w [rad/s]. flat_output: x, x_dot, x_ddot, yaw, yaw_dot. The command: cmd_thrust [N]
        and cmd_moment (3,) [N m]; what they are made of, front left, front right, rear left, rear right, as cmd_motor_thrusts
        (4,) [N] and cmd_motor_speeds (4,) [rad/s]; and cmd_q, the attitude asked for, which RotorPy's plots want. Raises
        ValueError where the simulation rate is no multiple of the control rate.
        """
        instant = floor(t / self._period + _ON_TIME)
        if instant < self._instant:
            self.reset()
        if instant > self._instant:
            self._check_time(t, instant)
            self._decide(measured(state), wanted(flat_output))
            self._instant = instant
        thrust = self._in_force
        return {
            "cmd_thrust": rotors_sum(thrust),
            "cmd_moment": np.array(commanded_torque(thrust, self._nominal.vehicle)),
            "cmd_motor_thrusts": np.array(thrust),
            "cmd_motor_speeds": np.array(speed_commands(thrust, self._nominal)),
            "cmd_q": quaternion(self._memory.tilt.roll, self._memory.tilt.pitch, float(flat_output["yaw"])),
        }

    def _decide(self, m: Measurement, reference: Reference) -> None:
        """One control period, as in `closed_loop.py`: a command comes into force at once, or a period later with delay."""
        if self._memory is None:
            self._memory = self._cascade.start(self._constants, m, self._nominal, hovering(self._nominal))
        command, self._memory = self._cascade.step(
            self._memory, self._constants, self._nominal, reference, m, self._in_force, self._period
        )
        self._in_force = self._pending if self._nominal.delay > 0.5 else command
        self._pending = command

    def _check_time(self, t: float, instant: int) -> None:
        late = t - instant * self._period
        if self._memory is None or (instant == self._instant + 1 and late < 2.0 * _ON_TIME * self._period):
            return
        raise ValueError(
            f"called at t = {t:.6g} s, but the control period is {self._period:g} s: set sim_rate to a whole multiple of "
            f"{1.0 / self._period:g} Hz"
        )


def measured(state: Mapping[str, Any]) -> Measurement:
    """Return RotorPy's state as the cascade measures it, without noise."""
    x, y, z, w = map(float, state["q"])
    attitude = Quaternion(w, x, y, z)
    body = Body(vector(state["x"]), vector(state["v"]), attitude, vector(state["w"]), _NO_SPEED)
    return measure(body, euler_angles(attitude), body.rate, _NO_NOISE)


def wanted(flat_output: Mapping[str, Any]) -> Reference:
    """Return RotorPy's flat output as our reference."""
    return Reference(
        vector(flat_output["x"]),
        vector(flat_output["x_dot"]),
        vector(flat_output["x_ddot"]),
        0.0,
        0.0,
        float(flat_output["yaw"]),
        float(flat_output["yaw_dot"]),
        1.0,
    )


def vector(values: Any) -> Vec3:
    """Return three numbers as a vector of floats."""
    x, y, z = values
    return Vec3(float(x), float(y), float(z))


def quaternion(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Return the attitude of R = Rz(yaw) Ry(pitch) Rx(roll) as (x, y, z, w)."""
    (a, b, c), (s, t, u) = ([turn(0.5 * angle) for angle in (roll, pitch, yaw)] for turn in (cos, sin))
    return np.array([s * b * c - a * t * u, a * t * c + s * b * u, a * b * u - s * t * c, a * b * c + s * t * u])
