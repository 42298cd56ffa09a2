"""Facts on a vehicle in parameter files of the Crazyflie: the thrust at hover."""

from collections.abc import Mapping

from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.autopilots.vehicle_facts import HOVER, MIN_COMMAND, SHARES, VehicleFact, exactly, given_number
from tuner.extensions.crazyflie.map import TABLE, UINT16

THRUST_BASE = "posCtlPid.thrustBase"


def crazyflie_facts(values: Mapping[str, str | float]) -> list[VehicleFact]:
    """Return the facts of a file's parameters; counts are proportional to thrust."""
    counts = given_number(values, THRUST_BASE, TABLE[THRUST_BASE].usual)
    if counts is None or not MIN_COMMAND <= counts / UINT16 <= 1.0:
        return []
    return [VehicleFact(HOVER, f"{THRUST_BASE} / {UINT16:.0f}", counts / UINT16, exactly(thrust_share), SHARES)]


def thrust_share(vehicle: Vehicle) -> float:
    """Return the thrust at hover over the largest [1]."""
    rotors = actuation(vehicle)
    return rotors.hover_thrust / rotors.thrust_max
