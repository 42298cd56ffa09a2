"""The files that describe the project agree: versions, extras, what bootstrap.py installs, and the locked packages."""

import ast
import os
import re
import sys
import tomllib
from pathlib import Path
from time import perf_counter

import pytest

import bootstrap
from plant.errors import MissingPackageError, require_package
from tests.conftest import LONG, TOGETHER

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
LOCKS = {file.name: file.read_text(encoding="utf-8") for file in (ROOT / "requirements").glob("*.txt")}


def distribution(requirement):
    """The normalised name of a requirement."""
    return re.findall(r"^[\w.-]+", requirement)[0].lower().replace("_", "-").replace(".", "-")


def test_versions_are_in_step():
    (citation,) = re.findall(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    released = re.findall(r"^## (\d+\.\d+\.\d+) - \d{4}-\d\d-\d\d$", changelog, re.MULTILINE)
    assert PROJECT["version"] == citation == released[0]
    assert released == sorted(released, key=lambda text: tuple(map(int, text.split("."))), reverse=True)


def test_every_message_on_a_missing_package_names_an_extra_that_has_it():
    sources = [path for package in ("plant", "objectives", "tuner") for path in (ROOT / package).rglob("*.py")]
    texts = "\n".join(path.read_text(encoding="utf-8") for path in sources)
    asked = re.findall(r'require_package\("([\w.]+)", "(\w+)"', texts)
    assert asked
    for package, extra in asked:
        assert package.replace("_", "-") in {distribution(entry) for entry in EXTRAS[extra]}
    assert set(re.findall(r'how_to_install\(["\'](\w+)["\']\)', texts)) <= set(EXTRAS)
    assert set(re.findall(r"gainproof\[(\w+)\]", texts)) <= set(EXTRAS)


def test_a_missing_package_is_one_sentence_with_the_command_that_installs_it():
    require_package("numpy", "dask")
    with pytest.raises(MissingPackageError) as raised:
        require_package("no_such_package", "dask", key="--dask")
    told = "--dask: needs the package no_such_package; install it with: pip install 'distributed>=2024.8'"
    assert str(raised.value) == told


def test_bootstrap_installs_locked_packages_once(tmp_path, monkeypatch):
    monkeypatch.setattr(bootstrap, "STAMP", tmp_path / "installed")
    monkeypatch.setattr(bootstrap, "make_environment", lambda: "uv")
    calls = []
    monkeypatch.setattr(bootstrap, "is_done", lambda command: calls.append(command) or True)
    for lock in ("core.txt", "core.txt", "develop.txt", "core.txt", "develop.txt"):
        bootstrap.install(lock)
    assert [Path(command[-1]).name for command in calls if "--require-hashes" in command] == ["core.txt", "develop.txt"]
    assert [command[-1] for command in calls if "--no-deps" in command] == [str(bootstrap.ROOT)] * 2
    (tmp_path / "installed").write_text("of-another-pyproject\n")
    bootstrap.install("core.txt")
    assert len(calls) == 6


def test_the_project_is_installed_anew_where_it_or_its_lock_changes_and_for_no_other_file(tmp_path, monkeypatch):
    """Entry points and extras stand in pyproject.toml."""
    files = [tmp_path / name for name in ("pyproject.toml", "requirements/core.txt", "requirements/develop.txt")]
    files[1].parent.mkdir()
    for file in files:
        file.write_text("as it was", encoding="utf-8")
    monkeypatch.setattr(bootstrap, "ROOT", tmp_path)
    seen = [bootstrap.digest("core.txt")]
    for file in files:
        file.write_text("changed", encoding="utf-8")
        seen.append(bootstrap.digest("core.txt"))
    assert len(set(seen)) == 3 and seen[3] == seen[2]


def test_bootstrap_names_the_versions_of_the_project():
    classified = re.findall(r":: Python :: 3\.(\d+)", "\n".join(PROJECT["classifiers"]))
    minors = range(bootstrap.OLDEST[1], bootstrap.NEWEST[1] + 1)
    assert [int(minor) for minor in classified] == list(minors)
    assert PROJECT["requires-python"] == f">=3.{minors[0]},<3.{minors[-1] + 1}"
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert bootstrap.SUPPORTED in readme and f"Python 3.{minors[0]} to 3.{minors[-1]} on" in bootstrap.SUPPORTED


@pytest.mark.parametrize(
    ("version", "system", "machine", "expected"),
    [
        ((3, 11), "Linux", "x86_64", True),
        ((3, 14), "Darwin", "arm64", True),
        ((3, 10), "Linux", "x86_64", False),
        ((3, 15), "Linux", "aarch64", False),
        ((3, 13), "Darwin", "x86_64", False),
    ],
)
def test_only_versions_with_wheels_are_supported(version, system, machine, expected, monkeypatch):
    monkeypatch.setattr(bootstrap.platform, "system", lambda: system)
    monkeypatch.setattr(bootstrap.platform, "machine", lambda: machine)
    assert bootstrap.is_supported(version) == expected


def test_an_unsupported_python_is_told_in_a_line_within_a_second(tmp_path, monkeypatch, capsys):
    """With nothing on PATH and no pyenv; the file itself must be read by the Python that says so."""
    # This Python is not supported, though the machine is.
    supported = iter([False, True])
    monkeypatch.setattr(bootstrap, "is_supported", lambda _: next(supported))
    monkeypatch.setattr(bootstrap.sys, "argv", ["bootstrap.py", "tuner"])
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("PYENV_ROOT", str(tmp_path))
    begin = perf_counter()
    assert bootstrap.main() == 2
    assert perf_counter() - begin < 1.0
    (line,) = capsys.readouterr().err.splitlines()
    assert bootstrap.SUPPORTED in line
    source = Path(bootstrap.__file__).read_text(encoding="utf-8")
    assert ast.parse(source, feature_version=(3, 6))


def stand_in(folder, name, script):
    """A program of a shell script."""
    file = folder / name
    file.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    file.chmod(0o755)


def test_another_interpreter_of_the_machine_is_taken_and_one_that_does_not_start_is_not(tmp_path, monkeypatch):
    stand_in(tmp_path, "python3.14", "exit 127")
    stand_in(tmp_path, "python3.12", "echo 3.12")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("PYENV_ROOT", str(tmp_path))
    assert bootstrap.find_interpreter() == str(tmp_path / "python3.12")


def test_python3_venv_is_named_only_if_making_the_environment_failed(tmp_path, monkeypatch):
    monkeypatch.setattr(bootstrap, "PYTHON", tmp_path / "python")
    monkeypatch.setattr(bootstrap, "find_uv", lambda: "uv")
    monkeypatch.setattr(bootstrap.subprocess, "call", lambda command, **_: int("venv" in command))
    with pytest.raises(bootstrap.SetUpError, match="python3-venv"):
        bootstrap.make_environment()
    monkeypatch.setattr(bootstrap.subprocess, "call", lambda command, **_: int("install" in command))
    with pytest.raises(bootstrap.SetUpError) as raised:
        bootstrap.run(["uv", "pip", "install"])
    assert str(raised.value) == "Setting up failed at: uv pip install"


def test_without_uv_pip_brings_it(tmp_path, monkeypatch):
    monkeypatch.setattr(bootstrap, "PYTHON", tmp_path / "python")
    monkeypatch.setattr(bootstrap, "find_uv", lambda: None)
    monkeypatch.setattr(bootstrap.subprocess, "call", lambda command, **_: 0)
    monkeypatch.setattr(bootstrap, "bring_uv", lambda python: f"brought by {Path(python).name}")
    assert bootstrap.make_environment() == f"brought by {Path(sys.executable).name}"


@pytest.mark.parametrize("uv", ["uv", None])
def test_where_uv_fails_or_is_missing_pip_installs(uv, tmp_path, monkeypatch):
    monkeypatch.setattr(bootstrap, "STAMP", tmp_path / "installed")
    monkeypatch.setattr(bootstrap, "make_environment", lambda: uv)
    calls = []
    monkeypatch.setattr(bootstrap.subprocess, "call", lambda command, **_: calls.append(command) or command[0] == "uv")
    bootstrap.install("core.txt")
    installs = [command for command in calls if "install" in command]
    assert [command[0] == "uv" for command in installs] == [True, False, False][uv is None :]
    assert all(command[1:4] == ["-m", "pip", "install"] for command in installs[-2:])


def test_installers_have_pips_index_and_a_cache_that_can_be_written(tmp_path, monkeypatch):
    for name in ("UV_CACHE_DIR", "UV_DEFAULT_INDEX", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("PIP_INDEX_URL", "file:///mirror")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert bootstrap.environment()["UV_DEFAULT_INDEX"] == "file:///mirror"
    assert "UV_CACHE_DIR" not in bootstrap.environment()
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("HOME", str(tmp_path / "file"))
    assert bootstrap.environment()["UV_CACHE_DIR"] == str(bootstrap.VENV / "cache")


def test_a_command_finds_the_python_of_the_environment():
    assert bootstrap.activated()["PATH"].split(os.pathsep)[0] == str(bootstrap.BIN)


def locked(text):
    """The versions of a lock file by distribution; a package may have several, for several Pythons."""
    pins = re.findall(r"^([\w.-]+)==([^ ;\\]+)", text, re.MULTILINE)
    return {distribution(name): {value for other, value in pins if other == name} for name, _ in pins}


def test_every_dependency_is_locked_with_hashes_and_no_host_is_named():
    core = set(map(distribution, PROJECT["dependencies"]))
    develop = core | {distribution(entry) for extra in ("test", "docs", "bench", "dask") for entry in EXTRAS[extra]}
    assert core <= set(locked(LOCKS["core.txt"])) and develop <= set(locked(LOCKS["develop.txt"]))
    newest = locked(LOCKS["develop.txt"])
    assert all(versions == newest[name] for name, versions in locked(LOCKS["core.txt"]).items())
    for text in LOCKS.values():
        entries = re.split(r"\n(?=[\w.-]+==)", text)[1:]
        assert entries and all("--hash=sha256:" in entry for entry in entries)
        assert "://" not in text and "index-url" not in text


def test_the_lowest_lock_holds_the_lower_bounds():
    lowest = locked(LOCKS["lowest.txt"])
    for requirement in PROJECT["dependencies"]:
        match = re.match(r"([\w.-]+)>=([\d.]+)", requirement)
        assert match, requirement
        name, bound = match.groups()
        numbers = [[int(part) for part in value.split(".")] for value in lowest[distribution(name)]]
        wanted = [int(part) for part in bound.split(".")]
        assert any(value[: len(wanted)] == wanted for value in numbers), (name, bound, lowest[distribution(name)])


def test_no_folder_of_tests_hides_a_library():
    # Pytest puts the parent of a folder of modules on the path, so tests/.../cuda hid the package that drives graphics cards.
    packages = [file.parent for file in (ROOT / "tests").rglob("__init__.py")]
    hiding = [folder for folder in packages if not (folder.parent / "__init__.py").exists()]
    libraries = {"cuda", *(distribution(entry) for extra in EXTRAS.values() for entry in extra)}
    assert not {folder.name for folder in hiding} & libraries


def test_files_that_the_order_of_tests_names_are_there():
    # A file that moved away would lose its place first in the queue, and nothing else would tell.
    assert [name for name in LONG if not (ROOT / "tests" / name).is_file()] == []
    assert [name for name in TOGETHER if not (ROOT / name).is_dir()] == []


def test_every_word_of_the_proofs_that_ci_runs_is_in_a_test():
    """A renamed test would otherwise leave CI without an error."""
    lines = (ROOT / "tests" / "proofs.txt").read_text(encoding="utf-8").splitlines()
    files = [*(ROOT / "tests").rglob("test_*.py")]
    texts = "\n".join(f"{path.stem}\n{path.read_text(encoding='utf-8')}" for path in files)
    words = {word for line in lines for word in re.findall(r"[\w.]+", line)} - {"or", "and", "not"}
    assert {word for word in words if word not in texts} == set()
    assert len(lines) == len({*lines})
