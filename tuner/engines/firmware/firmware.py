"""The seam to real firmware: what a program that flies our plant has to offer. See docs/how_to/confirm.md.

A firmware is a program of the user's own, started and spoken to, never linked. It gets its gains from the file that our exporter
writes, what our sensors measure and the set points of our position loops, and answers with motor commands.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from plant.backends.instants import Instant
from plant.laws.channel import Measured, Setpoint
from plant.quadrotor.airframes.actuation import Actuation

Commands = tuple[float, float, float, float]
"""Motor commands (0 to 1) in our order of the rotors."""


class Board(Protocol):
    """A firmware that runs; it is powered up when it is made."""

    def arm(self, initial: Instant, throttle: float, held: Commands) -> None:
        """Arm it on the bench, at rest, for a flight that begins with this instant and throttle (0 to 1).

        held: motor commands that hold the vehicle there, in its mean wind, to which a board brings its integrals if it can.
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
    """What a firmware is set up on.

    binary: the program. folder: a folder for its settings. rotors: of the nominal vehicle. control_period [s].
    """

    binary: Path
    folder: Path
    rotors: Actuation
    control_period: float


@dataclass(frozen=True)
class Firmware:
    """A firmware that can fly our plant.

    name, title: short, and as people say it. target: of the export whose file it takes, file: that file. law: of the attitude
    loops that it flies as they are. heading: model function (constants of the law, Setpoint, Measured) -> rate of yaw that the
    pilot asks for; None where the firmware closes the heading itself and is given the angle. curve: of thrust over its motor
    commands, see `airframes.actuation.Actuation`. check(control_period) raises InputError naming a period at which its
    loops cannot run. program(what --binary names) -> the file of it whose digest is told. install(bench, content of the file)
    -> what powers a board up; it raises InputError naming what the firmware refuses. lockstep: whether it is in step with
    the plant, so that equal flights should be equal to the last bit. loses: sentences on what is rounded on the way in and out.
    """

    name: str
    title: str
    target: str
    file: str
    law: str
    heading: Callable[[Any, Setpoint, Measured], float] | None
    curve: float
    check: Callable[[float], None]
    program: Callable[[Path], Path]
    install: Callable[[Bench, bytes], Callable[[], Board]]
    lockstep: bool
    loses: tuple[str, ...]
