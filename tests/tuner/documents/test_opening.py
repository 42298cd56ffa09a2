"""A results folder of any kind opens by one function."""

import pytest

from plant.errors import StoreError
from tests.tuner.documents.examples import example_of
from tests.tuner.report.fabricate import fabricate
from tuner.documents.opening import KINDS, TuningFolder, open_results
from tuner.store.document import json_text


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.kind)
def test_each_kind_is_told_by_its_document(kind, tmp_path):
    (tmp_path / kind.main).write_text(json_text(example_of(kind.model)), encoding="utf-8")
    opened = open_results(tmp_path)
    assert type(opened) is kind and isinstance(opened.document, kind.model)
    with pytest.raises(StoreError, match="environment.json: there is no such file"):
        _ = opened.environment


def test_documents_and_tables_of_a_run(tmp_path):
    folder = fabricate(tmp_path / "made-up")
    opened = open_results(folder)
    assert isinstance(opened, TuningFolder) and opened.document.shown == opened.tuned == "p0101"
    assert opened.environment.threads == 4 and opened.study_text.startswith("title")
    assert {"front.csv", "history.csv", "responses.npz"} <= set(opened.tables)
    assert len(opened.table("front.csv")) == len(opened.held_out_front.points)
    assert "median" in opened.table("responses.npz")
    with pytest.raises(StoreError, match="nothing.csv: there is no such file"):
        opened.table("nothing.csv")
    (folder / "front.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(StoreError, match="front.csv: not a readable table"):
        opened.table("front.csv")


def test_what_is_no_results_folder_is_refused(tmp_path):
    with pytest.raises(StoreError, match="there is no such results folder"):
        open_results(tmp_path / "nowhere")
    with pytest.raises(
        StoreError, match="holds none of comparison.json, summary.json, margins.json, export.json, contest.json"
    ):
        open_results(tmp_path)
    (tmp_path / "summary.json").write_text('{"title": 3}')
    with pytest.raises(StoreError, match=r"summary.json: 'title' is 3 and not a text"):
        open_results(tmp_path)
