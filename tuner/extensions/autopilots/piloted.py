"""The closed loop of a quadrotor whose attitude is flown from outside: set points go out, rotor thrusts come in.

The position loops take the pilot's place above a firmware that is asked at every control instant. A flight goes
ask, (thrusts from outside), decide, advance, ask, ...: `decide` takes the thrusts that the control memory holds.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Law
from plant.loop import MeterModel
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.cascade import Cascade, Tilt, TrimCommand, close_cascade
from plant.quadrotor.closed_loop import CascadeLoop, close_loop
from plant.quadrotor.features import BARE, VehicleFeatures
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.sensors import Measurement, Noise, measure
from plant.records import record_type
from plant.references.track import Reference
from plant.vectors import Rotors, Vec3


class PilotCommand(NamedTuple):
    """The wish of a pilot for an axis.

    wish: the rate at which the angle error is to be made good [y/s], or the angle itself [y]; rate: of the reference [y/s].
    """

    wish: float
    rate: float


@dataclass(frozen=True)
class ExternalControlLoop(CascadeLoop):
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

    def start(constants: Any, measured: Measured, held: float) -> PilotCommand:  # noqa: ARG001
        return PilotCommand(0.0, 0.0)

    def step(
        memory: PilotCommand,
        constants: Any,
        channel: Channel,
        setpoint: Setpoint,
        measured: Measured,
        applied: Applied,  # noqa: ARG001
        h: float,  # noqa: ARG001
    ) -> tuple[float, PilotCommand]:
        return 0.0, PilotCommand(wish(constants, setpoint, measured), setpoint.rate)

    return replace(law, name=f"{law.name}_pilot", Memory=PilotCommand, start=start, step=step)


def close_piloted(
    cascade: Cascade, pilot: Law, meter: MeterModel, features: VehicleFeatures = BARE
) -> ExternalControlLoop:
    """Close the loop of a cascade with a pilot above its attitude.

    Gains keep their columns. features: as of `plant.quadrotor.closed_loop.close_loop`.
    """
    controller = close_cascade(cascade.position, pilot)
    Memory = record_type(
        "PilotedMemory",
        {
            "controller": controller.Memory,
            "lift": Rotors,
            "outside": Rotors,
            "tilt": Tilt,
            "angles": Vec3,
            "rate": Vec3,
        },
    )
    start_controller, step_controller = controller.start, controller.step

    def start(constants: Any, m: Measurement, nominal: Nominal, held: TrimCommand) -> Any:
        control = start_controller(constants, m, nominal, held)
        return Memory(control, held.thrust, held.thrust, held.tilt, m.angles, m.rate)

    def step(
        memory: Any,
        constants: Any,
        nominal: Nominal,
        reference: Reference,
        m: Measurement,
        in_force: Rotors,
        h: float,  # noqa: ARG001
    ) -> tuple[Rotors, Any]:
        return memory.outside, memory

    loop = close_loop(replace(controller, Memory=Memory, start=start, step=step), meter, features)
    Flight, hear = loop.Flight, features.gyro.hear

    def ask(flight: Any, constants: Any, nominal: Nominal, reference: Reference, noise: Noise, h: float) -> Any:
        rate, _ = hear(flight.gyro, flight.body, noise, nominal, h)
        m = measure(flight.body, euler_angles(flight.body.attitude), rate, noise)
        memory = flight.control
        lift, control = step_controller(memory.controller, constants, nominal, reference, m, flight.in_force, h)
        waiting = Memory(control, lift, memory.outside, control.tilt, m.angles, m.rate)
        return Flight(
            flight.body,
            flight.speed,
            flight.queue,
            flight.in_force,
            flight.pending,
            flight.gyro,
            flight.notches,
            flight.battery,
            waiting,
            flight.meters,
            flight.status,
            flight.end_time,
        )

    return ExternalControlLoop(**{field.name: getattr(loop, field.name) for field in fields(loop)}, ask=ask)
