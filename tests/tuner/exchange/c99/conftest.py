"""One library of all laws for every file and worker: tracing and compiling them takes 7 s."""

import fcntl
import os
from typing import Any

import pytest

from plant.law_registry import LAWS
from plant.quadrotor.nominal import ControlOptions
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


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Compiled]:
    """All cases, compiled by the worker that comes first."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "c99-library"
    folder.mkdir(exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return loaded(folder, CASES) if (folder / "controllers.so").exists() else build(folder, CASES)
