"""Flights of a system whose attitude a firmware flies: our plant, air, sensors, position loops and meters around it."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from math import isfinite, sqrt

import numpy as np

from objectives.flown_system import FlightBatch
from objectives.system import System
from plant.backends.flyer import FlightInputs
from plant.backends.lane_layout import LANES
from plant.backends.stepping import lane_of
from plant.errors import InputError
from plant.quadrotor.airframes.actuation import Actuation, actuation
from tuner.extensions.autopilots.firmware import Board, Commands, Firmware
from tuner.extensions.autopilots.instants import Stepper
from tuner.extensions.autopilots.piloted import angle, close_piloted, pilot_of

OnFlight = Callable[[int], None]
# Motor commands beyond their range by this much are rounding.
ROUNDING = 1e-6


class FirmwareFlights:
    """Flies gains of a system in a firmware; system: with the accumulators of the metrics that are asked for."""

    def __init__(self, system: System, firmware: Firmware, root: int, threads: int = 1) -> None:
        firmware.check(system.timing.control_period)
        self._system, self._firmware, self._root, self._threads = system, firmware, root, threads
        pilot = pilot_of(system.cascade.attitude, firmware.heading or angle)
        # Notches are the firmware's own business.
        loop = close_piloted(system.cascade, pilot, system.meter, system.fitted._replace(harmonics=0))
        self._stepper = Stepper(loop, loop.ask, system.limits, system.timing)
        self._rotors = actuation(system.nominal.vehicle, firmware.curve)

    def fly(
        self, gains: np.ndarray, power_up: Callable[[], Board], batch: FlightBatch, done: OnFlight | None = None
    ) -> np.ndarray:
        """Fly gains (g,) through a batch; return results (flights, rows) as `plant.backends.flyer.Flyer.fly` does.

        power_up: starts a board that holds these gains. Raises InputError where the firmware dies, is silent or answers nonsense.
        """
        flights = range(batch.start, batch.count)
        inputs = self._system.sample(batch.spec, self._root, batch.stream, flights)

        def one(flight: int) -> np.ndarray:
            result = self._fly_one(gains, power_up, inputs, flight)
            if done is not None:
                done(1)
            return result

        with ThreadPoolExecutor(self._threads) as pool:
            return np.array(list(pool.map(one, range(len(flights)))))

    def _fly_one(
        self, gains: np.ndarray, power_up: Callable[[], Board], inputs: FlightInputs, number: int
    ) -> np.ndarray:
        lane = lane_of(inputs, number % LANES, number // LANES)
        flight = self._stepper.begin(gains, self._system.nominal, lane, inputs.targets)
        board = power_up()
        try:
            first, second, third, fourth = (throttle_for(thrust, self._rotors) for thrust in flight.held)
            begin = flight.pilot_command
            board.arm(begin, throttle_for(begin.lift, self._rotors), (first, second, third, fourth))
            while not flight.over and not flight.lost:
                pilot_command = flight.pilot_command
                commands = board.step(pilot_command, throttle_for(pilot_command.lift, self._rotors))
                flight.fly(thrusts_of(commands, self._rotors, self._firmware))
        finally:
            board.close()
        return flight.result


def throttle_for(lift: float, rotors: Actuation) -> float:
    """Return the motor command (0 to 1) at which one rotor gives a lift [N]."""
    share, f = min(max(lift / rotors.thrust_max, 0.0), 1.0), rotors.curve
    return share if f <= ROUNDING else (f - 1.0 + sqrt((1.0 - f) ** 2 + 4.0 * f * share)) / (2.0 * f)


def thrusts_of(commands: Commands, rotors: Actuation, firmware: Firmware) -> tuple[float, float, float, float]:
    """Return the rotor thrusts [N] of motor commands; raises InputError where they are none."""
    if not all(isfinite(command) and -ROUNDING <= command <= 1.0 + ROUNDING for command in commands):
        given = ", ".join(f"{command:g}" for command in commands)
        raise InputError(
            f"{firmware.title} answered with the motor commands {given}; allowed: 0 to 1. Is the program the one that "
            "docs/how_to/confirm.md builds?",
            key="--binary",
        )
    low, high, f = rotors.thrust_min, rotors.thrust_max, rotors.curve
    first, second, third, fourth = (min(max(high * (f * u * u + (1.0 - f) * u), low), high) for u in commands)
    return first, second, third, fourth
