"""Clusters that end, and workers that would fly other bits: one clear line each, and nobody left behind."""

import os
import signal
import subprocess
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from plant.errors import InputError, StoreError
from tests.tuner.experiments.again.killing import command, run_arguments
from tests.tuner.extensions.cluster.clusters import (
    gone,
    problem_with,
    scheduler,
    session_of,
    small_study,
    some_batch,
    some_gains,
    worker,
)
from tests.tuner.in_process import tuner
from tuner.extensions.cluster.connect import required

pytest.importorskip("distributed", reason="flies on a Dask cluster: pip install distributed")

from distributed import Client  # noqa: E402

from tuner.extensions.cluster.connect import local_client, quiet, refuse_unlike, remote_client  # noqa: E402
from tuner.extensions.cluster.engine import DaskEngine  # noqa: E402
from tuner.extensions.cluster.machine import differences, machine_report  # noqa: E402
from tuner.extensions.cluster.watch import Watch  # noqa: E402


@pytest.fixture(autouse=True)
def silent():
    with quiet():
        yield


@pytest.mark.slow
def test_workers_that_are_unlike_are_refused(tmp_path):
    """A worker that has compiled for another processor, for real: before the run, and where it joins one that has begun."""

    def compile_something():
        import numba

        numba.njit(lambda x: x + 1.0)(1.0)

    with (
        scheduler(tmp_path) as (_, address),
        worker(tmp_path, address, NUMBA_CPU_NAME="x86-64", NUMBA_CPU_FEATURES=""),
        Client(address) as client,
    ):
        client.run(compile_something)
        with pytest.raises(
            InputError, match=r"--dask: these workers .*tcp://.*: this process compiles for x86-64-\S+ already"
        ):
            refuse_unlike(client)
        study = small_study()
        engine = DaskEngine(client, study.system, study.seed)
        with pytest.raises(StoreError, match="this process compiles for x86-64-"):
            engine.fly(some_gains(study, 3), some_batch(study, 2), 0, 2)


@pytest.mark.slow
def test_a_worker_told_another_processor_goes_over_to_that_of_the_run(tmp_path):
    study = small_study()
    gains, batch = some_gains(study, 3), some_batch(study, 2)
    with (
        scheduler(tmp_path) as (_, address),
        worker(tmp_path, address, NUMBA_CPU_NAME="x86-64", NUMBA_CPU_FEATURES=""),
        Client(address) as client,
    ):
        refuse_unlike(client)
        flown = DaskEngine(client, study.system, study.seed).fly(gains, batch, 0, 2)
    np.testing.assert_array_equal(flown, problem_with(study).results(gains, batch, 0, 2))


def test_every_kind_of_difference_is_named():
    ours = machine_report()
    assert set(ours) == {
        "python",
        "gainproof",
        "numpy",
        "numba",
        "llvmlite",
        "scipy",
        "sources",
        "target",
        "numpy-simd",
        "libc",
    }
    for name in ours:
        assert differences(ours, {"w": {**ours, name: "9.9"}}) == [f"w: {name} 9.9 there, {ours[name]} here"]
    assert differences(ours, {"a": ours, "b": dict(ours)}) == []
    assert len(differences(ours, {"old": {}})) == len(ours)


def test_a_worker_without_the_package_is_named(monkeypatch):
    reports = {"tcp://a:1": ModuleNotFoundError("No module named 'tuner'"), "tcp://b:2": {"python": "3.9.0"}}
    client: Any = SimpleNamespace(run=lambda *_, **__: reports)
    with pytest.raises(
        InputError, match=r"tcp://a:1: No module named 'tuner'; tcp://b:2: python 3\.9\.0 there, 3\."
    ) as told:
        refuse_unlike(client)
    assert "and 2 more" not in str(told.value) and "docs/cluster.md" in str(told.value)


@pytest.mark.slow
def test_no_worker_left_and_no_scheduler_left(tmp_path):
    study = small_study(scenario__0__duration=60.0)
    gains, batch = some_gains(study, 64), some_batch(study, 64)
    with (
        scheduler(tmp_path) as (head, address),
        worker(tmp_path, address) as (hand, _),
        Client(address, timeout=3) as client,
    ):
        engine = DaskEngine(client, study.system, study.seed, patience=1.0)

        def kill(_):
            hand.kill()

        with pytest.raises(InputError, match=r"no worker for 1 s; start workers, .* `tuner resume"):
            engine.fly(gains, batch, 0, 64, kill)
        begin = time.monotonic()
        head.kill()
        with pytest.raises(InputError, match="the scheduler does not answer any more"):
            engine.fly(gains, batch, 0, 64)
        assert time.monotonic() - begin < 30.0


@pytest.mark.slow
def test_a_scheduler_that_is_lost_is_told_in_one_line(tmp_path):
    with scheduler(tmp_path) as (head, address), worker(tmp_path, address):
        folder = tmp_path / "r"
        arguments = [*run_arguments(folder), "--set", "search.generations=500", "--dask", address]
        driver = subprocess.Popen(
            command(*arguments), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
        )
        try:
            end = time.monotonic() + 120.0
            while not list(folder.glob("generations/*.npz")):
                assert driver.poll() is None and time.monotonic() < end
                time.sleep(0.1)
            head.kill()
            said = driver.communicate(timeout=90)[1]
        finally:
            driver.kill()
            driver.wait(30)
    assert driver.returncode == 2
    assert said.startswith("Error: --dask: the scheduler does not answer any more") and said.count("\n") == 1


@pytest.mark.slow
def test_local_workers_listen_on_the_loopback_alone():
    """Whoever reaches a scheduler, a nanny or a worker can run code there; a dashboard tells what is run."""
    psutil = pytest.importorskip("psutil")
    with local_client(2, 2):
        here = psutil.Process()
        processes = [here, *here.children(recursive=True)]
        listening = [
            entry.laddr.ip
            for one in processes
            for entry in one.net_connections("inet")
            if entry.status == psutil.CONN_LISTEN
        ]
    # A scheduler, its page, and a nanny and a worker for each of two.
    assert len(listening) >= 6 and set(listening) <= {"127.0.0.1", "::1"}


def test_a_block_that_ends_every_worker_is_given_up():
    from distributed import KilledWorker

    class Future:
        def result(self, timeout):
            raise KilledWorker("fly_block-1", SimpleNamespace(address="tcp://w:1"), 3)  # pyright: ignore[reportArgumentType]

    client: Any = None
    future: Any = Future()
    with pytest.raises(
        InputError, match=r"4 workers ended while they flew the same block, the last one tcp://w:1; look"
    ):
        Watch(client).result(future)


@pytest.mark.parametrize(
    "where", ["local:", "local:0", "local:-1", "local:1e3", "local:257", "host:8786", "", "tcp:/a:1"]
)
def test_what_is_no_cluster(where):
    with pytest.raises(InputError, match="write local:N"):
        required(where)


def test_addresses():
    assert [required("local:1"), required("local:256"), required("tcp://host:8786"), required("tls://host:1")] == [
        1,
        256,
        0,
        0,
    ]


def test_nobody_answers(monkeypatch):
    monkeypatch.setattr("tuner.extensions.cluster.connect.ANSWER", 0.5)
    with pytest.raises(InputError, match="no scheduler answers at tcp://127.0.0.1:9 .*start one with `dask scheduler`"):
        with remote_client("tcp://127.0.0.1:9"):
            pass


def test_a_scheduler_without_workers(tmp_path, monkeypatch):
    monkeypatch.setattr("tuner.extensions.cluster.connect.ANSWER", 1.0)
    with scheduler(tmp_path) as (_, address):
        with pytest.raises(InputError, match=f"has no workers; start some with `dask worker {address}`"):
            with remote_client(address):
                pass


def test_without_the_package_one_line(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr("plant.errors.find_spec", lambda name: None)
    arguments = [*run_arguments(tmp_path / "r"), "--dask", "local:2"]
    code, _, said = tuner(monkeypatch, capsys, *arguments)
    assert (
        code == 2
        and said == "Error: --dask: needs the package distributed; install it with: pip install 'distributed>=2024.8'\n"
    )
    assert not (tmp_path / "r").exists()


def test_only_tuning_studies_fly_on_a_cluster(monkeypatch, capsys):
    code, _, said = tuner(monkeypatch, capsys, "run", "studies/contest.toml", "--dask", "local:2")
    assert code == 2 and "--dask: only a tuning study flies on a cluster" in said


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_nobody_is_left_behind(tmp_path, how):
    """Ctrl-C reaches every process of the terminal; a driver that is killed takes its workers along."""
    folder = tmp_path / "r"
    arguments = [*run_arguments(folder), "--set", "search.generations=500", "--dask", "local:2"]
    driver = subprocess.Popen(
        command(*arguments), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        end = time.monotonic() + 90.0
        while not list(folder.glob("generations/*.npz")):
            assert driver.poll() is None and time.monotonic() < end, driver.stderr and driver.stderr.read()
            time.sleep(0.1)
        assert len(session_of(driver.pid)) >= 3
        if how is signal.SIGINT:
            os.killpg(driver.pid, how)
            assert driver.wait(30) == 130
            assert driver.stderr is not None
            # No traceback of a worker, and one line of ours at most; asyncio may say that it dropped a coroutine.
            said = driver.stderr.read()
            assert "Traceback" not in said
            assert sum(line.startswith(("Error", "Interrupted")) for line in said.splitlines()) <= 1
        else:
            driver.send_signal(how)
            driver.wait(30)
        assert gone(driver.pid)
    finally:
        for pid in session_of(driver.pid):
            os.kill(pid, signal.SIGKILL)
        driver.wait(30)
        if driver.stderr is not None:
            driver.stderr.close()
