"""Libraries of all laws for every file and worker: tracing and compiling them takes 7 s."""

import fcntl
import os
from pathlib import Path
from typing import Any

import pytest

from plant.law_registry import LAWS
from plant.quadrotor.nominal import ControlOptions
from tests.conftest import VARIANTS
from tests.tuner.exchange.c99.compiled import Compiled, build, loaded, uneven

OPTIONS = {
    "delayed": ControlOptions(delay=True),
    "observed": ControlOptions("observer", "observer", lag_aware=False, tilt_limit=0.3),
}
CASES: dict[str, Any] = {f"{law}_{real}": (uneven(law, law), real) for law in LAWS for real in ("float", "double")}
CASES |= {name: (uneven("hybrid_gsta", "ladrc", options=options), "float") for name, options in OPTIONS.items()}
CASES |= {f"{name}_pid": (uneven("adrc", "pid", options=options), "float") for name, options in OPTIONS.items()}
CASES |= {"exact": (uneven("hybrid_gsta", "adrc"), "double")}
"""Prefix -> (controller, real)."""


# Laws whose C is compared in double too: between them they have all operations; of the others single precision shows it.
IN_DOUBLE = {"pid", "hybrid", "adrc", "px4", "betaflight", "smith"}


def is_slow(prefix: str) -> bool:
    """Whether the tests of a case are slow."""
    law, _, real = prefix.rpartition("_")
    return law in VARIANTS or (real == "double" and law not in IN_DOUBLE)


class Libraries(dict[str, Compiled]):
    """Compiled cases: those of slow tests are one library, the others another; the worker that comes first compiles each."""

    def __init__(self, base: Path) -> None:
        self.base = base

    def __missing__(self, prefix: str) -> Compiled:
        cases = {name: case for name, case in CASES.items() if is_slow(name) is is_slow(prefix)}
        folder = self.base / ("c99-slow" if is_slow(prefix) else "c99-library")
        folder.mkdir(exist_ok=True)
        with (folder / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.update(loaded(folder, cases) if (folder / "controllers.so").exists() else build(folder, cases))
        return self[prefix]


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Libraries:
    """All cases, compiled where a test takes one of their library."""
    base = tmp_path_factory.getbasetemp()
    return Libraries(base.parent if "PYTEST_XDIST_WORKER" in os.environ else base)
