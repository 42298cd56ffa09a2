"""Folders of the time when the project had another name are opened as those of today."""

import json
import shutil

import pytest

from tests.tuner.in_process import tuner
from tuner.store.manifest import digest_of


@pytest.fixture
def former(small_run, tmp_path):
    """A copy of a run whose documents bear the former name."""
    _, folder = small_run
    shutil.copytree(folder, tmp_path / "r")
    manifest = json.loads((tmp_path / "r" / "manifest.json").read_text(encoding="utf-8"))
    for file in (tmp_path / "r").glob("*.json"):
        file.write_bytes(file.read_bytes().replace(b"gainproof", b"holdfast"))
        if file.name in manifest["files"]:
            manifest["files"][file.name] = digest_of(file.read_bytes())
    manifest["format"] = "holdfast-manifest"
    (tmp_path / "r" / "manifest.json").write_text(json.dumps(manifest), encoding="utf-8")
    return tmp_path / "r"


def test_a_run_of_the_former_name_is_shown(former, monkeypatch, capsys):
    code, out, error = tuner(monkeypatch, capsys, "show", former)
    assert code == 0 and out.startswith("Quickstart"), error
    assert "holdfast" in (former / "environment.json").read_text(encoding="utf-8")
