"""Programs that play firmwares: the Crazyflie's module, and control libraries that are compiled from a checkout."""

import shutil
import subprocess
from pathlib import Path

from tests.clients import program
from tuner.extensions.autopilots.libraries.building import ControlLibraries

PLAYED = Path(__file__).parent
LIBRARIES = ControlLibraries(
    name="played",
    checkout="the folder of the played sources",
    source=PLAYED / "loops.cpp",
    middleware=PLAYED / "middleware.hpp",
    empty=("elsewhere/topic.h",),
    folders=(".",),
    marker="loops.hpp",
)
CHECKOUT = PLAYED / "checkout"


def played_in(folder: Path) -> Path:
    """Put the module into a folder, as a build leaves its own; return its library."""
    made = folder / "_cffirmware.so"
    subprocess.run([program("gcc"), "-shared", "-fPIC", "-O2", "-o", str(made), str(PLAYED / "played.c")], check=True)
    shutil.copy(PLAYED / "cffirmware.py", folder)
    return made
