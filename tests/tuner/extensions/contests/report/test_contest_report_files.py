"""Missing and damaged files of a contest folder are named; nothing is guessed."""

import json

import numpy as np
import pytest

from plant.errors import StoreError
from tests.tables import read_frame, write_frame
from tests.tuner.extensions.contests.report.fabricate_contest import fabricate, rewrite
from tuner.cli.read import report as report_command
from tuner.documents.opening import open_results
from tuner.extensions.contests.run import write_contest_report


@pytest.mark.parametrize("name", ["contest.json", "environment.json", "study.toml"])
def test_missing_file(made, name):
    (made / name).unlink()
    with pytest.raises(StoreError, match=f"{name}: there is no such file"):
        write_contest_report(made)
    assert not (made / "report.html").exists()


def test_missing_folder(tmp_path):
    with pytest.raises(StoreError, match="no such results folder"):
        write_contest_report(tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("contest.json", "not JSON"),
        ("environment.json", "not JSON"),
        ("fronts.csv", "no rows"),
        ("scores.npz", "not a readable table"),
        ("responses.npz", "not a readable table"),
        ("traces.npz", "not a readable table"),
        ("wind.npz", "not a readable table"),
    ],
)
def test_damaged_file(made, name, complaint):
    (made / name).write_bytes(b"no longer what it was")
    with pytest.raises(StoreError, match=complaint) as caught:
        write_contest_report(made)
    assert name in str(caught.value)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("title", 3),
        ("wall_seconds", None),
        ("words", ["fine", 7]),
        ("compared_on.0.flights", "many"),
        ("contenders.1.laws.attitude", None),
        ("contenders.0.gains.roll.kp.value", True),
        ("quantities.0.unit", 1),
        ("estimates.2.low", "0.3"),
        ("differences.0.difference", "less"),
        ("fronts.reference", {}),
        ("best_under.0.limit", None),
        ("published.0.percentile", "high"),
        ("claims.0.rows", {}),
    ],
)
def test_wrong_value_is_located(made, path, value):
    def spoil(content):
        node, parts = content, path.split(".")
        if "gains" in parts:
            at = parts.index("gains") + 1
            parts[at : at + 2] = [".".join(parts[at : at + 2])]
        for part in parts[:-1]:
            node = node[int(part)] if isinstance(node, list) else node[part]
        node[parts[-1]] = value

    rewrite(made, spoil)
    with pytest.raises(StoreError) as caught:
        open_results(made)
    assert "contest.json" in str(caught.value)


@pytest.mark.parametrize("key", ["contenders", "quantities", "estimates", "published", "compared_on", "best_under"])
def test_missing_key_is_named(made, key):
    rewrite(made, lambda content: content.pop(key))
    with pytest.raises(StoreError, match=f"the key '{key}' is missing"):
        open_results(made)


def test_number_that_is_none_is_refused(made):
    table = read_frame(made / "scores.npz")
    table.loc[3, "value"] = np.nan
    write_frame(made / "scores.npz", table)
    with pytest.raises(StoreError, match=r"scores.npz: the column 'value' holds something"):
        _ = open_results(made).scores


def test_column_that_is_not_there_is_named(made):
    fronts = (made / "fronts.csv").read_text().replace("value:mean(travel)", "value:mean(effort)")
    (made / "fronts.csv").write_text(fronts)
    with pytest.raises(StoreError, match=r"fronts.csv: the column 'value:mean\(travel\)' is missing"):
        _ = open_results(made).front_points


def test_rows_need_not_be_neighbours(made):
    before = open_results(made)
    for name in ("traces", "responses", "scores", "wind"):
        table = read_frame(made / f"{name}.npz")
        key = "flight" if name == "scores" else "time"
        write_frame(made / f"{name}.npz", table.sort_values(key, kind="stable"))
    after = open_results(made)
    for kind in ("traces", "fans", "scores", "air"):
        assert len(getattr(after, kind)) == len(getattr(before, kind)) > 0
        for ours, again in zip(getattr(before, kind), getattr(after, kind), strict=True):
            assert str(ours) == str(again)


def test_scores_of_all_scenarios_count_together(made):
    found = {(entry.contender, entry.quantity): entry.values for entry in open_results(made).scores}
    both, one = found["PID", "mean(travel)"], found["PID", "mean(peak.roll)@level"]
    assert (len(both), len(one)) == (64, 24) and np.all(np.diff(both) >= 0.0)


def test_the_command_draws_a_contest_again(tmp_path, capsys):
    made = fabricate(tmp_path / "made-up", without=("traces.npz", "responses.npz", "wind.npz"))
    report_command(made)
    assert capsys.readouterr().out.strip().endswith("report.html")
    assert (made / "report.html").exists() and (made / "figures" / "front.png").stat().st_size > 5000


def test_a_half_written_folder_is_no_contest(tmp_path):
    (tmp_path / "environment.json").write_text(json.dumps({}))
    with pytest.raises(StoreError, match="no finished results folder"):
        report_command(tmp_path)
