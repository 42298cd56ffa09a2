"""Simulated flights through excitations: their peaks, and their logs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.system import System
from plant.backends.array import rebinder
from plant.backends.flyer import FlightInputs, Flyer
from plant.backends.stepping import lane_of
from plant.quadrotor.attitude import euler_angles, thrust_direction
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.rigid_body import Body, Dynamics, body_rate
from plant.quadrotor.scenarios import ScenarioSpec
from plant.quadrotor.sensors import Noise
from plant.quadrotor.thrust_curve import PROPORTIONAL, rotor_command
from plant.records import pack, rows, size
from plant.references.level import Level
from plant.seeds import generator
from plant.vectors import Quaternion, Rotors, Vec3, to_body
from tuner.extensions.flight_plans.excitation import Excitation, length_of, references
from tuner.extensions.logs.flight_log import FlightLog

Array = NDArray[np.float64]

ACCELEROMETER = 0.4
"""RMS of the noise of an accelerometer on a vehicle in flight [m/s2], of vibration above all."""
HEATING = 5.0
"""Time over which the torque of a motor is averaged [s]: windings of small motors warm within some seconds."""
FLIGHTS = 16
"""Flights that limits are checked in."""


@dataclass(frozen=True)
class SimulatedVehicle:
    """System, gains (n,), scenario and root seed of simulated flights."""

    system: System
    gains: Array
    spec: ScenarioSpec
    root: int

    @cached_property
    def flyer(self) -> Flyer:
        """The compiled loop."""
        return self.system.flyer()

    @property
    def alone(self) -> "SimulatedVehicle":
        """The same with the nominal vehicle in every flight."""
        plain = replace(self.spec, uncertainty=None, spread=type(self.spec.spread)())
        return replace(self, spec=plain)

    def flown(self, excitations: Sequence[Excitation], stream: str, count: int) -> "Flown":
        """Fly through excitations, in air of a stream of its own."""
        period = self.system.timing.control_period
        spec = replace(self.spec, reference=Level(), duration=length_of(excitations))
        drawn = self.system.sample(spec, self.root, stream, range(count))
        inputs = replace(drawn, references=references(excitations, period))
        kind = self.flyer.loop.Flight
        wanted = np.r_[*[rows(kind, part) for part in ("body", "speed", "in_force", "status")]]
        trace = self.flyer.trace(self.gains, self.system.nominal, inputs, 1, wanted)
        return Flown(self, inputs, trace)


@dataclass(frozen=True, eq=False)
class Flown:
    """Flights side by side; trace (flights, instants, 26): body, speeds asked for, thrusts in force, status."""

    simulated: SimulatedVehicle
    inputs: FlightInputs
    trace: Array

    @property
    def completed(self) -> bool:
        """True where every flight lasted to its end."""
        return bool(np.all(self.trace[:, -1, -1] < 0.5))

    @cached_property
    def tilt(self) -> Array:
        """Tilt (flights, instants) [rad]."""
        attitude = Quaternion(*np.moveaxis(self.trace[..., rows(Body, "attitude")], -1, 0))
        return np.arccos(np.clip(rebinder()(thrust_direction)(attitude).z, -1.0, 1.0))

    @property
    def rates(self) -> Array:
        """Body rates (flights, instants, 3) [rad/s]."""
        return self.trace[..., rows(Body, "rate")]

    @property
    def command(self) -> Array:
        """Rotor commands (flights, instants, 4), shares of full."""
        vehicle = self.simulated.system.nominal.vehicle
        return self._commands(np.sqrt(np.maximum(self.trace[..., 21:25], 0.0) / vehicle.thrust_coefficient))

    @cached_property
    def rotor_acceleration(self) -> Array:
        """Acceleration of the rotors over their hover speed (flights, instants less one, 4) [1/s]."""
        nominal = self.simulated.system.nominal
        hover = np.sqrt(nominal.hover / nominal.vehicle.thrust_coefficient)
        return np.diff(self.trace[..., rows(Body, "rotor_speed")], axis=1) / (self._period * hover)

    @cached_property
    def peaks(self) -> dict[str, float]:
        """Peaks over the flights; see `peaks_between`."""
        return self.peaks_between(0.0, np.inf)

    def peaks_between(self, begin: float, end: float) -> dict[str, float]:
        """Return the peaks over a part of the flights [s].

        tilt [rad], rate [rad/s]; height [m]: off the hover; motors: share of the way from hover to idle or to full command;
        rotor_rms, rotor_peak [1/s]: acceleration of a rotor over its hover speed, RMS over `HEATING`, and largest;
        drift [m]: without a pilot or a position loop.
        """
        count = self.trace.shape[1]
        part = slice(int(begin / self._period), int(min(np.ceil(end / self._period), count)))
        position = self.trace[:, part, rows(Body, "position")]
        acceleration = self.rotor_acceleration[:, part]
        return {
            "tilt": float(self.tilt[:, part].max()),
            "rate": float(np.abs(self.rates[:, part]).max()),
            "height": float(np.abs(position[..., 2]).max()),
            "motors": float(self._reserve_used[:, part].max()),
            "rotor_rms": largest_rms(acceleration, round(HEATING / self._period)),
            "rotor_peak": float(np.abs(acceleration).max()),
            "drift": float(np.hypot(position[..., 0], position[..., 1]).max()),
        }

    @property
    def _period(self) -> float:
        return self.simulated.system.timing.control_period

    @cached_property
    def _reserve_used(self) -> Array:
        nominal = self.simulated.system.nominal
        hover = self._commands(np.sqrt(nominal.hover / nominal.vehicle.thrust_coefficient))
        return np.maximum((self.command - hover) / (1.0 - hover), (hover - self.command) / hover)

    def _commands(self, speed: Any) -> Any:
        """Return the commands at which the nominal vehicle's rotors hold speeds [rad/s]."""
        system = self.simulated.system
        if system.fitted.drive is PROPORTIONAL:
            return speed / system.nominal.vehicle.speed_max
        return rebinder()(rotor_command)(speed, system.nominal.curve) / system.nominal.vehicle.speed_max

    def log(self, flight: int, name: str) -> FlightLog:
        """Return the log of a flight: gyro, an accelerometer, and the commands in force.

        The log has no rotor lines, frame mode or low-pass of the gyro.
        """
        period = self._period
        body, noise = self.trace[flight, :, : size(Body)], self._noise(flight)
        lift = self.lift(flight) + ACCELEROMETER * self._draw(name, flight).standard_normal(len(body))
        acceleration = np.column_stack([np.zeros((len(body), 2)), lift])
        gyro, command = body[:, rows(Body, "rate")] + noise[:, rows(Noise, "rate")], self.command[flight]
        digest = sha256(np.column_stack([gyro, lift, command]).tobytes()).hexdigest()
        return FlightLog(name, "simulated", digest, period * np.arange(float(len(body))), gyro, acceleration, command)

    def _draw(self, name: str, flight: int) -> np.random.Generator:
        return generator(self.simulated.root, f"{name}/accelerometer", flight)

    def _noise(self, flight: int) -> Array:
        """Return the sensor errors of a flight (instants, 12)."""
        # Behind them may stand the turns of the rotors.
        return _pad(lane_of(self.inputs, flight).noises[:, : size(Noise)], size(Noise))

    def angles(self, flight: int) -> Array:
        """Return roll, pitch and yaw (3, instants) of a flight [rad]."""
        return np.array(rebinder()(euler_angles)(Quaternion(*self.trace[flight, :, rows(Body, "attitude")].T)))

    def lift(self, flight: int) -> Array:
        """Return the specific force along the body's z (instants,) [m/s2]."""
        inputs = lane_of(self.inputs, flight)
        bind, dynamics = rebinder(), pack(Dynamics, inputs.dynamics)
        body = pack(Body, self.trace[flight, :, : size(Body)].T)
        speed = Rotors(*self.trace[flight, :, 17:21].T)
        air = pack(Disturbance, _pad(inputs.disturbances, size(Disturbance)).T)
        moved = bind(body_rate)(body, speed, air, dynamics).velocity
        return bind(to_body)(body.attitude, Vec3(moved.x, moved.y, moved.z + dynamics.gravity)).z


def largest_rms(series: Array, width: int) -> float:
    """Return the largest RMS over windows of a width, of all series (flights, instants, rotors)."""
    width = min(width, series.shape[1])
    sums = np.cumsum(series**2, axis=1)
    windows = sums[:, width - 1 :].copy()
    windows[:, 1:] -= sums[:, :-width]
    return float(np.sqrt(windows.max() / width))


def _pad(columns: Array, width: int) -> Array:
    """Return columns (n, few) padded with zeros (n, width)."""
    return np.pad(columns, [(0, 0), (0, width - columns.shape[1])])
