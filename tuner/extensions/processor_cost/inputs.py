"""Typical inputs of a control step: those of a short closed flight through turbulence, instant by instant.

How many instructions a step takes depends on its inputs only where code branches on them (limits, roots, turns of the yaw),
so counts are taken over one metre steps with a turn of 20 deg in moderate turbulence with sensor noise.
"""

from dataclasses import dataclass, replace
from math import cos, radians
from typing import Any

from objectives.margins.period import NO_METERS
from plant.air.spec import AirSpec
from plant.backends.stepping import fly_steps, lane_of, unchanged
from plant.laws.channel import Applied
from plant.laws.law import Law
from plant.loop import Timing
from plant.quadrotor.attitude import euler_angles, nearest_turn
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import Limits, close_loop
from plant.quadrotor.nominal import nominal
from plant.quadrotor.scenarios import ScenarioSpec, sample_scenarios
from plant.quadrotor.sensors import Measurement, Noise, measure
from plant.records import flatten, pack
from plant.references.steps import Steps
from plant.references.track import Reference
from tuner.gains import Controller

STREAM, SEED = "cost", 1
# Length of the flight: 2 s, but never more periods than this, which keeps the table of inputs below 200 kB.
DURATION, MAX_STEPS = 2.0, 1000
LIMITS = Limits(5.0, cos(radians(80.0)))


@dataclass(frozen=True)
class Instant:
    """One control instant: what the whole cascade is given, and what its three attitude loops are given.

    angles, goal: roll, pitch, yaw as measured and as asked for [rad], the yaw counted on through whole turns; applied: for
    each attitude loop, effect and excess of its last command [N m].
    """

    reference: Reference
    measurement: Measurement
    goal: tuple[float, float, float]
    angles: tuple[float, float, float]
    applied: tuple[Applied, Applied, Applied]


class _Ended(Exception):
    """The flight left its limits; what was recorded until then is the answer."""


def typical_inputs(controller: Controller) -> list[Instant]:
    """Return the instants of the flight, at least one; a flight that leaves its limits ends there."""
    h = controller.control_period
    steps = min(round(DURATION / h), MAX_STEPS)
    timing = Timing(h, controller.plant_step)
    spec = ScenarioSpec(
        "cost",
        steps * h,
        Steps(x=1.0, y=-1.0, z=0.5, yaw_deg=20.0, time=0.25 * steps * h),
        AirSpec(intensity="moderate", mean_wind=False),
    )
    vehicle = controller.airframe.vehicle
    drawn = sample_scenarios(spec, vehicle, timing, SEED, STREAM, [0])
    lane = lane_of(drawn, 0)
    seen: list[Instant] = []
    spy = _Spy(controller.cascade.attitude)
    loop = close_loop(close_cascade(controller.cascade.position, spy.law), NO_METERS)

    def watch(k: int, flight: Any) -> None:
        body, reference = flight.body, pack(Reference, lane.references[k].tolist())
        measurement = measure(body, euler_angles(body.attitude), body.rate, pack(Noise, lane.noises[k].tolist()))
        tilt, yaw = flight.control.tilt, flight.control.yaw_seen
        goal = (tilt.roll, tilt.pitch, nearest_turn(reference.yaw, yaw))
        angles = (measurement.angles.x, measurement.angles.y, yaw)
        seen.append(Instant(reference, measurement, goal, angles, spy.pop_applied()))
        if flight.status > 0.5:
            raise _Ended

    gains = pack(controller.cascade.Gains, controller.gains)
    knowledge = nominal(vehicle, controller.options, h)
    try:
        fly_steps(loop, unchanged, gains, knowledge, lane, drawn.targets, LIMITS, timing, watch)
    except _Ended:
        pass
    return seen


class _Spy:
    """A law that records its applied commands: of three loops in every step."""

    def __init__(self, law: Law) -> None:
        self._noted: list[Applied] = []
        inner_step = law.step

        def step(
            memory: Any, constants: Any, channel: Any, setpoint: Any, measured: Any, applied: Any, h: float
        ) -> Any:
            self._noted.append(applied)
            return inner_step(memory, constants, channel, setpoint, measured, applied, h)

        self.law = replace(law, step=step)

    def pop_applied(self) -> tuple[Applied, Applied, Applied]:
        """Return and clear the applied commands of the last three calls."""
        roll, pitch, yaw = self._noted
        self._noted.clear()
        return roll, pitch, yaw


def step_row(instant: Instant) -> list[float]:
    """Return the inputs of a step of the cascade as a row: reference, measurement."""
    return [*flatten(instant.reference), *flatten(instant.measurement)]


def attitude_row(instant: Instant) -> list[float]:
    """Return the inputs of the attitude step as a row: goal, reference of the yaw rate, angles, rate, effect, excess."""
    applied = instant.applied
    return [
        *instant.goal,
        instant.reference.yaw_rate,
        *instant.angles,
        *instant.measurement.rate,
        *[entry.effect for entry in applied],
        *[entry.excess for entry in applied],
    ]
