"""The closed loop of a quadrotor whose attitude is flown from outside: set points go out, rotor thrusts come in.

The position loops take the pilot's place above a firmware that is asked at every control instant. A flight goes
ask, (thrusts from outside), decide, advance, ask, ...: `decide` takes the thrusts that the control memory holds.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

from plant.attitude import euler_angles
from plant.cascade import Cascade, Held, Tilt, close_cascade
from plant.closed_loop import CascadeLoop, close_loop
from plant.fittings import BARE, Fittings
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Law
from plant.loop import MeterModel
from plant.nominal import Nominal
from plant.records import record_type
from plant.references.track import Reference
from plant.sensors import Measurement, Noise, measure
from plant.vectors import Rotors, Vec3


class Asked(NamedTuple):
    """The wish of a pilot for an axis: the rate at which the angle error is to be made good [y/s], or the angle itself [y]."""

    wish: float


@dataclass(frozen=True)
class PilotedLoop(CascadeLoop):
    """A closed loop that waits for rotor thrusts.

    ask(flight, constants, nominal, reference, noise, h) -> the flight with set points for what it measures now, in `control`.
    """

    ask: Callable[..., Any]


def angle(constants: Any, setpoint: Setpoint, measured: Measured) -> float:  # noqa: ARG001
    """The angle itself, for a firmware that closes the loop on it."""
    return setpoint.value


def pilot_of(law: Law, wish: Callable[[Any, Setpoint, Measured], float]) -> Law:
    """Return the law of a pilot above a firmware that flies `law`: no torque of its own, and what it asks for.

    wish(constants, setpoint, measured) is a model function: the outer loop that the firmware leaves to its pilot, or `angle`.
    """

    def start(constants: Any, measured: Measured, held: float) -> Asked:  # noqa: ARG001
        return Asked(0.0)

    def step(
        memory: Asked, constants: Any, channel: Channel, setpoint: Setpoint, measured: Measured, applied: Applied,  # noqa: ARG001
        h: float,  # noqa: ARG001
    ) -> tuple[float, Asked]:  # fmt: skip
        return 0.0, Asked(wish(constants, setpoint, measured))

    return replace(law, name=f"{law.name}_pilot", Memory=Asked, start=start, step=step)


def close_piloted(cascade: Cascade, pilot: Law, meter: MeterModel, fitted: Fittings = BARE) -> PilotedLoop:
    """Close the loop of a cascade with a pilot in the place of its attitude loops; gains keep their columns, fitted: see
    `plant.closed_loop.close_loop`.
    """
    own = close_cascade(cascade.position, pilot)
    Memory = record_type(
        "PilotedMemory",
        {"own": own.Memory, "lift": Rotors, "outside": Rotors, "tilt": Tilt, "angles": Vec3, "rate": Vec3},
    )
    own_start, own_step = own.start, own.step

    def start(constants: Any, m: Measurement, nominal: Nominal, held: Held) -> Any:
        control = own_start(constants, m, nominal, held)
        return Memory(control, held.thrust, held.thrust, held.tilt, m.angles, m.rate)

    def step(
        memory: Any, constants: Any, nominal: Nominal, reference: Reference, m: Measurement, in_force: Rotors, h: float  # noqa: ARG001
    ) -> tuple[Rotors, Any]:  # fmt: skip
        return memory.outside, memory

    loop = close_loop(replace(own, Memory=Memory, start=start, step=step), meter, fitted)
    Flight, hear = loop.Flight, fitted.gyro.hear

    def ask(flight: Any, constants: Any, nominal: Nominal, reference: Reference, noise: Noise, h: float) -> Any:
        rate, _ = hear(flight.gyro, flight.body, noise, nominal, h)
        m = measure(flight.body, euler_angles(flight.body.attitude), rate, noise)
        memory = flight.control
        lift, control = own_step(memory.own, constants, nominal, reference, m, flight.in_force, h)
        asked = Memory(control, lift, memory.outside, control.tilt, m.angles, m.rate)
        return Flight(
            flight.body, flight.speed, flight.queue, flight.in_force, flight.pending, flight.gyro, flight.notches,
            flight.battery, asked, flight.meters, flight.status, flight.end_time,
        )  # fmt: skip

    return PilotedLoop(**{field.name: getattr(loop, field.name) for field in fields(loop)}, ask=ask)
