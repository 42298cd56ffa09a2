"""Gains with other values, for what-if questions: `gains.replace(kp=2)` and option `--gain kp=2` of commands."""

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar, cast

from plant.errors import InputError, UnknownNameError
from plant.texts import PlainTable
from tuner.gains.hashing import content_hash
from tuner.store.document import write_new

G = TypeVar("G")
# Sections of gains.json that are true of the old values alone.
OF_THE_VALUES = ("study", "point", "objectives", "margins", "exports", "sha256")
KEY = "--gain"


def changed_values(given: Mapping[str, float], changes: Mapping[str, float]) -> dict[str, float]:
    """Return gains by address with changes; InputError for an unknown or ambiguous name.

    Args:
        given: Gains by address.
        changes: Value by address, or by the last part of an address that one loop alone has.
    """
    values = dict(given)
    for name, value in changes.items():
        values[_address(name, given)] = float(value)
    return values


def _address(name: str, addresses: Collection[str]) -> str:
    if name in addresses:
        return name
    loops = [address for address in addresses if address.rpartition(".")[2] == name]
    if len(loops) == 1:
        return loops[0]
    if loops:
        raise InputError(f"given '{name}', which several loops have; write one of {', '.join(loops)}", key=KEY)
    raise UnknownNameError("gain", name, list(addresses), key=KEY)


def reread(document: PlainTable, values: Mapping[str, float], read: Callable[[Path], G]) -> G:
    """Return gains of a document with other values, checked as a file.

    Args:
        document: Content of gains.json.
        values: Gains by address.
        read: Reader of a gains.json.
    """
    left = {key: part for key, part in document.items() if key not in OF_THE_VALUES}
    given = cast("dict[str, PlainTable]", document["gains"])
    gains = {address: {"value": values[address], "unit": entry["unit"]} for address, entry in given.items()}
    changed: PlainTable = {**left, "gains": gains}
    if "sha256" in document:
        changed["sha256"] = content_hash(changed)
    with TemporaryDirectory() as folder:
        try:
            return read(write_new(Path(folder) / "gains.json", changed))
        except InputError as error:
            raise InputError(error.message, key=error.key or KEY) from None
