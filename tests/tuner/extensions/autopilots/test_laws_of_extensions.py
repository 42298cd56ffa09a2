"""Laws of extensions are laws like those of `plant`: in the same table, and in the keys of flights with all their code."""

from pathlib import Path

import pytest

from objectives import memory, meters
from objectives.memory import flight_code
from plant.backends import array
from plant.backends.rebind import Rebinder
from plant.law_registry import LAWS, MODULES
from tests.plant.loops import loop
from tuner.extensions.autopilots import law_parts
from tuner.extensions.betaflight_adrc import equations
from tuner.extensions.textbook_laws import delay_line, pid_parts

OF_EXTENSIONS = {
    module.LAW.name: Path(str(module.__file__)) for module in MODULES if module.__name__.startswith("tuner.")
}
SHARED = {Path(str(part.__file__)) for part in (law_parts, equations, pid_parts, delay_line)}
NAMES_OF_OUTPUT = {"p", "i", "d", "ff"}


def test_they_are_bundled_laws_and_packages_do_not_add_them_again():
    LAWS.ask_packages()
    assert len(OF_EXTENSIONS) == 14 and all(LAWS[name].origin is None for name in OF_EXTENSIONS)


@pytest.mark.parametrize("name", LAWS)
def test_keys_of_flights_hold_every_file_of_a_law(name):
    closed, bind = loop(name, name), Rebinder(array.NAMES)
    for function in (closed.prepare, closed.start, closed.decide, closed.advance):
        bind(function)
    home = Path(next(iter(memory.plant.__path__)))
    files = {file for file in bind.sources | closed.sources if file.is_file() and not file.is_relative_to(home)}
    outside = files - {Path(str(meters.__file__))}
    assert outside <= set(flight_code().values())
    assert outside - SHARED == ({OF_EXTENSIONS[name]} if name in OF_EXTENSIONS else set())


@pytest.mark.parametrize("name", LAWS)
def test_gains_of_output_are_those_beside_an_authority(name):
    gains = {gain.name: gain for gain in LAWS[name].gains}
    marked = {name for name, gain in gains.items() if gain.of_output}
    assert marked == (NAMES_OF_OUTPUT & set(gains) if "authority" in gains else set())
