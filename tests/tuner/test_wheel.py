"""From the wheel: what `pip install` brings, used in a folder that holds nothing of the project."""

import json
import os
import shutil
import subprocess
import sys
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STUDIES = {path.stem for path in (ROOT / "studies").glob("*.toml")}
MAIN = [sys.executable, "-c", "from tuner.cli.main import main; main()"]


def called(command, folder, path=None):
    """Run a command in a folder, with nothing of this checkout on the import path."""
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    if path is not None:
        environment["PYTHONPATH"] = str(path)
    words = list(map(str, command))
    return subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, timeout=3000, check=False)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel, built from a copy: a build in the checkout itself would find what an older one left there."""
    home = tmp_path_factory.mktemp("wheel")
    source = home / "source"
    source.mkdir()
    for name in ("plant", "objectives", "tuner", "studies"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    done = called([sys.executable, "-m", "pip", "wheel", "--no-deps", "--quiet", "--wheel-dir", home, source], home)
    if "No matching distribution found for setuptools" in done.stderr:
        pytest.skip("the build needs setuptools, and no package index can be reached")
    assert done.returncode == 0, done.stderr
    return next(home.glob("*.whl"))


@pytest.fixture(scope="module")
def unpacked(wheel, tmp_path_factory):
    folder = tmp_path_factory.mktemp("unpacked")
    zipfile.ZipFile(wheel).extractall(folder)
    return folder


@pytest.fixture
def use(unpacked, tmp_path):
    """Call the command line of the unpacked wheel in an empty folder."""

    def call(*arguments):
        return called([*MAIN, *arguments], tmp_path, unpacked)

    return call


@pytest.mark.slow
def test_the_wheel_holds_every_study_once(wheel):
    held = [Path(name) for name in zipfile.ZipFile(wheel).namelist() if name.endswith(".toml")]
    assert sorted(path.name for path in held if path.parent == Path("studies")) == sorted(
        f"{name}.toml" for name in STUDIES
    )
    assert {path.parts[0] for path in held} == {"studies", "plant", "tuner"}
    assert [path for path in held if path.parts[0] == "tuner"] == [Path("tuner/study/template.toml")]
    code = {path.relative_to(ROOT).as_posix() for path in (ROOT / "studies").rglob("*.py")}
    assert code and code <= set(zipfile.ZipFile(wheel).namelist())


@pytest.mark.slow
def test_the_shipped_studies_are_known_by_name(use, unpacked):
    rows = {row["study"]: row for row in json.loads(use("list", "studies", "--json").stdout)}
    assert set(rows) == STUDIES
    assert all(Path(row["file"]).is_relative_to(unpacked) and row["shipped"] for row in rows.values())
    figures = json.loads(use("check", "quickstart", "--json").stdout)
    assert figures["search_flights"] == 12 * 12 * 8


@pytest.mark.slow
def test_the_examples_of_the_help_name_what_there_is(use):
    example = use("--help").stdout.partition("Example: ")[2].split("\n")[0]
    assert example == "tuner run quickstart"
    # A run with a value that no study has gets as far as the study itself.
    done = use(*example.split()[1:], "--set", "search.populaton=3")
    assert done.returncode == 2 and "search.populaton" in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("study", ["paper_table3", "own_law"])
def test_a_copy_of_a_study_with_a_base_or_with_code_asks_the_same(study, use):
    assert use("new", "mine", "--from", study).returncode == 0
    said = [json.loads(use("check", which, "--json").stdout) for which in ("mine", study)]
    # The error of the plant step is flown only where an earlier command has compiled the kernel.
    assert said[0] | {"plant_step": None} == said[1] | {"plant_step": None}


@pytest.mark.slow
def test_the_quickstart_runs_after_pip_install(wheel, tmp_path):
    """All that pip installs, in an environment of its own."""
    home, empty = tmp_path / "environment", tmp_path / "empty"
    empty.mkdir()
    venv.create(home, with_pip=True)
    programs = home / ("Scripts" if os.name == "nt" else "bin")
    installed = called([programs / "python", "-m", "pip", "install", "--quiet", wheel], empty)
    assert installed.returncode == 0, installed.stderr
    done = called([programs / "tuner", "run", "quickstart"], empty)
    assert done.returncode == 0, done.stderr
    assert (empty / "results" / "quickstart" / "report.html").stat().st_size > 1_000_000
    assert called([programs / "tuner", "verify", "results/quickstart", "--sample", "8"], empty).returncode == 0
