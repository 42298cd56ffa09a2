"""Engines of flights by name, of core and extensions; each has bits of its own, so none stands in for another."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from typing import NamedTuple

from objectives.engine import LANES, Engine
from objectives.flown_system import FlownSystem
from plant.errors import InputError, StoreError, check_name
from tuner.extension import added, load, refuse_lacking
from tuner.store.inputs import read_record
from tuner.study.tuning_study import TuningStudy

KEY = "--backend"
CLUSTER = "dask"


class Backend(NamedTuple):
    """Backend that flies on another device than the processor.

    Attributes:
        arithmetic: Beginning of its engine's arithmetic, which no other backend has.
        missing: Returns the words for what this machine lacks, None where it can fly.
        engine: Returns the engine of a system and a root seed.
    """

    arithmetic: str
    missing: Callable[[], str | None]
    engine: Callable[[FlownSystem, int], Engine]


def cluster_engine(
    where: str | None, study: TuningStudy, threads: int | None, say: Callable[[str], None]
) -> AbstractContextManager[Engine | None]:
    """Connect to the cluster of --dask; yield its engine, None without the option.

    Args:
        where: Value of the option.
        study: Study that flies there.
        threads: Threads of local processes together.
        say: Called with a line about the cluster.

    Raises InputError where no extension connects to one.
    """
    if where is None:
        return nullcontext()
    reference = added("clusters").get(CLUSTER)
    if reference is None:
        raise InputError(
            "no installed extension connects to a cluster; install one, such as cluster of gainproof, or leave the option out to "
            "fly on this machine",
            key=f"--{CLUSTER}",
        )
    return load(reference)(where, study, threads, say)


def engine_named(backend: str, system: FlownSystem, root: int) -> Engine | None:
    """Return the engine of a backend, None for the processor; InputError where this machine lacks it."""
    check(backend)
    if backend == LANES:
        return None
    chosen: Backend = load(added("backends")[backend])
    why = chosen.missing()
    if why is not None:
        raise InputError(f"given '{backend}', and {why}; leave the option out to fly on the processor", key=KEY)
    return chosen.engine(system, root)


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
    backends: dict[str, Backend] = {name: load(reference) for name, reference in added("backends").items()}
    backend = next((name for name, entry in backends.items() if recorded.startswith(entry.arithmetic)), None)
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
    refuse_lacking("backends", backend, key=KEY)
    check_name("backend", backend, (LANES, *added("backends")), key=KEY)
