"""Targets by name; a new exporter is one module with an `EXPORTER` and one line here."""

from plant.errors import UnknownNameError
from tuner.export import ardupilot, betaflight, betaflight_adrc, matlab, px4, ros2, rotorpy
from tuner.export.c99 import exporter as c99
from tuner.export.crazyflie import exporter as crazyflie
from tuner.export.exporter import Exporter
from tuner.export.fmi import exporter as fmi

MODULES = (c99, px4, ardupilot, crazyflie, betaflight, betaflight_adrc, ros2, fmi, matlab, rotorpy)
EXPORTERS: dict[str, Exporter] = {module.EXPORTER.name: module.EXPORTER for module in MODULES}


def exporter(name: str) -> Exporter:
    """Return the exporter of a target; raises UnknownNameError."""
    name = name.lower()
    if name not in EXPORTERS:
        raise UnknownNameError("target", name, EXPORTERS, key="--to")
    return EXPORTERS[name]
