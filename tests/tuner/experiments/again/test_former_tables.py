"""Results folders of earlier versions, whose tables are Parquet files: read, verified, gone on with, and reused."""

import shutil

import numpy as np
import pandas as pd
import pytest

from plant.errors import MissingPackageError
from plant.results_folder import is_results_folder
from tests.tables import as_an_earlier_version_wrote_it
from tests.tuner.conftest import run_small
from tests.tuner.experiments.again.killing import compare, result_of
from tuner.api.results import TuningResults
from tuner.experiments.again.resume import reopen
from tuner.experiments.again.verify import verify
from tuner.experiments.tuning.run import TuningRun
from tuner.search.watcher import Watcher
from tuner.store.inputs import read_record
from tuner.store.manifest import first_damage

pytestmark = pytest.mark.usefixtures("no_pictures")


@pytest.fixture
def former(small_run, tmp_path):
    """A copy of the small run as the version before wrote it."""
    shutil.copytree(small_run[1], tmp_path / "former")
    as_an_earlier_version_wrote_it(tmp_path / "former")
    assert not list((tmp_path / "former").rglob("*.npz")) and read_record(tmp_path / "former").version == 4
    return tmp_path / "former"


def test_its_frames_and_documents_are_those_of_today(small_run, former):
    now, then = TuningResults(small_run[1]), TuningResults(former)
    for name in ("candidates", "margins", "responses", "front"):
        pd.testing.assert_frame_equal(getattr(now, name), getattr(then, name))
    np.testing.assert_array_equal(now.evaluated.values, then.evaluated.values)
    assert [loop.values for loop in now.loops] == [loop.values for loop in then.loops]
    for one, other in zip(now.fans, then.fans, strict=True):
        np.testing.assert_array_equal(one.median, other.median)
        assert (one.point, one.scenario, one.signal, one.flight) == (
            other.point,
            other.scenario,
            other.signal,
            other.flight,
        )


def test_it_is_verified(former):
    found = verify(former, 3, 2, Watcher())
    assert found.identical and found.flown == 3


def test_its_flights_are_not_made_again(small_run, former, tmp_path):
    assert is_results_folder(former)
    for name in ("run.json", "manifest.json", "resolved.json", "environment.json", "summary.json"):
        (former / name).unlink()
    assert is_results_folder(former)
    outcome = run_small(tmp_path / "again", reuse=(former,))
    assert outcome.problem.flights_made == 0
    compare(result_of(tmp_path / "again"), result_of(small_run[1]))


def test_it_is_gone_on_with_and_its_tables_are_written_anew(small_run, former):
    next((former / "flights").glob("search-0002-*")).unlink()
    (former / "generations" / "0002.parquet").unlink()
    study, folder = reopen(former, None)
    outcome = TuningRun(study, folder, Watcher(), threads=2).carry_out()
    assert 0 < outcome.problem.flights_made < small_run[0].problem.flights_made
    tables = [path for path in former.rglob("*.parquet") if path.parent.name != "flights"]
    assert tables == [] and len(list((former / "generations").iterdir())) == len(outcome.generations)
    assert first_damage(former) is None
    pd.testing.assert_frame_equal(TuningResults(former).candidates, TuningResults(small_run[1]).candidates)
    assert verify(former, 3, 2, Watcher()).identical


def test_without_pyarrow_it_says_what_to_install(former, monkeypatch):
    monkeypatch.setattr("plant.errors.find_spec", lambda name: None)
    for ask in (
        lambda: TuningResults(former).candidates,
        lambda: TuningResults(former).fans,
        lambda: verify(former, 1, 1, Watcher()),
    ):
        with pytest.raises(MissingPackageError, match="needs the package pyarrow; install it with: pip install "):
            ask()
