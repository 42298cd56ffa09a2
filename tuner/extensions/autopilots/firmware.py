"""The seam to real firmware: what a program that flies our plant has to offer. See docs/how_to/confirm.md.

A firmware is a program of the user's own, started and spoken to, never linked. It gets its gains from the file that our exporter
writes, what our sensors measure and the set points of our position loops, and answers with motor commands.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from plant.errors import InputError
from plant.laws.channel import Measured, Setpoint
from plant.quadrotor.airframes.actuation import Actuation
from tuner.extensions.autopilots.instants import Instant

Commands = tuple[float, float, float, float]
"""Motor commands (0 to 1) in our order of the rotors."""


def period_check(count: Callable[[float], float], least: int, most: int, allowed: str) -> Callable[[float], None]:
    """Return a function that refuses impossible control periods of a firmware.

    Args:
        count: count(control_period) is a whole number where they can.
        least: Smallest count.
        most: Largest count.
        allowed: Periods that are possible, in a clause.
    """

    def check(control_period: float) -> None:
        number = count(control_period)
        if not least <= round(number) <= most or abs(number - round(number)) > 1e-6 * number:
            raise InputError(f"given {1e3 * control_period:g} ms; {allowed}", key="controller.control_period")

    return check


class Board(Protocol):
    """A firmware that runs; it is powered up when it is made."""

    def arm(self, initial: Instant, throttle: float, held: Commands) -> None:
        """Arm it at rest on the bench for an instant and throttle (0 to 1).

        The flight begins there. held: motor commands that hold the vehicle there, in its mean wind, to which a board
        brings its integrals if it can.
        """
        ...

    def step(self, setpoints: Instant, throttle: float) -> Commands:
        """Run one control period; return the motor commands."""
        ...

    def close(self) -> None:
        """Power it off."""
        ...


@dataclass(frozen=True)
class Bench:
    """A bench for a firmware.

    Attributes:
        binary: The program.
        folder: A folder for its settings.
        rotors: Rotors of the nominal vehicle.
        control_period: Control period [s].
    """

    binary: Path
    folder: Path
    rotors: Actuation
    control_period: float


@dataclass(frozen=True)
class Firmware:
    """A firmware that can fly our plant.

    Attributes:
        name: Short name.
        title: Name as people say it.
        target: Target of the export whose file it takes.
        file: Name of that file.
        law: Law of the attitude loops that it flies as they are.
        heading: Model function (constants of the law, Setpoint, Measured) -> rate of yaw that the pilot asks for; None
            where the firmware closes the heading itself and is given the angle.
        curve: Curve of thrust over its motor commands, see `airframes.actuation.Actuation`; None for that of the vehicle.
        binary: Meaning of --binary, in a clause.
        check: check(control_period) raises InputError naming a period at which its loops cannot run.
        program: program(argument of --binary) -> the file of it whose digest is recorded.
        install: install(bench, content of the file) -> what powers a board up; it raises InputError naming what the
            firmware refuses.
        lockstep: Whether it is in step with the plant, so that equal flights should be equal to the last bit.
        loses: Sentences on what is rounded on the way in and out.
        options: Options of the export, NAME=VALUE.
    """

    name: str
    title: str
    target: str
    file: str
    law: str
    heading: Callable[[Any, Setpoint, Measured], float] | None
    curve: float | None
    binary: str
    check: Callable[[float], None]
    program: Callable[[Path], Path]
    install: Callable[[Bench, bytes], Callable[[], Board]]
    lockstep: bool
    loses: tuple[str, ...]
    options: tuple[str, ...] = ()
