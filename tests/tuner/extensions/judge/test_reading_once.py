"""A second opinion reads each file once: verdict, digest and rollback are of one content."""

from hashlib import sha256

import pytest

import tuner
from plant.errors import InputError
from tests.opened_files import opened_files
from tests.tuner.exchange.reading import write
from tests.tuner.extensions.autopilots.test_sources import FILES
from tuner.extensions.judge import api, vehicle_files


@pytest.fixture
def without_flights(monkeypatch):
    """End an opinion where its flights would begin."""

    def end(*_):
        raise InputError("the flights were reached")

    monkeypatch.setattr(api, "assess", end)


@pytest.mark.parametrize("is_paired", [False, True])
@pytest.mark.parametrize("source", FILES)
def test_each_parameter_file_is_opened_once(source, is_paired, tmp_path, monkeypatch, without_flights):
    files = [write(tmp_path, FILES[source], name) for name in ("after.txt", "before.txt")[: 1 + is_paired]]
    paths = opened_files(monkeypatch)
    with pytest.raises(InputError, match="the flights were reached"):
        tuner.judge(*files)
    assert [paths.count(file) for file in files] == [1] * len(files)
    # The vehicle with the proposal is no file.
    assert not [path for path in paths if path.name == "after.txt" and path not in files]


@pytest.mark.parametrize("source", FILES)
def test_a_read_back_opens_each_file_once(source, tmp_path, monkeypatch):
    files = [write(tmp_path, FILES[source], name) for name in ("written.txt", "dump.txt")]
    paths = opened_files(monkeypatch)
    assert tuner.read_back(*files).passed
    assert [paths.count(file) for file in files] == [1, 1]


def test_the_rollback_is_the_file_that_was_judged(tmp_path, monkeypatch):
    """It is written behind the flights, in which a ground station may save the file once more."""
    after = write(tmp_path, "# Stack: PX4 Pro\n# Version: 1.9.0\n1\t1\tMC_ROLLRATE_P\t0.15\t9\n", "after.params")
    before = write(tmp_path, FILES["px4"], "before.params")
    content, judged = before.read_bytes(), api.unjudged_document

    def judge_while_it_is_saved(*given):
        before.write_text("1\t1\tMC_ROLLRATE_P\t9.0\t9\n")
        return judged(*given)

    monkeypatch.setattr(api, "unjudged_document", judge_while_it_is_saved)
    opinion = tuner.judge(after, before, out=tmp_path / "out")
    assert opinion.folder is not None and opinion.document.rollback is not None and opinion.document.before is not None
    assert (opinion.folder / opinion.document.rollback).read_bytes() == content
    assert opinion.document.before.sha256 == sha256(content).hexdigest()


def test_an_error_of_the_vehicle_with_the_proposal_names_the_proposal(tmp_path, monkeypatch, without_flights):
    monkeypatch.setattr(vehicle_files, "overlaid", lambda *_: "1\t1\tMC_ROLLRATE_P\tmany\t9\n")
    after, before = (write(tmp_path, FILES["px4"], name) for name in ("after.params", "before.params"))
    with pytest.raises(InputError, match="given 'many'") as caught:
        tuner.judge(after, before)
    assert (caught.value.file, caught.value.key) == (str(after), "MC_ROLLRATE_P")
