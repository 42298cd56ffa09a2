"""A run that finds nothing feasible: told first everywhere, an exit code of its own, nothing offered, the way out named."""

import contextlib
import json
import re
import shutil
import sys
from dataclasses import replace
from io import StringIO

import numpy as np
import pandas as pd
import pytest

from objectives.margins.margins import MarginModel
from plant.quadrotor.gains import gain_addresses
from tests.tables import read_frame
from tests.tuner.conftest import NoDrawing, run_small
from tests.tuner.in_process import tuner
from tests.tuner.study.study_text import STUDY, write
from tuner import report
from tuner.analysis.held_out import compare
from tuner.analysis.limit_flights import LimitFlights
from tuner.api.run_report import report_run
from tuner.cli.main import _invoke
from tuner.cli.printers.run_report import print_run_report
from tuner.cli.terminal import Console
from tuner.documents.parts import LostFlight
from tuner.documents.summary import GAINS, INFEASIBLE, NOTHING
from tuner.documents.tuning import TuningFolder
from tuner.experiments.tuning import ending
from tuner.experiments.tuning.ending import ending_of
from tuner.experiments.tuning.starts import design_row, study_designs
from tuner.report.tuning_page import tuning_page
from tuner.study.build import load_study
from tuner.text.errors import NOTHING_FEASIBLE, guarded

# Yaw keeps what the study fixes: far too fast for its observer, and nothing that is searched moves it.
FIXED = '"tilt.lambda" = { low = 1, high = 16 }\n"yaw.lambda" = 30.0\n"yaw.omega_o" = 12.0\n"yaw.k1" = 30.0'
YAW = STUDY.replace("generations = 2", "generations = 2\nracing = false").replace(
    '"tilt.lambda" = { low = 1, high = 16 }', FIXED
).replace('"roll.k1" = 20.0\n', "") + (
    '\n[[margin]]\nquantity = "phase_margin"\naxis = "attitude"\nmin = 30\nhard = true\nat = "hover"\n'
)
# More than any gains of this vehicle reach within two seconds of a step of 1 m.
SOON = '\n[[constraint]]\nmetric = "rms.position"\nmax = 0.01\n'


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Exit code, terminal, study and folder of a run whose yaw margin nothing that is searched can move."""
    folder = tmp_path_factory.mktemp("ending")
    study = write(folder, YAW)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, "start_figures", lambda _: NoDrawing())
        patch.setenv("COLUMNS", "400")
        code, out, err = run_captured(patch, "run", study, "--out", folder / "out", "--threads", "2")
    return code, out, err, study, folder / "out"


def run_captured(patch, *arguments):
    patch.setattr(sys, "argv", ["tuner", *map(str, arguments)])
    out, err = StringIO(), StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.raises(SystemExit) as ended:
        sys.exit(guarded(_invoke))
    return ended.value.code or 0, out.getvalue(), err.getvalue()


def summary_of(folder):
    return json.loads((folder / "summary.json").read_text())


def test_the_run_ends_with_its_own_code_and_says_so_before_any_table(ran):
    code, out, err, _, folder = ran
    assert (code, err) == (NOTHING_FEASIBLE, "") and NOTHING_FEASIBLE not in (0, 1, 2, 130)
    assert out.count(NOTHING) == 1
    assert "no gains are recommended" in out and "Recommended" not in out
    assert out.index(NOTHING) < out.index("Nearest to feasible") < out.index("Gains") < out.index("Results in")
    assert out.index("Automatic limit: quantile50(rms.position)@gusts") < out.index("generation 1/2")
    assert f"Results in {folder}: report.html, {INFEASIBLE} (" in out


def test_nothing_is_offered_as_gains(ran):
    _, _, _, _, folder = ran
    assert not (folder / GAINS).exists()
    document = json.loads((folder / INFEASIBLE).read_text())
    summary = summary_of(folder)
    assert document["study"]["feasible"] is False and document["study"]["point"] == summary["nearest"]
    assert list(summary)[:2] == ["feasible", "ending"] and summary["feasible"] is False and summary["tuned"] is None
    assert summary["ending"][0].startswith(NOTHING)
    front = pd.read_csv(folder / "front.csv", keep_default_na=False)
    assert front["role"].tolist() == ["default", "nearest"]


def test_the_loop_is_named_with_what_it_reaches_and_what_design_reaches(ran):
    _, out, _, study, folder = ran
    asked = load_study(study)
    model = MarginModel(asked.system.cascade, asked.system.nominal, asked.system.timing, asked.system.vehicle)
    designed = design_row(asked, study_designs(asked))

    def yaw(row):
        return float(model.evaluate(row[None]).phase.value[0, 5])

    (found,) = summary_of(folder)["obstacles"]
    assert (found["label"], found["loop"], found["unit"]) == ("phase_margin(attitude, hover)", "yaw", "rad")
    assert found["reached"] == pytest.approx(yaw(asked.default_row)) and found["reached"] < np.radians(30.0)
    assert found["moved_by"] == [] and found["tried"] == 16
    fixed = {entry["gain"]: entry["value"] for entry in found["fixed"]}
    assert fixed["yaw.lambda"] == 30.0 and fixed["yaw.k1"] == 30.0 and all(name.startswith("yaw.") for name in fixed)
    assert (
        found["design"]["kept"]
        and found["design"]["value"] == pytest.approx(yaw(designed))
        and yaw(designed) > np.radians(30.0)
    )
    own = {gain.address: designed[gain.column] for gain in gain_addresses(asked.system.cascade) if gain.axis == "yaw"}
    assert {entry["gain"]: entry["value"] for entry in found["design"]["gains"]} == own
    told = next(line for line in out.splitlines() if "in the yaw loop" in line)
    assert (
        f"{np.degrees(found['reached']):.4g} deg" in told
        and "Searched gains" not in told
        and "yaw.k1 = 30" in told
        and '"yaw.k1" = {}' in told
    )
    assert f"`tuner design` reaches {np.degrees(found['design']['value']):.4g} deg" in told
    # The gains that it reaches it with are not searched.
    assert not found["design"]["in_ranges"] and "let the search start there" not in told


def test_json_says_so_too_and_a_resume_ends_alike(ran, tmp_path, monkeypatch, capsys):
    _, _, _, _, folder = ran
    again = tmp_path / "again"
    shutil.copytree(folder, again)
    (again / GAINS).write_text("{}")
    monkeypatch.setattr(report, "start_figures", lambda _: NoDrawing())
    code, out, _ = tuner(monkeypatch, capsys, "resume", again, "--json")
    told = json.loads(out)
    assert code == NOTHING_FEASIBLE and told["feasible"] is False and list(told)[0] == "feasible"
    # What an earlier ending left is gone: nobody may take it for this run's.
    assert not (again / GAINS).exists()
    assert (again / INFEASIBLE).read_text() == (folder / INFEASIBLE).read_text()


def test_show_and_the_page_say_so_first_and_advise_no_flight(ran, capsys):
    _, _, _, _, folder = ran
    print_run_report(report_run(folder), Console(width=400))
    out = capsys.readouterr().out
    assert out.splitlines()[1].startswith(NOTHING)
    assert "tuner fly" not in out and "tuner export" not in out and "Nearest to feasible, not recommended" in out
    told = json.loads(report_run(folder).json)
    assert told["feasible"] is False and told["recommended"] is None and told["nearest"]["point"]
    text = tuning_page(TuningFolder(folder)).text()
    assert NOTHING in text and text.index(NOTHING) < text.index('class="answer"') < text.index("Nearest to feasible")
    said = re.sub(r"<[^>]*>|\s", "", text[: text.index("</header>")])
    assert "Nearesttofeasible" in said and "significantlybetter" not in said
    assert "automatic limit, mission.followed" in text and "(automatic: mission.followed)" in out
    assert "Save infeasible.json" in text and "nothing to fly" in out
    assert '"gains_name":"infeasible.json"' in text


def test_export_refuses_the_file_unless_forced(ran, tmp_path, monkeypatch, capsys, few_golden_vectors):
    _, _, _, _, folder = ran
    words = ["export", folder / INFEASIBLE, "--to", "c99", "--out", tmp_path / "c", "--flights", "2"]
    code, out, err = tuner(monkeypatch, capsys, *words)
    assert (code, out) == (2, "") and "infeasible gains" in err and "--force" in err and not (tmp_path / "c").exists()
    code, _, _ = tuner(monkeypatch, capsys, *words, "--force")
    assert code in (0, 1) and json.loads((tmp_path / "c" / "gains.json").read_text())["study"]["feasible"] is False


def test_the_file_is_valid_and_its_mark_is_under_the_hash(ran, tmp_path, monkeypatch, capsys):
    _, _, _, _, folder = ran
    code, out, _ = tuner(monkeypatch, capsys, "validate", folder / INFEASIBLE)
    assert code == 0 and "valid" in out
    document = json.loads((folder / INFEASIBLE).read_text())
    del document["study"]["feasible"]
    clean = tmp_path / "gains.json"
    clean.write_text(json.dumps(document))
    code, _, err = tuner(monkeypatch, capsys, "validate", clean)
    assert code == 2 and "sha256" in err


def test_rejudging_by_a_limit_that_nothing_keeps_ends_alike(ran, tmp_path, monkeypatch, capsys):
    _, _, _, _, folder = ran
    monkeypatch.setattr(report, "start_figures", lambda _: NoDrawing())
    monkeypatch.setenv("COLUMNS", "400")
    study = write(tmp_path, YAW.replace('"attitude"\nmin = 30', '"tilt"\nmin = 1') + SOON)
    code, out, _ = tuner(monkeypatch, capsys, "rejudge", folder, "--out", tmp_path / "judged", "--study", study)
    assert code == NOTHING_FEASIBLE and out.count(NOTHING) == 1
    told = {entry["label"]: entry for entry in summary_of(tmp_path / "judged")["obstacles"]}
    found = told["mean(rms.position)"]
    assert found["loop"] is None and found["reached"] > 0.01 and "phase_margin(tilt)" not in told
    values = pd.concat(read_frame(file) for file in sorted((tmp_path / "judged" / "generations").glob("*.npz")))
    least = values["violation:mean(rms.position)"].min() + 0.01
    assert found["reached"] == pytest.approx(least)


def test_a_comparison_marks_who_recommends_nothing(ran, monkeypatch, capsys):
    _, _, _, study, folder = ran
    words = ["compare", folder, folder / INFEASIBLE, "--study", study, "--seeds", "2"]
    monkeypatch.setenv("COLUMNS", "400")
    code, out, _ = tuner(monkeypatch, capsys, *words)
    assert code == 0 and out.splitlines()[1].startswith(NOTHING) and folder.name in out.splitlines()[1]
    code, out, _ = tuner(monkeypatch, capsys, *words, "--json")
    found = json.loads(out)
    assert found["feasible"] is False and [row["feasible"] for row in found["contenders"]] == [False, False]


def test_a_run_that_recommends_says_nothing_of_it(small_run):
    _, folder = small_run
    summary = summary_of(folder)
    assert summary["feasible"] is True and summary["ending"] == [] and summary["obstacles"] == []
    assert summary["nearest"] is None and (folder / GAINS).exists() and not (folder / INFEASIBLE).exists()
    assert "feasible" not in json.loads((folder / GAINS).read_text())["study"]


def test_finalists_that_break_a_limit_when_held_out_are_not_recommended(tmp_path, no_pictures):
    """Four flights are milder than 32: the best worst case of the first generation is a limit that no front keeps for long."""
    limit = {"metric": "rms.position", "risk": "worst", "max": 1.0}
    first = run_small(tmp_path / "free", constraint=[limit], search__generations=1)
    best = float(first.generations[0].evaluation.scores[:, 2].max(axis=1).min())
    outcome = run_small(tmp_path / "tight", constraint=[{**limit, "max": best}], search__generations=1)
    assert len(outcome.archive.front()) > 0 and not outcome.feasible and outcome.conflict is None
    summary = summary_of(tmp_path / "tight")
    assert summary["ending"][0].startswith(f"{NOTHING} on held-out scenarios")
    held_out = outcome.finalists.evaluation.scores[outcome.tuned, 2].max()
    told = f"violates worst(rms.position) at most {best:.4g} m with {held_out:.4g}."
    assert summary["ending"][1].endswith(told) and not (tmp_path / "tight" / GAINS).exists()


def test_limits_are_kept_with_confidence_unless_the_study_says_otherwise(tmp_path, no_pictures):
    """The limit lies where some finalists keep it by their values and none by the upper end of its interval."""
    outcome = run_small(tmp_path / "run", constraint=[{"metric": "rms.position", "max": 9.0}], search__generations=1)
    flown, problem = outcome.finalists.flown, outcome.problem
    value, _, high = flown.estimate(2)
    limit, others = float(0.5 * (value[1:].min() + high[1:].min())), problem.constraints[1:]
    excess = {}
    for confidence in (0.0, 0.5, 0.95):
        problem.constraints = (replace(problem.constraints[0], most=limit, confidence=confidence), *others)
        excess[confidence] = LimitFlights(problem, outcome.finalist_rows, (), 1).look(replace(flown)).excess[:, 0]
    # The first look spends half of what the study allows to err.
    high = flown.estimate(2, 0.975)[2]
    np.testing.assert_array_equal(excess[0.95], np.maximum(high - limit, 0.0))
    assert np.all(excess[0.95][1:] > 0.0) and np.any(excess[0.0][1:] == 0.0)
    assert np.all((excess[0.0] <= excess[0.5]) & (excess[0.5] <= excess[0.95])) and np.any(excess[0.5] < excess[0.95])
    # The nearest point is told with its interval and what helps.
    row = 1 + int(np.argmin(excess[0.95][1:]))
    beyond = outcome.finalists.excess.copy()
    beyond[:, 0] = excess[0.95]
    finalists = replace(
        outcome.finalists, flown=replace(flown), excess=beyond, feasible=np.zeros(len(beyond), dtype=bool)
    )
    study = replace(outcome.study, constraints=(replace(outcome.study.constraints[0], most=limit), *others))
    nothing = replace(outcome, study=study, finalists=finalists, tuned=row)
    head, told = ending_of(nothing)
    assert head.startswith(f"{NOTHING} on held-out scenarios")
    assert re.search(r"violates mean\(rms.position\) at most \S+ m with \S+ \[\S+, \S+\]\.$", told)
    (head,) = ending_of(replace(nothing, to_settle=1234))
    assert head.startswith(f"{NOTHING} with 95 % confidence: {outcome.names[row]} is nearest and within every limit")
    assert "About 1,234 held-out flights would settle it" in head
    assert "`tuner rejudge FOLDER --set confidence=0 --out NEW`" in head


def test_a_limit_that_confirmation_flights_break_is_told_with_what_helps(tmp_path, no_pictures):
    outcome = run_small(tmp_path / "run", search__generations=1)
    assert outcome.feasible and ending_of(outcome) == []
    violations = outcome.confirmation.violations.copy()
    violations[1, 0] = 1.0 / 32
    scores = outcome.confirmation.scores.copy()
    scores[1, len(outcome.study.objectives), 7] = 1.0
    lost = replace(outcome.confirmation, excess=violations, scores=scores)
    broken = replace(outcome, confirmation=lost, table=compare(outcome.problem, lost, 1), broken_again=np.array([0]))
    assert not broken.feasible
    head, helps = ending_of(broken)
    assert head.startswith(
        f"{NOTHING} on confirmation scenarios: {outcome.names[outcome.tuned]} satisfies every limit on held-out"
    )
    assert "mean(failure) at most 0 with 1 of 32 flights" in head
    assert "`tuner rejudge FOLDER --set constraint.0.max=VALUE --out NEW`" in helps and "0.16 or more" in helps


def test_lost_flights_that_leave_nothing_feasible_are_named_with_the_commands_that_go_on(
    tmp_path, monkeypatch, no_pictures
):
    outcome = run_small(tmp_path / "run", search__generations=1)
    column, row = len(outcome.study.objectives), 1
    assert outcome.study.constraints[0].objective.label == "mean(failure)"
    excess, failed = outcome.finalists.excess.copy(), outcome.finalists.flown.failed.copy()
    scores = outcome.finalists.flown.scores.copy()
    failed[row, [3, 5, 6, 7]] = scores[row, column, [3, 5, 6, 7]] = 1.0
    excess[row, 0] = 4.0 / failed.shape[1]
    flown = replace(outcome.finalists.flown, failed=failed, scores=scores)
    finalists = replace(outcome.finalists, flown=flown, excess=excess, feasible=np.zeros(len(excess), dtype=bool))
    names, scenario = [f"held-out-{i}" for i in (3, 5, 6, 7)], outcome.study.scenarios[0].spec.name
    lost = [
        LostFlight(
            name=name, scenario=scenario, stream="held-out", index=int(name[-1]), time=1.5, cause="tilt", limit="80 deg"
        )
        for name in names
    ]
    monkeypatch.setattr(ending, "named_losses", lambda *_: lost)
    _, violated, told = ending_of(replace(outcome, finalists=finalists, tuned=row))
    assert "mean(failure) at most 0" in violated
    assert all(f"{name} ({scenario}): tilt after 1.5 s, limit 80 deg" in told for name in names[:3])
    assert "and 1 more" in told and names[3] not in told
    fly = f"`tuner fly FOLDER/infeasible.json --study FOLDER/inputs/{outcome.study.path.stem}.toml --flight held-out-3 --plot lost.png`"
    assert fly in told
    (number,) = re.findall(r"`tuner rejudge FOLDER --set constraint\.0\.max=(\S+) --out NEW`", told)
    share = float(number)
    # With this limit the same flights satisfy it at the confidence of the study.
    problem = outcome.problem
    problem.constraints = (replace(problem.constraints[0], most=share), *problem.constraints[1:])
    limits = LimitFlights(problem, outcome.finalist_rows, (), 1)
    assert limits.look(replace(flown)).excess[row, 0] == 0.0 and share < 1.2 * (flown.estimate(column, 0.975)[2][row])
