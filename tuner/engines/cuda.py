"""Engines by the names of `--backend`; a card that is not there is refused, for no other engine has its bits."""

from contextlib import suppress
from pathlib import Path

from objectives.engine import Engine
from objectives.flown_system import FlownSystem
from plant.errors import InputError, StoreError, check_name
from tuner.store.inputs import read_record

KEY = "--backend"
LANES = "lanes"
PRECISIONS = {"cuda": "float64", "cuda-float32": "float32"}
BACKENDS = (LANES, *PRECISIONS)


def engine_named(backend: str, system: FlownSystem, root: int) -> Engine | None:
    """Return the engine of a backend, None for the processor; InputError where this machine has no card for it."""
    check(backend)
    if backend == LANES:
        return None
    from plant.backends.cuda_card import missing

    why = missing()
    if why is not None:
        raise InputError(f"given '{backend}', and {why}; leave the option out to fly on the processor", key=KEY)
    from objectives.cuda_engine import CudaEngine

    return CudaEngine(system, root, PRECISIONS[backend])


def recorded_engine(results: Path, system: FlownSystem, root: int, cluster: Engine | None = None) -> Engine | None:
    """Return the engine of a results folder: None for this machine's own; cluster: one for lanes.

    Raises StoreError where this machine lacks it: another arithmetic would mix bits.
    """
    recorded = read_record(results).arithmetic
    if recorded == LANES:
        return cluster
    if recorded == system.arithmetic:
        return None
    if cluster is not None:
        raise StoreError(f"{results} was flown by {recorded}; the workers of a cluster fly lanes, so leave --dask out")
    backend = next((name for name, precision in PRECISIONS.items() if recorded.startswith(f"cuda-{precision},")), None)
    engine = None
    with suppress(InputError):
        engine = None if backend is None else engine_named(backend, system, root)
    if engine is None or engine.arithmetic != recorded:
        available = "there is none here" if engine is None else f"here it is {engine.arithmetic}"
        raise StoreError(
            f"{results} was flown by {recorded}, and {available}; go on where it was flown, or run its study again"
        )
    return engine


def check(backend: str) -> None:
    """Raise UnknownNameError where no backend has this name."""
    check_name("backend", backend, BACKENDS, key=KEY)
