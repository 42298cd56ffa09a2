"""Importers by name; a new one is one module with an `IMPORTER` and one line here."""

from plant.errors import UnknownNameError
from tuner.exchange.ardupilot import importer as ardupilot
from tuner.exchange.betaflight import importer as betaflight
from tuner.exchange.importer import Importer
from tuner.exchange.px4 import importer as px4

MODULES = (px4, ardupilot, betaflight)
IMPORTERS: dict[str, Importer] = {module.IMPORTER.name: module.IMPORTER for module in MODULES}


def importer(name: str) -> Importer:
    """Return the importer of a target; raises UnknownNameError."""
    if name not in IMPORTERS:
        raise UnknownNameError("source", name, IMPORTERS, key="--from")
    return IMPORTERS[name]
