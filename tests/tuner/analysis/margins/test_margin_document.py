"""`tuner margins` and its JSON: schema, units, notes for what has no end, exit codes."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from objectives.margins.margins import MarginModel
from objectives.margins.quantities import QUANTITIES, REPORTED
from objectives.margins.trim import Trim
from plant.errors import InputError
from tests.tuner.conftest import QUICKSTART
from tests.tuner.experiments.again.killing import assert_covered
from tests.tuner.in_process import tuner
from tuner import extension
from tuner.analysis.margins.document import default_requirements, margins_document, study_requirements
from tuner.analysis.margins.judging import judge_quadrotor
from tuner.analysis.margins.limits import LIMITS, LoopLimit
from tuner.analysis.margins.readings import subject_of
from tuner.api.gains import default_gains
from tuner.api.margins import margins
from tuner.cli.main import app
from tuner.cli.printers.margins import marks_of
from tuner.documents.margins import LimitRow, MarginsDocument
from tuner.gains import to_document
from tuner.study.build import load_study

ROOT = Path(__file__).parents[4]
CHANNELS = ("x", "y", "z", "roll", "pitch", "yaw")


def asked(*arguments):
    return CliRunner().invoke(app, ["margins", *map(str, arguments)])


def subject(law: str, trim=None):
    return subject_of(default_gains(law).controller, trim or Trim())


@pytest.fixture(scope="module")
def hybrid():
    return subject("hybrid")


@pytest.fixture(scope="module")
def document(hybrid):
    return json.loads(margins_document(hybrid, default_requirements(hybrid)).text())


def test_the_schema_is_that_of_the_docstring(document):
    assert list(document) == [
        "format",
        "version",
        "airframe",
        "laws",
        "control_period",
        "trim",
        "channels",
        "multiloop",
        "requirements",
        "passed",
    ]
    assert [entry["channel"] for entry in document["channels"]] == list(CHANNELS)
    for entry in document["channels"]:
        assert list(entry) == ["channel", "stable", "growth", "amplitude_dependent", "quantities", "disk_range"]
        assert list(entry["quantities"]) == list(REPORTED)
        for reading in entry["quantities"].values():
            assert list(reading) == ["value", "unit", "frequency", "case", "note"]
            assert (reading["value"] is None) == (reading["note"] is not None)
            assert reading["frequency"] is None or reading["frequency"]["unit"] == "rad/s"


def test_names_units_and_values_are_those_of_margin_tables(hybrid, document):
    for name in REPORTED:
        values = QUANTITIES[name].values(hybrid.margins)[0]
        for i, entry in enumerate(document["channels"]):
            found = entry["quantities"][name]
            assert found["unit"] == QUANTITIES[name].unit
            assert found["value"] is None if np.isinf(values[i]) else found["value"] == values[i]


def test_only_loops_with_a_nonlinear_term_name_an_amplitude(document):
    by_name = {entry["channel"]: entry for entry in document["channels"]}
    assert not by_name["z"]["amplitude_dependent"] and by_name["z"]["quantities"]["ms"]["case"] is None
    assert by_name["roll"]["amplitude_dependent"] and by_name["roll"]["quantities"]["ms"]["case"] == "steepest slope"


def test_an_infinite_margin_is_null_and_says_why(document):
    x = document["channels"][0]["quantities"]["gain_down"]
    assert x["value"] is None and "no fall" in x["note"]


def test_unstable_loops_say_so():
    found = subject("supertwisting")
    document = margins_document(found, default_requirements(found))
    roll = document.channels[3]
    assert not roll.stable and (roll.growth.value or 0.0) > 0.0
    found = roll.quantities["ms"]
    assert (found.value, found.unit, found.frequency, found.note) == (None, "1", None, "the loop is not stable")
    assert not document.passed


def test_attitude_mode_has_no_loop_in_x_and_y():
    found = subject("pid", Trim(hold=False))
    document = margins_document(found, default_requirements(found))
    assert [entry.channel for entry in document.channels] == ["z", "roll", "pitch", "yaw"]
    assert {row.channel for row in document.requirements} == {"z", "roll", "pitch", "yaw"}


def test_requirements_are_judged_with_hard_limits_and_soft_targets(document):
    rows = {row["label"]: row for row in document["requirements"]}
    phase, target = rows["phase_margin(roll)"], rows["phase_margin(roll) target"]
    assert (
        phase["limit"] == np.radians(35.0) and phase["hard"] and not phase["kept"] and phase["value"] < phase["limit"]
    )
    assert target["limit"] == np.radians(45.0) and not target["hard"]
    assert rows["phase_margin(z)"]["kept"]
    assert (rows["gain_up(roll)"]["unit"], rows["gain_up(roll)"]["shown_unit"]) == ("1", "dB")
    assert len(rows) == 6 * (1 + len(LIMITS) + sum(limit.target is not None for limit in LIMITS))
    assert marks_of([LimitRow(**row) for row in document["requirements"]])["roll", "phase_margin"] == "!"


def test_loops_are_evaluated_once_for_margins_and_limits(monkeypatch):
    evaluated, evaluate = [], MarginModel.evaluate
    monkeypatch.setattr(MarginModel, "evaluate", lambda self, gains: evaluated.append(gains) or evaluate(self, gains))
    judge_quadrotor(default_gains("pid").controller, Trim(), None, certified=False)
    assert len(evaluated) == 1


@pytest.mark.parametrize(("sense", "inside", "outside"), [("min", 2.0, 1.999), ("max", 2.0, 2.001)])
def test_a_limit_itself_is_kept(sense, inside, outside):
    limit = LoopLimit("ms", sense, 2.0)
    assert limit.is_satisfied(inside) and not limit.is_satisfied(outside)
    assert limit.is_satisfied(np.inf) == (sense == "min")


def test_exit_code_and_json_of_the_command(tmp_path):
    kept, broken = asked("--law", "pid", "--json"), asked("--law", "hybrid", "--json")
    assert (kept.exit_code, broken.exit_code) == (0, 1)
    assert json.loads(kept.stdout)["passed"] and not json.loads(broken.stdout)["passed"]
    path = tmp_path / "gains.json"
    path.write_text(json.dumps(to_document(default_gains("pid").controller, {})))
    assert json.loads(asked(path, "--json").stdout) == json.loads(kept.stdout)


def test_the_table_names_every_quantity_with_its_unit():
    shown = asked("--law", "hybrid").stdout
    for word in (
        "gain up [dB]",
        "phase [deg]",
        "delay [ms]",
        "delay in periods",
        "Ms",
        "disk margin",
        "load [s^-3]",
        "VIOLATED",
    ):
        assert word in shown
    assert max(map(len, shown.splitlines())) <= 80


def test_bad_input_ends_with_code_2_and_one_line():
    command = [sys.executable, "-c", "from tuner.cli.main import main; main()", "margins", "nowhere.json"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 2 and "there is no such file" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "--law"),
        (["--law", "hybrid", "--wind", 80], "no steady flight"),
        (["--law", "hybrid", "--wind", 3, "--attitude-only"], "attitude mode"),
        (["--law", "pid", "--study", QUICKSTART], "'hybrid'"),
    ],
)
def test_what_cannot_be_judged_is_refused(arguments, words):
    done = asked(*arguments)
    assert words in str(done.exception) and done.stdout == ""


def test_a_folder_with_anything_in_it_is_not_touched(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    assert "exists already" in str(asked("--law", "pid", "--out", tmp_path).exception)
    assert [entry.name for entry in tmp_path.iterdir()] == ["mine.txt"]


def test_the_margin_tables_of_a_study_take_the_place_of_the_limits(tmp_path):
    study = tmp_path / "study.toml"
    text = QUICKSTART.read_text()
    cut = text.index("[[margin]]") if "[[margin]]" in text else len(text)
    rest = text[text.index("[search]") :] if "[[margin]]" in text else ""
    tables = (
        '\n[[margin]]\nquantity = "ms"\naxis = "attitude"\nmax = 2.2\n\n[[margin]]\nquantity = "gain_up"\nmin = 3.0\n'
    )
    study.write_text(text[:cut] + tables + rest)
    controller = default_gains("hybrid").controller
    rows = study_requirements(load_study(study), controller)
    assert rows is not None and [row.label for row in rows] == ["ms(attitude)", "gain_up"]
    assert rows[0].limit == 2.2 and not rows[0].is_satisfied and (rows[1].unit, rows[1].shown_unit) == ("1", "dB")
    done = asked("--law", "hybrid", "--study", study, "--json")
    assert done.exit_code == 1 and MarginsDocument.parse(done.stdout).requirements == rows
    assert "ms(attitude)" in asked("--law", "hybrid", "--study", study).stdout


def test_a_study_without_margin_tables_leaves_the_limits_as_they_are(tmp_path):
    study = tmp_path / "study.toml"
    text = QUICKSTART.read_text()
    study.write_text("\n\n".join(part for part in text.split("\n\n") if "[[margin]]" not in part))
    assert study_requirements(load_study(study), default_gains("hybrid").controller) is None


@pytest.mark.parametrize("command", ["margins", "design"])
def test_help_has_an_example(command):
    done = CliRunner().invoke(app, [command, "--help"])
    assert done.exit_code == 0 and f"Example: tuner {command}" in " ".join(done.stdout.split())


def test_out_holds_the_document_with_extents_that_are_printed_too(tmp_path, monkeypatch):
    from tuner.analysis.margins.mismatch import ToleranceRange
    from tuner.report import margin_figures as figures

    ends = [ToleranceRange("mass", "stability", 0.5, None), ToleranceRange("mass", "limits", 1.0, 1.0)]
    monkeypatch.setattr(figures, "write_margin_figures", lambda *_: ends)
    done = asked("--law", "pid", "--out", tmp_path / "new")
    assert_covered(tmp_path / "new")
    written = json.loads((tmp_path / "new" / "margins.json").read_text())
    assert done.exit_code == 0
    assert written["mismatch"] == [
        {"factor": "mass", "criterion": "stability", "low": 0.5, "high": None, "note": written["mismatch"][0]["note"]},
        {"factor": "mass", "criterion": "limits", "low": 1.0, "high": 1.0, "note": None},
    ]
    assert "as far as was tried" in written["mismatch"][0]["note"]
    shown = " ".join(done.stdout.split())
    assert (
        "Mass alone: stable from 0.50 to more than 4 times" in shown
        and "not within the limits even as assumed" in shown
    )


def test_certificates_are_those_that_apply_to_each_axis(monkeypatch):
    from tuner.extensions.certificates import rows
    from tuner.extensions.certificates.certificate import Certificate, CertificateInfo

    info = CertificateInfo(
        "mine", "title", "source", frozenset({"pid"}), lambda _: Certificate(2.0, "s", True, "because")
    )
    monkeypatch.setattr(rows, "CERTIFICATES", {"mine": info})
    found = json.loads(asked("--law", "pid", "--certificates", "--json").stdout)["certificates"]
    assert [row["axis"] for row in found] == ["roll", "pitch", "yaw"]
    assert found[0] == {
        "axis": "roll",
        "name": "mine",
        "title": "title",
        "value": 2.0,
        "unit": "s",
        "verified": True,
        "why": "because",
        "source": "source",
    }
    assert "because" in asked("--law", "pid", "--certificates").stdout


def test_certificates_need_an_extension_that_proves_them(monkeypatch):
    monkeypatch.setattr(extension, "extensions", dict)
    gains = default_gains("pid")
    with pytest.raises(InputError, match="no installed extension proves anything of a quadrotor") as caught:
        margins(gains, certificates=True)
    assert caught.value.key == "--certificates" and margins(gains).document.certificates is None


@pytest.mark.parametrize("compiled", [False, True])
def test_a_first_compilation_is_announced_on_stderr_and_no_other(compiled, monkeypatch, capsys):
    monkeypatch.setattr("tuner.api.margins.is_compiled", lambda: compiled)
    code, out, errors = tuner(monkeypatch, capsys, "margins", "--law", "pid", "--json")
    assert code == 0 and json.loads(out)["format"]
    assert ("Compiling the margins" in errors) == (not compiled)


@pytest.mark.slow
def test_the_first_compilation_is_announced_on_stderr_and_no_other(tmp_path):
    """With a cache that is empty, in a process of its own; what is on stdout stays JSON."""
    told, command = [], [sys.executable, "-c", "from tuner.cli.main import main; main()"]
    for _ in range(2):
        done = subprocess.run(
            [*command, "margins", "--law", "pid", "--json"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
            env={**os.environ, "TUNER_CACHE_DIR": str(tmp_path)},
        )
        assert json.loads(done.stdout)["format"]
        told.append(done.stderr)
    assert "Compiling the margins" in told[0] and "Compiling" not in told[1]
