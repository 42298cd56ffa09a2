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


def is_variant(prefix: str) -> bool:
    """Whether a case is of a law whose tests are slow."""
    return prefix.rpartition("_")[0] in VARIANTS


class Libraries(dict[str, Compiled]):
    """Compiled cases: variants are one library, the others another; the worker that comes first compiles each."""

    def __init__(self, base: Path) -> None:
        self.base = base

    def __missing__(self, prefix: str) -> Compiled:
        cases = {name: case for name, case in CASES.items() if is_variant(name) is is_variant(prefix)}
        folder = self.base / ("c99-variants" if is_variant(prefix) else "c99-library")
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
