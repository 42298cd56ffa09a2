"""Flights of an opinion: tracking and noise, then rejection.

A light breeze excites little that a rate loop is for: P, I and D of roll and pitch halved change the attitude error of a racer
in it by 1 %, and that after a step of torque by 130 %. So each file also flies

- torque step: from level flight, the torque of the vehicle's weight on a tenth of its arm, as of a battery that shifts;
- gust: one pulse (1 - cos) of three times the breeze, in 1 s;
- strong manoeuvre: 41 deg of tilt with 45 deg of yaw at once, which takes rotors of the shipped airframes to their limits;
- low battery: that manoeuvre with 80 % of the charge used, where the airframe has a battery.

These have no turbulence: their flights differ by the vehicle and by the noise of the gyro.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import sqrt

from plant.air.gust import Gust
from plant.air.injection import Injection
from plant.air.spec import AirSpec
from plant.quadrotor.nominal import arm_of
from plant.quadrotor.scenarios import ScenarioSpec, Spread
from plant.quadrotor.sensors import SensorSpec
from plant.quadrotor.vehicle import Vehicle
from plant.references.hover import Hover
from plant.references.level import Level
from plant.references.steps import Steps
from tuner.extensions.autopilots.sources import GAINS
from tuner.gains import Controller

FAILURE, TILT, YAW, NOISE, POSITION = "failure", "rms.tilt", "rms.yaw", "noise", "rms.position"
HAS_POSITION_LOOPS = ("px4", "ardupilot", GAINS)
"""Sources whose position loops are in the file; of others they are our defaults, and no part of the verdict."""
FIRST_FLIGHT = ScenarioSpec(
    "small steps in a light breeze",
    6.0,
    Steps(x=0.5, y=-0.5, z=0.25, yaw_deg=10.0, time=0.5),
    AirSpec(intensity=2.0, altitude=3.0, minimum_airspeed=1.0, mean_wind=True),
)
"""Flights that gains are judged by: 2 m/s of wind at 20 ft, Beaufort 2."""
SPREAD = Spread(mass=0.1, inertia=0.1, thrust=0.05, lag=0.2)
"""Spread of vehicles whose airframe has no uncertainty: that of the shipped studies of firmwares."""
GYRO_NOISE = 0.05 / sqrt(2000.0)
"""Density of the gyro's noise where the airframe has none [rad/s/sqrt(Hz)]: 0.05 rad/s at 4 kHz, a frame that vibrates."""
CALM = AirSpec(intensity=0.0, altitude=3.0, minimum_airspeed=1.0, mean_wind=False)
MANOEUVRE = Steps(roll_deg=30.0, pitch_deg=-30.0, yaw_deg=45.0, time=0.2)
OFFSET = 0.1
"""Lever of the weight in a torque step, as a share of the arm."""
GUST = Gust(6.0, 0.5, 1.0, (1.0, 1.0, 0.0))
USED_SHARE = 0.8
"""Share of the charge that is used where the battery is low."""
SHARE = 4
"""First flights for each flight of a further scenario, in which only the vehicle is drawn."""


@dataclass(frozen=True)
class JudgedScenario:
    """One kind of flight of an opinion.

    Attributes:
        spec: The flight.
        metrics: Metrics that are compared in it.
        share: First flights for each flight of it.
        prepare: Change of the vehicle that flies it.
    """

    spec: ScenarioSpec
    metrics: tuple[str, ...]
    share: int = SHARE
    prepare: Callable[[Vehicle], Vehicle] | None = None

    def vehicle_of(self, controller: Controller) -> Controller:
        """Return the controller on the vehicle that flies the scenario."""
        if self.prepare is None:
            return controller
        airframe = controller.airframe
        return replace(controller, airframe=replace(airframe, vehicle=self.prepare(airframe.vehicle)))


def judged_scenarios(controller: Controller, source: str) -> list[JudgedScenario]:
    """Return the scenarios of an opinion, the first flight first.

    Args:
        controller: Loops whose vehicle flies.
        source: Firmware, or "gains".
    """
    first, vehicle = first_flight(controller), controller.airframe.vehicle
    has_position = source in HAS_POSITION_LOOPS
    position = (POSITION,) if has_position else ()
    calm = replace(first, air=CALM)
    torque = replace(
        calm, name="torque step", duration=2.0, reference=Level(), air=replace(CALM, injection=torque_step(vehicle))
    )
    gust = replace(
        calm,
        name="gust",
        duration=3.0,
        reference=Hover() if has_position else Level(),
        air=replace(CALM, gust=GUST),
    )
    manoeuvre = replace(calm, name="strong manoeuvre", duration=2.0, reference=MANOEUVRE)
    scenarios = [
        JudgedScenario(first, (TILT, YAW, NOISE, *position), share=1),
        JudgedScenario(torque, (TILT,)),
        JudgedScenario(gust, (TILT, *position)),
        JudgedScenario(manoeuvre, (TILT,)),
    ]
    if vehicle.battery_capacity > 0.0:
        low = replace(manoeuvre, name="low battery")
        scenarios.append(JudgedScenario(low, (TILT,), prepare=drain_battery))
    return scenarios


def first_flight(controller: Controller) -> ScenarioSpec:
    """Return a first flight: small steps in a light breeze, with the gyro's noise."""
    uncertainty = controller.airframe.uncertainty
    rate = noise_density(controller) * sqrt(0.5 / controller.control_period)
    return replace(
        FIRST_FLIGHT,
        sensors=SensorSpec(rate=rate),
        spread=Spread() if uncertainty else SPREAD,
        uncertainty=uncertainty,
    )


def noise_density(controller: Controller) -> float:
    """Return the density of the gyro's noise [rad/s/sqrt(Hz)]."""
    return controller.airframe.gyro_noise or GYRO_NOISE


def torque_step(vehicle: Vehicle) -> Injection:
    """Return the torque of the weight on a tenth of the arm."""
    torque = vehicle.mass * vehicle.gravity * OFFSET * arm_of(vehicle)
    return Injection(angular_bias=(torque / vehicle.inertia.x, torque / vehicle.inertia.y, 0.0))


def drain_battery(vehicle: Vehicle) -> Vehicle:
    """Return a vehicle whose battery is low."""
    return vehicle._replace(battery_used=max(vehicle.battery_used, USED_SHARE * vehicle.battery_capacity))
