"""The end of a tuning run: the verdict first, few lines, plain words, and a sign behind every violated limit."""

import json
import shutil
from typing import Any

import pytest

from tests.tuner.report.fabricate import fabricate
from tuner.api.results import TuningResults
from tuner.api.run_report import report_run
from tuner.cli.printers.run_end import clear_text, limits_table
from tuner.cli.printers.run_report import print_run_report
from tuner.cli.printers.tuning import print_tuning
from tuner.cli.terminal import Console
from tuner.documents.summary import RequiredRow
from tuner.experiments.planning.study_preview import DefaultRow
from tuner.report.labels import plain_label, plain_margin, plain_metric
from tuner.report.verdict_text import beside_limit, verdict_text
from tuner.text.numbers import significant

MAX_LINES = 35


def printed(results, capsys, width=80):
    print_tuning(results, Console(width=width))
    return capsys.readouterr().out


def with_table(folder, target, change):
    """Return the results of a copy of a folder whose rows of the table are changed."""
    shutil.copytree(folder, target)
    summary: dict[str, Any] = json.loads((target / "summary.json").read_text())
    for row in summary["table"]:
        change(row)
    (target / "summary.json").write_text(json.dumps(summary))
    return TuningResults(target)


def is_objective(row, number):
    return row["kind"] == "objective" and row["label"].startswith(("cvar", "mean")[number])


def test_the_answer_comes_first_and_fits_a_screen(small_run, capsys):
    results = TuningResults(small_run[1])
    lines = printed(results, capsys).splitlines()
    assert lines[0].startswith(f"The tuned gains ({results.document.shown})" if results.feasible else "Nothing")
    assert len(lines) <= MAX_LINES + len(results.warnings) * 3
    assert max(map(len, lines[:-1])) <= 80
    text = "\n".join(lines)
    for words in ("confirmation flights", "position error (ITAE)", "rotor travel [1/s]", "Gains ", "Results in"):
        assert words in text
    assert "cvar" not in text.split("Why")[0]


def test_the_values_that_unseen_losses_could_raise_stand_below_the_objectives(small_run, capsys):
    results = TuningResults(small_run[1])
    unseen = results.document.unseen
    assert unseen is not None, "the small run lost a flight, of which this test has nothing to show"
    text = " ".join(printed(results, capsys).split())
    assert f"Unseen losses ({unseen.count.words}) could raise position error" in text
    for row in unseen.objectives:
        assert f" to {significant(row.raised, 3)}" in text
    assert text.index("change, 95 % interval") < text.index("Unseen losses") < text.index(" range")


def test_what_the_end_leaves_out_is_in_show(small_run, capsys):
    results = TuningResults(small_run[1])
    print_run_report(report_run(small_run[1]), Console(width=200))
    text = " ".join(capsys.readouterr().out.split()).replace(" @", "@")
    assert results.document.search in text and verdict_text(results) in text
    for row in results.document.table:
        assert row.label.split("@")[0] in text


@pytest.mark.parametrize(
    ("verdicts", "sentence"),
    [
        (("better", "better"), "better than the default in both objectives"),
        (("better", "worse"), "better than the default in position error (ITAE), worst"),
        (("no practical difference", "worse"), "without practical difference in position error"),
        (("not distinguishable", "worse"), "not distinguishable in position error"),
        # A word of earlier versions.
        (("no clear difference", "worse"), "not distinguishable in position error"),
    ],
)
def test_the_verdict_names_each_objective_once(small_run, tmp_path, verdicts, sentence):
    def change(row):
        for number, word in enumerate(verdicts):
            if is_objective(row, number):
                row["verdict"] = word

    text = verdict_text(with_table(small_run[1], tmp_path / "copy", change))
    assert sentence in text and text.count("the default in") == 1
    if verdicts[1] == "worse":
        assert "worse in rotor travel" in text or "worse than the default in rotor" in text


def test_violated_limits_are_counted_and_marked(small_run, tmp_path, capsys):
    def change(row):
        if row["label"] == "mean(saturation)":
            row |= {"verdict": "broken", "limit": 1e-9, "tuned": {"value": 0.5, "low": 0.4, "high": 0.6}}

    results = with_table(small_run[1], tmp_path / "copy", change)
    assert "violate 1 of" in (text := verdict_text(results)) and "saturation" in text
    (line,) = [line for line in printed(results, capsys).splitlines() if line.startswith("saturation")]
    assert "0.50 !" in line and "max 1e-09" in line.replace("× 10⁻⁹", "e-09") or "!" in line


def margin(value, limit=35.0):
    none = {"value": None, "low": None, "high": None}
    entry = {"value": value, "low": None, "high": None}
    row = {
        "label": "phase_margin",
        "quantity": "",
        "unit": "deg",
        "kind": "requirement",
        "limit": limit,
        "sense": "min",
    }
    return RequiredRow.model_validate(
        row | {"default": entry, "tuned": entry, "difference": none, "verdict": "kept" if value >= limit else "broken"}
    )


@pytest.mark.parametrize(("value", "text"), [(34.999, "34.999 !"), (35.04, "35"), (8.123, "8.12 !")])
def test_no_rounding_moves_a_value_over_its_limit(small_run, value, text):
    table = limits_table(TuningResults(small_run[1]), [margin(value)])
    assert str(next(iter(table.columns[1].cells))) == text


def test_a_limit_that_both_satisfy_has_its_value(small_run, tmp_path):
    row = {"default": {"value": 0.02, "low": 0.01, "high": 0.03}, "tuned": {"value": 0.1, "low": 0.09, "high": 0.11}}

    def change(entry):
        if entry["label"] == "mean(saturation)":
            entry |= {**row, "limit": 0.5, "verdict": "kept", "unit": "rad"}

    results = with_table(small_run[1], tmp_path / "copy", change)
    (clear,) = [entry for entry in results.document.compared if entry.label == "mean(saturation)"]
    # Angles are in degrees, as on the page: 0.1 rad of at most 0.5 rad.
    assert clear_text(results, [clear]) == "Satisfied by both: saturation 5.7 ° (max 28.6479)."
    assert clear_text(results, [margin(41.25)]) == "Satisfied by both: phase margin 41.2 deg (min 35)."


def test_objectives_are_in_degrees_in_both_tables(small_run, tmp_path, capsys):
    def change(entry):
        if is_objective(entry, 0):
            entry |= {"unit": "rad", "default": {"value": 0.1, "low": 0.09, "high": 0.11}}

    text = printed(with_table(small_run[1], tmp_path / "copy", change), capsys, width=200)
    (line,) = [line for line in text.splitlines() if line.startswith("position error (ITAE), worst 20 % [°]")]
    assert " 5.7 " in line


def test_named_points_are_left_out_where_the_recommended_one_is_all_there_is(small_run, tmp_path, capsys):
    heading = "Points of the front"
    assert heading in printed(TuningResults(small_run[1]), capsys)
    results = with_table(small_run[1], tmp_path / "copy", lambda _: None)
    alone = [entry.model_copy(update={"recommended": True}) for entry in results.document.points[:1]]
    results.document = results.document.model_copy(update={"points": alone})
    assert heading not in printed(results, capsys)


def test_labels_come_from_the_registries_and_fall_back_to_names():
    assert plain_label("cvar80(itae.position)", "itae.position") == "position error (ITAE), mean of the worst 20 %"
    assert plain_label("cvar80(itae.position)", "itae.position", short=True) == "position error (ITAE), worst 20 %"
    assert plain_label("mean(travel)", "travel", channels=()) == "command travel"
    assert plain_label("quantile50(rms.yaw)@calm", "rms.yaw", "calm") == "yaw RMS error, median, calm"
    assert plain_metric("command_peak", channels=()) == "largest command"
    assert plain_metric("mine.roll") == "mine.roll"
    assert plain_margin("phase_margin(attitude)") == "phase margin of attitude"
    assert plain_margin("slope(roll)") == "slope(roll)"


def test_runs_with_many_objectives_and_scenarios_end_alike(tmp_path, capsys):
    folder = fabricate(tmp_path / "made-up", 5, ("gusts", "calm air"))
    text = printed(TuningResults(folder), capsys)
    assert "in " in text.splitlines()[0] and "Why " in text


@pytest.mark.parametrize(
    ("value", "limit", "sense", "text"),
    [
        (34.96, 35.0, "min", "34.96"),
        (34.999_999_7, 35.0, "min", "34.9999997"),
        (35.04, 35.0, "min", "35"),
        (2.001, 2.0, "max", "2.001"),
        (1.999, 2.0, "max", "2"),
        (1.234_56, 2.0, "max", "1.23"),
    ],
)
def test_a_value_beyond_its_limit_never_reads_as_the_limit(value, limit, sense, text):
    row = DefaultRow(
        label="phase margin", loop="roll", value=value, unit="", sense=sense, limit=limit, hard=True, kept=False
    )
    assert beside_limit(value, row) == text
