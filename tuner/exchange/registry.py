"""Targets by name; a new exporter is one module with an `EXPORTER` and one line here."""

from plant.errors import UnknownNameError
from tuner.exchange.ardupilot import exporter as ardupilot
from tuner.exchange.betaflight import adrc as betaflight_adrc
from tuner.exchange.betaflight import exporter as betaflight
from tuner.exchange.c99 import exporter as c99
from tuner.exchange.crazyflie import exporter as crazyflie
from tuner.exchange.exporter import Exporter
from tuner.exchange.fmi import exporter as fmi
from tuner.exchange.matlab import exporter as matlab
from tuner.exchange.px4 import exporter as px4
from tuner.exchange.ros2 import exporter as ros2
from tuner.exchange.rotorpy import exporter as rotorpy

MODULES = (c99, px4, ardupilot, crazyflie, betaflight, betaflight_adrc, ros2, fmi, matlab, rotorpy)
EXPORTERS: dict[str, Exporter] = {module.EXPORTER.name: module.EXPORTER for module in MODULES}


def exporter(name: str) -> Exporter:
    """Return the exporter of a target; raises UnknownNameError."""
    name = name.lower()
    if name not in EXPORTERS:
        raise UnknownNameError("target", name, EXPORTERS, key="--to")
    return EXPORTERS[name]
