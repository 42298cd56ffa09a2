"""Missing and damaged files are named; nothing is guessed."""

import json

import pytest

from plant.errors import StoreError
from tests.tables import read_frame, write_frame
from tests.tuner.report.fabricate import fabricate
from tuner.documents.tuning import TuningFolder
from tuner.report import write_report


@pytest.fixture
def made(tmp_path):
    return fabricate(tmp_path / "made-up")


NEEDED = ("summary.json", "resolved.json", "environment.json", "gains.json", "front.csv", "history.csv", "study.toml")


@pytest.mark.parametrize("name", NEEDED)
def test_missing_file(made, name):
    (made / name).unlink()
    with pytest.raises(StoreError, match=f"{name}: there is no such file"):
        write_report(made)
    assert not (made / "report.html").exists()


def test_missing_folder_and_generations(made, tmp_path):
    with pytest.raises(StoreError, match="no such results folder"):
        write_report(tmp_path / "nowhere")
    for file in (made / "generations").iterdir():
        file.unlink()
    with pytest.raises(StoreError, match="generations: there is no generation"):
        write_report(made)


@pytest.mark.parametrize(
    ("name", "content", "complaint"),
    [
        ("summary.json", '{"title": ', "not JSON, .* in line 1"),
        ("summary.json", "[1, 2]", "and not an object"),
        ("summary.json", "{}", "the key 'title' is missing"),
        ("gains.json", '{"gains": {"roll.kp": {"value": "big", "unit": "1"}}}', "'gains.roll.kp.value' is 'big'"),
        ("gains.json", '{"gains": {"roll.kp": {"value": true, "unit": "1"}}}', "not a finite number"),
        ("history.csv", "generation,flights\n", "no rows"),
        ("history.csv", "generation,flights\n1,2,3\n", "row 1 has 3 cells and the header 2"),
        ("history.csv", "generation,flights\n1,many\n", "'flights' holds no number"),
        ("history.csv", "generation,flights\n1,2\n", "the column 'seconds' is missing"),
        ("responses.npz", "PAR1 not at all", "not a readable table"),
        ("generations/0003.npz", "", "not a readable table"),
        ("study.toml", b"\xff\xfe\xfa", "cannot be read"),
    ],
)
def test_damaged_file(made, name, content, complaint):
    raw = content if isinstance(content, bytes) else content.encode()
    (made / name).write_bytes(raw)
    with pytest.raises(StoreError, match=complaint) as caught:
        write_report(made)
    assert name in str(caught.value)


@pytest.mark.parametrize(
    ("path", "value", "key"),
    [
        (("table", 0, "tuned", "value"), "0.3", "table[0].tuned.value"),
        (("table", 0, "unit"), 3, "table[0].unit"),
        (("table", 0, "kind"), "wish", "table[0].kind"),
        (("variables", 1, "low"), None, "variables[1].low"),
        (("air",), {}, "air"),
    ],
)
def test_wrong_value_in_summary_is_located(made, path, value, key):
    summary = json.loads((made / "summary.json").read_text())
    node = summary
    for step in path[:-1]:
        node = node[step]
    node[path[-1]] = value
    (made / "summary.json").write_text(json.dumps(summary))
    with pytest.raises(StoreError) as caught:
        TuningFolder(made)
    assert "summary.json" in str(caught.value) and f"'{key}'" in str(caught.value)


def test_front_without_an_objective_of_the_summary(made):
    front = (made / "front.csv").read_text().replace("held_out:mean(travel)", "held_out:mean(effort)")
    (made / "front.csv").write_text(front)
    with pytest.raises(StoreError, match=r"front.csv: the column 'held_out:mean\(travel\)' is missing"):
        _ = TuningFolder(made).held_out_front


def test_rows_of_a_fan_need_not_be_neighbours(made):
    import numpy as np

    before = TuningFolder(made).fans
    table = read_frame(made / "responses.npz")
    # Instant by instant: fans are torn apart, but time still ascends.
    write_frame(made / "responses.npz", table.sort_values("time", kind="stable"))
    after = {(fan.point, fan.signal): fan for fan in TuningFolder(made).fans}
    assert len(after) == len(before)
    for fan in before:
        again = after[fan.point, fan.signal]
        assert np.all(np.diff(again.time) > 0.0)
        assert np.array_equal(fan.time, again.time) and np.array_equal(fan.high, again.high)
