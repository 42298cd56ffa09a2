"""What an importer is: a parameter file of a target in, a controller of ours out, with everything that did not fit said."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from plant.airframes import Airframe
from tuner.exchange.exporter import Option
from tuner.gains import Controller


@dataclass(frozen=True)
class Imported:
    """controller: what the file's gains are on the airframe; notes: one sentence for each thing taken as default or left out;
    untouched: names in the file of what does not act in these loops.
    """

    controller: Controller
    notes: tuple[str, ...]
    untouched: tuple[str, ...] = ()


@dataclass(frozen=True)
class Importer:
    """One target. read(file, airframe, settings) -> Imported raises InputError naming file and parameter; options are checked
    before it is called.
    """

    name: str
    title: str
    options: tuple[Option, ...]
    read: Callable[[Path, Airframe, Mapping[str, str]], Imported]
