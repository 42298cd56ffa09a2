"""A stranger's extension, as it is written: it installs outside of the tool, and the tool takes it from there."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from plant.errors import InputError, StoreError, UnknownNameError
from plant.law_registry import LAWS
from tuner.extensions.scaffold.writing import KINDS, write_extension
from tuner.study.own_code import use

MAX_LINES = 60
"""Lines of a whole package, as the documents promise."""


@pytest.mark.parametrize("kind", KINDS)
def test_a_package_is_short_and_keeps_the_rules_of_style(tmp_path, kind):
    files = write_extension(str(tmp_path / "warm_coil"), kind)
    assert sum(len(file.read_text().splitlines()) for file in files) <= MAX_LINES
    assert not any("@" in line and not line.startswith("@") for file in files for line in file.read_text().splitlines())
    assert {file.relative_to(tmp_path).parts[0] for file in files} == {"warm_coil"}
    checked = ["ruff", "check", "--isolated", "--line-length", "120", "--select", "E,F", str(tmp_path)]
    done = subprocess.run([sys.executable, "-m", *checked], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("name", ["Warm", "warm-coil", "1st", "class", "über coil", ""])
def test_a_name_that_is_none_in_python_is_refused(tmp_path, name):
    with pytest.raises(InputError, match="write lower-case letters"):
        write_extension(f"{tmp_path}/new/{name}" if name else ".")
    assert not (tmp_path / "new").exists()


def test_nothing_is_overwritten_and_a_kind_has_a_name(tmp_path):
    write_extension(str(tmp_path / "mine"))
    with pytest.raises(StoreError, match="exists already and was not touched"):
        write_extension(str(tmp_path / "mine"), "law")
    with pytest.raises(UnknownNameError, match="did you mean 'target'"):
        write_extension(str(tmp_path / "other"), "targett")


def test_the_command_says_how_to_install_it(tmp_path, tuner, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "pip install --no-deps --editable mine" in tuner("new", "extension", "mine").stdout
    assert "valid: extension" in tuner("new", "extensio", "mine").stderr
    assert not (tmp_path / "extension.toml").exists()


def test_the_law_keeps_the_contract_of_every_law(tmp_path, tuner):
    write_extension(str(tmp_path / "soft"), "law")
    file = tmp_path / "soft" / "soft" / "law.py"
    assert "keeps its contract" in tuner("check", file).stdout
    use(file)
    assert [gain.name for gain in LAWS["soft"].gains] == ["kp", "kd"]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A folder outside of the tool with the packages of all templates, as pip puts them there."""
    home = tmp_path_factory.mktemp("outside")
    names = [f"my_{kind}" for kind in KINDS]
    for kind, name in zip(KINDS, names, strict=True):
        write_extension(str(home / name), kind)
    packages = [str(home / name) for name in names]
    install = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation", "--no-index"]
    done = subprocess.run([*install, "--target", str(home / "site"), *packages], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return home / "site"


def outside(installed: Path, code: str, *arguments: str) -> str:
    """Run Python with the installed packages; return what it prints."""
    path = os.pathsep.join([str(installed), *filter(None, [os.environ.get("PYTHONPATH")])])
    run = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(run, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path})
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
def test_the_command_is_in_the_help_and_runs(installed, small_run):
    code = "from tuner.cli.main import main; main()"
    assert "my_report  " in outside(installed, code, "--help")
    printed = outside(installed, code, "my_report", str(small_run[1]))
    assert printed.endswith("of the candidates keep every limit.\n")


@pytest.mark.slow
def test_metric_law_target_and_section_are_there(installed, small_run):
    code = """
import sys
from pathlib import Path
import tuner
from tuner.documents.tuning import TuningFolder
from tuner.report.trust_section import trust_section
from tuner.text.markup import Markup
listed = {kind: {row[column] for row in tuner.catalogue(kind).reset_index().to_dict("records")}
          for kind, column in (("metrics", "metric"), ("laws", "law"), ("targets", "target"))}
print("my_report_error" in listed["metrics"], "my_law" in listed["laws"], "my_target" in listed["targets"])
print(trust_section(TuningFolder(Path(sys.argv[1])), Markup()))
"""
    there, page = outside(installed, code, str(small_run[1])).split("\n", 1)
    assert there == "True True True"
    assert "candidates keep every limit." in page
