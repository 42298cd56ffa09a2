"""Targets by name; a new one is a folder with a `TARGET` in its `export.py` and one line here."""

from plant.errors import UnknownNameError
from tuner.exchange.ardupilot import export as ardupilot
from tuner.exchange.betaflight import adrc as betaflight_adrc
from tuner.exchange.betaflight import export as betaflight
from tuner.exchange.c99 import export as c99
from tuner.exchange.crazyflie import export as crazyflie
from tuner.exchange.fmi import export as fmi
from tuner.exchange.matlab import export as matlab
from tuner.exchange.px4 import export as px4
from tuner.exchange.ros2 import export as ros2
from tuner.exchange.rotorpy import export as rotorpy
from tuner.exchange.target import ExportTarget, Importer

MODULES = (c99, px4, ardupilot, crazyflie, betaflight, betaflight_adrc, ros2, fmi, matlab, rotorpy)
EXPORTERS: dict[str, ExportTarget] = {module.TARGET.name: module.TARGET for module in MODULES}
"""Every target, in the order of listings."""
IMPORTERS: dict[str, Importer] = {name: target.importer for name, target in EXPORTERS.items() if target.importer}
"""The way back, of the targets that have one."""


def exporter(name: str) -> ExportTarget:
    """Return the target of a name; raises UnknownNameError."""
    name = name.lower()
    if name not in EXPORTERS:
        raise UnknownNameError("target", name, EXPORTERS, key="--to")
    return EXPORTERS[name]


def importer(name: str) -> Importer:
    """Return the importer of a target; raises UnknownNameError."""
    if name not in IMPORTERS:
        raise UnknownNameError("source", name, IMPORTERS, key="--from")
    return IMPORTERS[name]
