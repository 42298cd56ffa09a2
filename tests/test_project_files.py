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
    monkeypatch.setattr(bootstrap, "PYTHON", tmp_path)
    calls = []
    monkeypatch.setattr(bootstrap.subprocess, "check_call", lambda command: calls.append(command))
    for lock in ("core.txt", "core.txt", "develop.txt", "core.txt", "develop.txt"):
        bootstrap.install(lock)
    assert [Path(command[-1]).name for command in calls if "--require-hashes" in command] == ["core.txt", "develop.txt"]
    assert [command[-1] for command in calls if "--no-deps" in command] == [str(bootstrap.ROOT)] * 2
    (tmp_path / "installed").write_text("of-another-pyproject\n")
    bootstrap.install("core.txt")
    assert len(calls) == 6


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
