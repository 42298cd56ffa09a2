"""`tuner check GAINS --requirements FILE` as a build server meets it: exit codes, JSON, one line for bad input."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from objectives.problem import FlightBatch
from objectives.requirements import known_values
from tests.tuner.in_process import tuner
from tests.tuner.study.study_text import STUDY, changed, write
from tuner.experiments.tuning.problem import problem_of
from tuner.gains import to_document
from tuner.study.build import load_study

ROOT = Path(__file__).parents[4]
FAILURE = changed("max = 0.0", "max = 0.5")
MARGIN = '\n[[margin]]\nquantity = "phase_margin"\naxis = "roll"\nmin = {}\n'


@pytest.fixture(scope="module")
def gains(tmp_path_factory):
    folder = tmp_path_factory.mktemp("gains")
    study = load_study(write(folder, STUDY))
    path = folder / "gains.json"
    path.write_text(json.dumps(to_document(study.controller(study.default_row), {})))
    return path


@pytest.fixture
def judged(gains, tmp_path, monkeypatch, capsys):
    """Judge the default gains of a study by a study's text; return exit code, document or None, and standard error."""

    def judge(text, *arguments, file=gains, as_json=True):
        words = ["check", file, "--requirements", write(tmp_path, text), *arguments, *(["--json"] if as_json else [])]
        code, out, err = tuner(monkeypatch, capsys, *words)
        return code, json.loads(out) if as_json and out else out, err

    return judge


def verdicts(document):
    return {row["label"]: row["verdict"] for row in document["rows"]}


def test_all_kept_is_0_and_every_row_is_told(judged, gains):
    code, document, err = judged(FAILURE + MARGIN.format(1.0), "--seeds", "32")
    assert (code, err) == (0, "")
    assert document["verdict"] == "pass" and document["flights"] == 32 and document["stream"] == "check"
    assert verdicts(document) == {
        "mean(failure)": "pass",
        "phase_margin(roll)": "pass",
        "cvar90(itae.position)": "reported",
        "mean(travel)": "reported",
    }
    failure, margin, itae, _ = document["rows"]
    assert (failure["limit"], failure["value"], failure["low"], failure["flights"]) == (0.5, 0.0, 0.0, 32)
    assert (margin["sense"], margin["unit"], margin["low"], margin["flights"]) == ("min", "rad", None, 0)
    assert itae["low"] < itae["value"] < itae["high"] and itae["limit"] is None
    assert str(gains) == document["gains"]


def test_values_are_those_of_flights_on_a_stream_of_their_own(judged, gains, tmp_path):
    _, document, _ = judged(FAILURE)
    study = load_study(write(tmp_path, FAILURE))
    problem = problem_of(study, 1, None)

    def values(stream, count):
        return problem.evaluate_gains(
            study.default_row[None], (FlightBatch(study.scenarios[0].spec, stream, count),)
        ).values[0]

    told = [row["value"] for row in document["rows"] if row["kind"] == "objective"]
    assert document["flights"] == 8 and np.array_equal(told, values("check", 8))
    for other in ("search", "held-out"):
        assert not np.any(values(other, 8) == told)


def test_broken_by_flights_alone_is_1(judged):
    limit = '\n[[constraint]]\nmetric = "travel"\nmax = 1.0\n'
    code, document, _ = judged(FAILURE + limit + MARGIN.format(1.0))
    assert code == 1 and document["verdict"] == "fail"
    assert verdicts(document)["phase_margin(roll)"] == "pass"
    travel = next(row for row in document["rows"] if row["kind"] == "constraint" and row["label"] == "mean(travel)")
    assert travel["verdict"] == "fail" and travel["value"] > 1.0


def test_broken_by_margins_alone_is_1_and_it_is_flown_all_the_same(judged, tmp_path):
    text = FAILURE + MARGIN.format(120.0)
    code, document, _ = judged(text)
    assert code == 1 and document["verdict"] == "fail"
    assert [label for label, said in verdicts(document).items() if said == "fail"] == ["phase_margin(roll)"]
    study = load_study(write(tmp_path, text))
    told = next(row["value"] for row in document["rows"] if row["label"] == "phase_margin(roll)")
    assert told == np.radians(known_values(study.screens, study.default_row[None])[0, 0])
    assert next(row["value"] for row in document["rows"] if row["label"] == "mean(failure)") == 0.0


def test_a_missed_target_breaks_nothing(judged):
    code, document, _ = judged(FAILURE + MARGIN.format(120.0) + "hard = false\n")
    assert code == 0 and document["verdict"] == "pass"
    assert verdicts(document)["phase_margin(roll, soft)"] == "target missed"


def test_a_limit_inside_the_interval_is_not_certain_and_0(judged):
    code, out, _ = judged(changed("max = 0.0", "max = 0.0001"), as_json=False)
    assert code == 0 and "not certain: the interval of mean(failure) crosses the limit" in " ".join(out.split())
    # No number of flights shows that none is lost: so many were flown, and how many may be is told.
    code, out, _ = judged(STUDY, as_json=False)
    assert code == 0 and "PASS: every limit is satisfied." in out and ": at most " in out
    code, out, _ = judged(FAILURE, as_json=False)
    assert code == 0 and "PASS: every limit is satisfied." in out
    code, out, _ = judged(FAILURE + MARGIN.format(120.0), as_json=False)
    assert code == 1 and "FAIL: violated: phase_margin(roll)." in out


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            changed('attitude = "hybrid"', 'attitude = "ladrc"')
            .replace('"roll.k1" = 20.0\n', "")
            .replace('"tilt.lambda" = { low = 1, high = 16 }', ""),
            "attitude law 'hybrid' instead of 'ladrc'",
        ),
        (changed("hummingbird", "iris"), "airframe 'hummingbird' instead of 'iris'"),
        (STUDY.replace('[[constraint]]\nmetric = "failure"\nmax = 0.0\n', ""), "nothing here limits anything"),
        (changed("[search]", "[contender.one]\n\n[search]"), "this is a contest"),
        (changed("seed = 1", "sed = 1"), "did you mean 'seed'"),
    ],
)
def test_bad_input_is_2_and_one_line(judged, text, words):
    code, out, err = judged(text)
    assert (code, out) == (2, "")
    assert words in err and err.count("\n") == 1 and "asked.toml" in err


def test_missing_and_broken_files_are_2(judged, tmp_path):
    code, out, err = judged(STUDY, file=tmp_path / "nowhere.json")
    assert (code, out) == (2, "") and "there is no such file" in err
    half = tmp_path / "half.json"
    half.write_text('{"format": ')
    code, out, err = judged(STUDY, file=half)
    assert (code, out) == (2, "") and "not JSON" in err


def test_without_requirements_a_study_is_read_and_gains_are_validated(gains, tmp_path, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "check", write(tmp_path, STUDY), "--json")
    assert code == 0 and json.loads(out)["search_flights"] == 8 * 2 * 4
    code, out, err = tuner(monkeypatch, capsys, "check", gains)
    assert (code, err) == (0, "") and "valid" in out and "--requirements STUDY" in out
    code, out, err = tuner(monkeypatch, capsys, "check", write(tmp_path, STUDY), "--seeds", 8)
    assert (code, out) == (2, "") and "--seeds" in err


@pytest.mark.slow
def test_the_console_script_ends_with_the_same_code(gains, tmp_path):
    broken = write(tmp_path, FAILURE + '\n[[constraint]]\nmetric = "travel"\nmax = 1.0\n')
    words = ["check", str(gains), "--requirements", str(broken), "--json"]
    command = [sys.executable, "-c", "from tuner.cli.main import main; main()", *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 1 and json.loads(done.stdout)["verdict"] == "fail" and done.stderr == ""
