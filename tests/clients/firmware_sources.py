"""Sources of firmwares whose control libraries are compiled. Nothing of them is part of this project.

Whoever has cloned them names the folders: docs/how_to/confirm.md.
"""

import os
from pathlib import Path

import pytest

from tests.clients import CLIENTS
from tuner.extensions.autopilots.libraries.building import ControlLibraries

PLACES = {"px4": ("TUNER_PX4_SOURCES", "PX4-Autopilot"), "ardupilot": ("TUNER_ARDUPILOT_SOURCES", "ardupilot")}
"""Firmware -> variable that names the folder, and folder among the clients."""


def checkout(libraries: ControlLibraries) -> Path:
    """Return the folder of a firmware's sources; skips the test where there is none."""
    named, usual = PLACES[libraries.name]
    folder = Path(os.environ.get(named, CLIENTS / usual))
    if not (folder / libraries.marker).is_file():
        pytest.skip(
            f"no {libraries.marker} in {folder}; clone {usual} as docs/how_to/confirm.md says, name it by {named}"
        )
    return folder
