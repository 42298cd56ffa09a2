"""`--dask`: workers of this machine (`local:4`) or a scheduler's (`tcp://host:8786`), refused where they would fly other bits."""

import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING

from objectives.engine import Engine
from plant.backends.processor import compiled_for
from plant.errors import InputError, require_package
from plant.python_process import without_working_folder
from plant.threads import available_threads
from tuner.extensions.cluster.machine import Report, differences, machine_report, report_for
from tuner.extensions.cluster.own_files import KEY, OwnFile, not_here, own_files_of
from tuner.study.study import TuningStudy

if TYPE_CHECKING:
    from distributed import Client

LOCAL, ADDRESSES = "local:", ("tcp://", "tls://")
# Seconds in which a scheduler must answer and a first worker must be there; processes started on one machine; differences listed.
ANSWER, MAX_PROCESSES, MAX_DIFFERENCES = 20.0, 256, 8
# Where local:N listens: whoever reaches a scheduler can run code there.
LOOPBACK = "127.0.0.1"
Say = Callable[[str], None]


@contextmanager
def engine_at(where: str, study: TuningStudy, threads: int | None, say: Say) -> Iterator[Engine]:
    """Yield the engine of --dask; its connection and processes end with the context."""
    files = own_files_of(study.system, [entry.spec for entry in study.scenarios])
    with client_at(where, files, threads, say) as client:
        from tuner.extensions.cluster.engine import DaskEngine

        yield DaskEngine(client, study.system, study.seed)


@contextmanager
def client_at(where: str, files: Sequence[OwnFile], threads: int | None, say: Say) -> Iterator["Client"]:
    """Yield the client of --dask; its workers fly this machine's bits.

    Args:
        where: Processes of this machine, or the address of a scheduler.
        files: User files that workers need.
        threads: Threads of all local processes together.
        say: Hears of the cluster.
    """
    local = required(where)
    require_package("distributed", "dask", key=KEY)
    with quiet(), local_client(local, threads, files) if local else remote_client(where) as client:
        refuse_unlike(client)
        refuse_without(client, files)
        say(cluster_description(client, bool(local)))
        yield client


def required(where: str) -> int:
    """Return the number of processes of local:N, 0 for an address; InputError where it is neither."""
    if where.startswith(ADDRESSES):
        return 0
    number = where.removeprefix(LOCAL)
    if where.startswith(LOCAL) and number.isascii() and number.isdigit() and 1 <= int(number) <= MAX_PROCESSES:
        return int(number)
    raise InputError(
        f"given '{where}'; write local:N for N processes on this machine, 1 to {MAX_PROCESSES}, or a scheduler's address such as "
        f"tcp://host:8786",
        key=KEY,
    )


@contextmanager
def local_client(processes: int, threads: int | None, files: Sequence[OwnFile] = ()) -> Iterator["Client"]:
    """Start worker processes that share this machine's cores, or so many threads; they end with the context.

    files: of the user's own, which the user has named here and so for these processes too.
    """
    from distributed import Client, LocalCluster

    each = max((threads or available_threads()) // processes, 1)
    with (
        without_working_folder(),
        LocalCluster(
            n_workers=processes,
            threads_per_worker=each,
            host=LOOPBACK,
            dashboard_address=f"{LOOPBACK}:0",
            silence_logs=logging.CRITICAL,
            preload=["tuner.extensions.cluster.preload"],
            preload_argv=["--driven", *[part for entry in files for part in ("--code", str(entry.file.resolve()))]],
        ) as cluster,
        Client(cluster) as client,
    ):
        client.wait_for_workers(processes, timeout=5.0 * ANSWER)
        yield client


@contextmanager
def remote_client(address: str) -> Iterator["Client"]:
    """Connect to a scheduler that has workers; InputError where there is none."""
    from distributed import Client

    try:
        client = Client(address, timeout=ANSWER)
    except (OSError, ValueError) as error:
        raise InputError(
            f"no scheduler answers at {address} ({str(error).splitlines()[0]}); start one with `dask scheduler` and give the "
            f"address that it prints",
            key=KEY,
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=ANSWER)
        except TimeoutError:
            raise InputError(
                f"the scheduler at {address} has no workers; start some with `dask worker {address}`", key=KEY
            ) from None
        yield client


def refuse_unlike(client: "Client") -> None:
    """Refuse workers that would fly other bits: InputError with worker, name, theirs and ours."""
    reports: dict[str, Report | Exception] = client.run(report_for, compiled_for(), on_error="return")  # pyright: ignore[reportAssignmentType]
    broken = [f"{worker}: {error}" for worker, error in sorted(reports.items()) if isinstance(error, Exception)]
    by_worker = {worker: report for worker, report in reports.items() if not isinstance(report, Exception)}
    unlike = [*broken, *differences(machine_report(), by_worker)]
    if unlike:
        rest = "" if len(unlike) <= MAX_DIFFERENCES else f"; and {len(unlike) - MAX_DIFFERENCES} more"
        raise InputError(
            "these workers would not fly the same bits as this machine: "
            f"{'; '.join(unlike[:MAX_DIFFERENCES])}{rest}. Install the same there, see docs/cluster.md",
            key=KEY,
        )


def refuse_without(client: "Client", files: Sequence[OwnFile]) -> None:
    """Refuse workers that were not given a file of the user's own: InputError with worker, file and digest."""
    if not files:
        return
    required = [entry.digest for entry in files]
    missing: dict[str, list[str]] = client.run(not_here, required)  # pyright: ignore[reportAssignmentType]
    for worker, digests in sorted(missing.items()):
        for entry in files:
            if entry.digest in digests:
                raise InputError(f"the worker {worker} has not been given {entry.missing}", key=KEY)


def cluster_description(client: "Client", local: bool) -> str:
    """Return the numbers of workers and threads, and any dashboard's address; a local one takes bokeh."""
    workers: dict[str, int] = client.nthreads()  # pyright: ignore[reportAssignmentType]
    try:
        link = client.dashboard_link
    except KeyError:
        link = None
    board = f"; dashboard: {link}" if link and (find_spec("bokeh") or not local) else ""
    return f"Cluster of {len(workers)} workers with {sum(workers.values())} threads{board}"


@contextmanager
def quiet() -> Iterator[None]:
    """Keep the library's log from the terminal: what a person has to know comes as an error of ours.

    The library gives some of its loggers levels of their own as it is imported, so each of these is set.
    """
    import distributed  # noqa: F401

    made = [name for name in logging.root.manager.loggerDict if name.startswith("distributed.")]
    loggers = [logging.getLogger(name) for name in ("distributed", "tornado.application", "asyncio", *made)]
    before = [entry.level for entry in loggers]
    for entry in loggers:
        entry.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for entry, level in zip(loggers, before, strict=True):
            entry.setLevel(level)
