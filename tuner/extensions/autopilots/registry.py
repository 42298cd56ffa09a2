"""Firmwares that fly finalists, by name."""

from functools import cache

from plant.errors import check_name
from plant.texts import PlainTable
from tuner.extension import objects
from tuner.extensions.autopilots.firmware import Firmware


@cache
def firmwares() -> dict[str, Firmware]:
    """Return the firmwares by name."""
    return objects("firmwares")


def firmware_of(name: str) -> Firmware:
    """Return a firmware; UnknownNameError where there is none of that name."""
    check_name("firmware", name, firmwares(), key="--firmware")
    return firmwares()[name]


def list_firmwares() -> list[PlainTable]:
    """Firmwares that `tuner confirm` flies finalists in."""
    return [
        {"firmware": entry.name, "title": entry.title, "target": entry.target, "law": entry.law, "binary": entry.binary}
        for entry in firmwares().values()
    ]
