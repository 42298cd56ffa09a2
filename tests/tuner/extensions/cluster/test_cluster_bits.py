"""Four worker processes give the bits of none, whatever the blocks, the number of workers, and whoever is killed on the way."""

import os
import signal
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import tuner.report
from plant.backends.lane_layout import LANES
from tests.tuner.conftest import NoDrawing
from tests.tuner.experiments.again.killing import compare, result_of
from tests.tuner.extensions.cluster.clusters import problem_with, small_study, some_batch, some_gains
from tuner.experiments.again.resume import reopen
from tuner.experiments.tuning.run import TuningRun
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder

pytest.importorskip("distributed", reason="flies on a Dask cluster: pip install distributed")

from dask.config import set as configured  # noqa: E402
from distributed import Client, LocalCluster  # noqa: E402
from distributed.utils import get_mp_context  # noqa: E402

from tuner.extensions.cluster.connect import quiet, refuse_unlike  # noqa: E402
from tuner.extensions.cluster.engine import DaskEngine, Part  # noqa: E402


@pytest.fixture(scope="module")
def cluster():
    # Processes are forks of one that has imported what they need: with those that follow on the killed ones there are a dozen.
    forks = configured({"distributed.worker.multiprocessing-method": "forkserver"})
    get_mp_context().set_forkserver_preload(["distributed", "tuner.extensions.cluster.worker"])
    with (
        forks,
        quiet(),
        LocalCluster(n_workers=4, threads_per_worker=1, dashboard_address=":0", silence_logs=60) as here,
        Client(here) as client,
    ):
        client.wait_for_workers(4, timeout=120)
        yield here, client


@pytest.fixture(autouse=True)
def without_pictures(monkeypatch):
    """Pictures and page take most of the time of a short run, and other tests look at them."""
    monkeypatch.setattr(tuner.report, "write_report", lambda *_: None)
    monkeypatch.setattr(tuner.report, "start_figures", lambda folder: NoDrawing())


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """What the study leaves behind without a cluster."""
    folder = tmp_path_factory.mktemp("alone") / "r"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tuner.report, "write_report", lambda *_: None)
        patch.setattr(tuner.report, "start_figures", lambda folder: NoDrawing())
        TuningRun(small_study(search__generations=3), Folder.create(folder), Watcher(), threads=2).carry_out()
    return result_of(folder)


class Killer(Watcher):
    """Kills the worker that has most to do whenever so many flights have landed."""

    def __init__(self, client, instants):
        self._client, self._instants = client, list(instants)
        self.flights, self.killed = 0, 0

    def on_flights_done(self, flights):
        self.flights += flights
        if self._instants and self.flights >= self._instants[0]:
            self._instants.pop(0)
            busy = {address: len(tasks) for address, tasks in self._client.processing().items()}
            worker = max(busy, key=lambda address: busy[address])
            pid = self._client.run(os.getpid, workers=[worker])[worker]
            os.kill(pid, signal.SIGKILL)
            self.killed += 1


def fly_on(client, folder, watcher, block=256, generations=3):
    study = small_study(search__generations=generations)
    engine = DaskEngine(client, study.system, study.seed, block)
    return TuningRun(study, Folder.create(folder), watcher, engine, threads=2).carry_out()


class Counter(Watcher):
    def __init__(self):
        self.flights = 0
        self.asked = 0

    def on_stage(self, stage, flights):
        self.asked += flights

    def on_flights_done(self, flights):
        self.flights += flights


@pytest.mark.slow
def test_four_workers_leave_what_none_leave(cluster, alone, tmp_path):
    _, client = cluster
    refuse_unlike(client)
    watcher = Counter()
    fly_on(client, tmp_path / "r", watcher)
    compare(result_of(tmp_path / "r"), alone)
    # The bar of the progress display comes to its end.
    assert watcher.flights == watcher.asked


@pytest.mark.slow
def test_killed_workers_cost_time_only(cluster, alone, tmp_path):
    """Kills in the first generation, in a later one and in the held-out check, with blocks of one candidate."""
    _, client = cluster
    watcher = Killer(client, [8, 40, 150])
    fly_on(client, tmp_path / "r", watcher, block=1)
    assert watcher.killed == 3
    compare(result_of(tmp_path / "r"), alone)


@pytest.mark.slow
def test_begun_on_a_cluster_and_resumed_without_and_the_other_way_round(cluster, alone, tmp_path):
    _, client = cluster
    fly_on(client, tmp_path / "there", Watcher(), generations=1)
    study, folder = reopen(tmp_path / "there", 3)
    TuningRun(study, folder, Watcher(), threads=2).carry_out()
    begun = small_study(search__generations=1)
    TuningRun(begun, Folder.create(tmp_path / "here"), Watcher(), threads=2).carry_out()
    study, folder = reopen(tmp_path / "here", 3)
    outcome = TuningRun(study, folder, Watcher(), DaskEngine(client, study.system, study.seed), threads=2).carry_out()
    # The first generation and its held-out check were there.
    assert 0 < outcome.problem.flights_made < outcome.flights
    search = {name: content for name, content in alone.items() if name.startswith(("flights/search", "generations/"))}
    assert len(search) == 6
    for path in (tmp_path / "there", tmp_path / "here"):
        left = result_of(path)
        compare({name: left[name] for name in search}, search)
        compare({"front.csv": left["front.csv"]}, {"front.csv": alone["front.csv"]})


def test_blocks_and_number_of_workers_do_not_matter(cluster):
    """Last of all, because workers leave."""
    here, client = cluster
    study = small_study()
    gains, batch = some_gains(study, 23), some_batch(study, 6)
    expected = problem_with(study).results(gains, batch, 0, 6)
    assert len(np.unique(expected[..., 0])) > 100, "flights that are all different"
    many = some_batch(study, 40)
    flown = problem_with(study).results(gains[:2], many, 3, 40)
    for workers, blocks in ((4, (1, 18, 10_000)), (2, (12, 10_000)), (1, (6, 256))):
        here.scale(workers)
        while len(client.nthreads()) > workers:
            pass
        for block in blocks:
            engine = DaskEngine(client, study.system, study.seed, block)
            assert engine.ready(batch)
            assert np.array_equal(engine.fly(gains, batch, 0, 6), expected)
            assert np.array_equal(engine.fly(gains[:1], batch, 2, 5), expected[:1, 2:5])
            # Two candidates are fewer than the threads, so their flights are split.
            assert np.array_equal(engine.fly(gains[:2], many, 3, 40), flown)


@pytest.mark.parametrize(("candidates", "flights"), [(1, 256), (2, 37), (16, 4), (31, 64), (500, 8)])
@pytest.mark.parametrize("threads", [1, 4, 64])
def test_blocks_cover_every_flight_once_and_reach_as_many_threads_as_they_can(candidates, flights, threads):
    client: Any = SimpleNamespace(nthreads=lambda: {"w": threads})
    study = small_study()
    engine = DaskEngine(client, study.system, study.seed)
    part, gains = Part(np.zeros((candidates, flights, 1)), 0), np.zeros((candidates, 3))
    blocks = engine._blocks(part, gains, flights)
    for block in blocks:
        part.out[block.rows, block.flights] += 1.0
        assert len(block.gains) == len(gains[block.rows]) and block.size <= 256
    assert (part.out == 1.0).all() and part.missing == len(blocks)
    assert len(blocks) >= min(threads, candidates * max(flights // LANES, 1))
