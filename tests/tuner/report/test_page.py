"""The report of a real run: offline, complete, escaped, and clear about what is missing."""

import json
import re
import shutil

import pytest

from plant.errors import StoreError
from tests.tuner.conftest import run_small
from tests.undrawn import undrawn
from tuner.documents.tuning import TuningFolder
from tuner.documents.verdicts import shown_verdict
from tuner.report import write_figures, write_report
from tuner.report.labels import in_plain_words, names_of
from tuner.text.markup import coded

EXTRA = [{"metric": "itae.position"}, {"metric": "travel"}, {"metric": "peak.tilt"}, {"metric": "effort"}]


@pytest.fixture
def copied(small_run, tmp_path):
    _, folder = small_run
    return shutil.copytree(folder, tmp_path / "copy")


def own_markup(page):
    """The page without its library, whose text mentions addresses that it never asks for."""
    return re.sub(r"(<script[^>]*>).*?</script>", r"\1</script>", page, flags=re.S)


def page_data(page):
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    assert found is not None
    return json.loads(found[1])


def test_nothing_is_fetched(copied):
    page = write_report(copied).read_text()
    assert not re.search(r"<(?:script|link|img|iframe)[^>]*(?:src|href)=", own_markup(page))
    assert not re.search(r"url\(|@import", own_markup(page))


def test_every_quantity_gain_and_warning_is_told(copied):
    page = write_report(copied).read_text()
    summary = json.loads((copied / "summary.json").read_text())
    for row in summary["table"]:
        assert row["label"] in page
        assert shown_verdict(row["verdict"]) in page
    for variable in summary["variables"]:
        assert variable["name"] in page
    plain = names_of(TuningFolder(copied))
    for warning in summary["warnings"]:
        assert coded(in_plain_words(warning, plain)) in page
    assert summary["tuned"] in page
    assert json.loads((copied / "resolved.json").read_text())["digest"] in page


def test_how_the_point_was_chosen_is_told_where_the_folder_holds_it(copied):
    summary = json.loads((copied / "summary.json").read_text())
    summary["remarks"] = ["Without it the front reaches <more>."]
    (copied / "summary.json").write_text(json.dumps(summary))
    page = own_markup(write_report(copied).read_text())
    assert "Selection of the point" in page and "Held-out − search" in page and "reaches &lt;more&gt;." in page
    del summary["picked_on"]
    (copied / "summary.json").write_text(json.dumps(summary))
    assert "Selection of the point" not in own_markup(write_report(copied).read_text())


def test_points_carry_the_held_out_values(copied, small_run):
    outcome, _ = small_run
    points = page_data(write_report(copied).read_text())["points"]
    assert [point["name"] for point in points] == outcome.names
    assert [point["held_out"] for point in points] == outcome.finalists.evaluation.values.tolist()
    assert [point["role"] for point in points].index("tuned") == outcome.tuned


def test_text_of_the_user_is_escaped(copied):
    for name in ("summary.json", "study.toml"):
        file = copied / name
        file.write_text(file.read_text().replace("Quickstart:", "<script>alert(1)</script>"))
    page = write_report(copied).read_text()
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert" in page


def test_a_folder_without_responses_says_so(copied):
    (copied / "responses.npz").unlink()
    assert "no recorded responses" in write_report(copied).read_text()
    assert all("responses" not in path.name for path in write_figures(copied))


@pytest.mark.parametrize("name", ["summary.json", "front.csv", "history.csv", "generations/0001.npz", "responses.npz"])
def test_a_damaged_file_is_named(copied, name):
    (copied / name).write_bytes(b"\x00 no longer what it was")
    with pytest.raises(StoreError, match=name.split("/")[-1]):
        write_report(copied)


@pytest.mark.parametrize("count", [1, 3, 4])
def test_any_number_of_objectives(count, tmp_path):
    folder = tmp_path / "run"
    with undrawn():
        run_small(folder, objective=EXTRA[:count], search__generations=1)
    page = (folder / "report.html").read_text()
    assert len(page_data(page)["objectives"]) == count
    assert ('id="space"' in page, 'id="matrix"' in page) == (count == 3, count > 2)
    assert (folder / "figures" / "front.png").read_bytes().startswith(b"\x89PNG")
    assert (folder / "figures" / "front.pdf").read_bytes().startswith(b"%PDF")
