"""The files that describe the project agree: versions, extras, what bootstrap.py installs, and the locked packages."""

import re
import tomllib
from pathlib import Path

import pytest

import bootstrap
from plant.errors import MissingPackageError, require_package

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
LOCK = (ROOT / "requirements-dev.txt").read_text(encoding="utf-8")


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
    assert set(re.findall(r"holdfast\[(\w+)\]", texts)) <= set(EXTRAS)


def test_a_missing_package_is_one_sentence_with_the_command_that_installs_it():
    require_package("numpy", "dask")
    with pytest.raises(MissingPackageError) as raised:
        require_package("no_such_package", "dask", key="--dask")
    told = "--dask: needs the package no_such_package; install it with: pip install 'holdfast[dask]'"
    assert str(raised.value) == told


def test_bootstrap_installs_extras_that_there_are():
    assert {extra for extra in bootstrap.EXTRAS.values() if extra} | {"test"} <= set(EXTRAS)


def test_bootstrap_installs_an_extra_once_for_a_pyproject(tmp_path, monkeypatch):
    monkeypatch.setattr(bootstrap, "STAMP", tmp_path / "installed")
    monkeypatch.setattr(bootstrap, "PYTHON", tmp_path)
    installed = []
    monkeypatch.setattr(bootstrap.subprocess, "check_call", lambda command: installed.append(command[-1]))
    for extra in ("test", "docs", "", "test", "docs"):
        bootstrap.install(extra)
    assert installed == [f"{bootstrap.ROOT}[test]", f"{bootstrap.ROOT}[docs]"]
    (tmp_path / "installed").write_text("of-another-pyproject test\n")
    bootstrap.install("")
    assert installed[2:] == [str(bootstrap.ROOT)]


def test_every_dependency_is_locked_and_no_host_is_named():
    locked = {distribution(line) for line in LOCK.splitlines() if line and not line.startswith("#")}
    wanted = [*PROJECT["dependencies"], *EXTRAS["test"], *EXTRAS["docs"], *EXTRAS["dask"]]
    assert {distribution(entry) for entry in wanted} <= locked
    assert "://" not in LOCK and "index-url" not in LOCK
