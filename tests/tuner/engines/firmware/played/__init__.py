"""A module that plays the Crazyflie's."""

import shutil
import subprocess
from pathlib import Path

from tests.clients import program

PLAYED = Path(__file__).parent


def played_in(folder: Path) -> Path:
    """Put the module into a folder, as a build leaves its own; return its library."""
    made = folder / "_cffirmware.so"
    subprocess.run([program("gcc"), "-shared", "-fPIC", "-O2", "-o", str(made), str(PLAYED / "played.c")], check=True)
    shutil.copy(PLAYED / "cffirmware.py", folder)
    return made
