"""The Crazyflie's controllers as the Python module that its own Makefile builds. Nothing of it is part of this project.

No package registry has them, so whoever has built them names the folder: docs/how_to/confirm.md.
"""

import os
from pathlib import Path

import pytest

from tests.clients import CLIENTS

NAMED = "TUNER_CRAZYFLIE_BUILD"


def build() -> Path:
    """Return the folder of the build; skips the test where there is none."""
    folder = Path(os.environ.get(NAMED, CLIENTS / "crazyflie-firmware" / "build"))
    if not list(folder.glob("_cffirmware*.so")):
        pytest.skip(
            f"no module _cffirmware in {folder}; build it as docs/how_to/confirm.md says, and name it by {NAMED}"
        )
    return folder
