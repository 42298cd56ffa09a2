"""Tails on a cluster: two workers give the bytes of this machine alone."""

import pytest

import tuner
from plant.errors import InputError
from tests.tuner.extensions.tails.test_tail_run import SETTINGS, few_replicas_and_failures, files, study
from tuner.extensions.tails.estimation.estimate import LocalReplicas
from tuner.search.watcher import Watcher

pytest.importorskip("distributed", reason="flies on a Dask cluster: pip install distributed")

__all__ = ["few_replicas_and_failures", "study"]


class Counted(Watcher):
    """Counts flights."""

    flights = 0

    def on_flights_done(self, flights: int) -> None:
        self.flights += flights


@pytest.mark.slow
def test_two_workers_give_the_bytes_of_this_machine(study, tmp_path, monkeypatch):
    alone = tuner.tail(study, out=tmp_path / "one", threads=2, **SETTINGS)

    def refuse(*_):
        raise AssertionError("replicas are for the workers")

    monkeypatch.setattr(LocalReplicas, "run", refuse)
    watcher = Counted()
    flown = tuner.tail(study, out=tmp_path / "two", threads=2, dask="local:2", watcher=watcher, **SETTINGS)
    assert files(flown.folder) == files(alone.folder)
    assert watcher.flights > flown.document.gains[0].events[0].flights


def test_a_cluster_that_is_none_is_refused_before_anything_is_written(study, tmp_path):
    with pytest.raises(InputError, match="write local:N") as caught:
        tuner.tail(study, out=tmp_path / "none", dask="here", **SETTINGS)
    assert caught.value.key == "--dask"
    assert not (tmp_path / "none").exists()
