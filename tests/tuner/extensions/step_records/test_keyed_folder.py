"""Folders of steps: keys over a chain of inputs, states, sentences on what changed, and begun folders."""

import json
from pathlib import Path

import pytest

from plant.errors import FolderLockedError, StoreError
from tuner.extensions.step_records.key_inputs import MAX_VALUES, changes, file_input, step_key
from tuner.extensions.step_records.keyed_folder import KeyedFolder, StepState

LOGS = {"logs": {"sha256": "a"}}


def folder_with(path, state=None, inputs=LOGS, before=""):
    with KeyedFolder.begin(path, "autotune") as keyed:
        keyed.start("search", inputs, before)
        if state is not None:
            keyed.end("search", state)
    return path


@pytest.mark.parametrize(
    ("recorded", "same", "other"),
    [(None, "begun", None), (StepState.STOPPED, "stopped", "new"), (StepState.DONE, "done", None)],
)
def test_a_step_is_of_its_inputs_and_of_all_before_it(tmp_path, recorded, same, other):
    with KeyedFolder.begin(folder_with(tmp_path / "a", recorded), "autotune") as keyed:
        assert keyed.state("search", LOGS, "") == same
        assert keyed.state("export", LOGS, "") == StepState.NEW
        for inputs, before, changed in [
            ({"logs": {"sha256": "b"}}, "", "logs changed"),
            (LOGS, "another", "a stage before it was made again"),
        ]:
            if other is not None:
                assert keyed.state("search", inputs, before) == other
                continue
            with pytest.raises(StoreError) as refused:
                keyed.state("search", inputs, before, "--restart search")
            assert str(refused.value) == (
                f"{tmp_path / 'a'}: {changed} after the search was begun; choose another folder with --out, or make it again with "
                "--restart search"
            )


def test_a_forgotten_step_is_new(tmp_path):
    with KeyedFolder.begin(folder_with(tmp_path / "a", StepState.DONE), "autotune") as keyed:
        keyed.forget(["search", "never begun"])
    with KeyedFolder.begin(tmp_path / "a", "autotune") as keyed:
        assert keyed.state("search", LOGS, "") == StepState.NEW


def test_a_key_tells_inputs_apart_by_name_value_and_forerunner():
    keys = {
        step_key(inputs, before)
        for before in ("", "x")
        for inputs in ({}, LOGS, {"log": {"sha256": "a"}}, {"logs": {"digest": "a"}}, {"logs": {"sha256": "ab"}})
    }
    assert len(keys) == 10
    assert step_key({"a": {}, "b": {}}, "") == step_key({"b": {}, "a": {}}, "")


@pytest.mark.parametrize(
    ("before", "now", "sentence"),
    [
        ({"a": {"mass": "1"}}, {"a": {"mass": "2"}}, ["a changed (mass 1 -> 2)"]),
        ({"a": {"mass": "1"}}, {"a": {}}, ["a changed (mass 1 -> none)"]),
        ({"a": {}}, {"a": {"sha256": "1"}, "b": {}}, ["a changed", "b was not given before and is now"]),
        ({"a": {}, "b": {}}, {"a": {}}, ["b was given before and is not now"]),
        (
            {"a": dict.fromkeys("vwxyz", "1")},
            {"a": dict.fromkeys("vwxyz", "2")},
            ["a changed (v 1 -> 2, w 1 -> 2, x 1 -> 2, ...)"],
        ),
    ],
)
def test_changes_name_inputs_and_values(before, now, sentence):
    assert changes(before, now) == sentence


def test_values_of_files_are_named_and_the_digest_covers_the_rest():
    text = b'mass = { value = 0.027, unit = "kg" }\n[[rotor]]\nx = 1\n'
    assert {"mass": "0.027", "mass.unit": "kg", "rotor[0].x": "1"}.items() <= file_input("a.toml", text).items()
    assert file_input("a.json", b'{"gain": [1, null]}')["gain[1]"] == "None"
    for name, content in [
        ("a.toml", b"= nonsense"),
        ("a.json", b"\xff"),
        ("a.params", b"x = 1"),
        ("a.json", b"[" * 9999),
    ]:
        assert list(file_input(name, content)) == ["sha256"]
    long = json.dumps({str(i): i for i in range(2 * MAX_VALUES)}).encode()
    assert len(file_input("a.json", long)) == MAX_VALUES + 1
    assert file_input("a.json", long)["sha256"] != file_input("a.json", long + b" ")["sha256"]


def test_one_process_writes_it_at_a_time(tmp_path):
    with KeyedFolder.begin(tmp_path / "a", "tail") as keyed:
        keyed.start("tail", LOGS, "")
        with pytest.raises(FolderLockedError, match="is locked by process"):
            KeyedFolder.begin(tmp_path / "a", "tail")
    with pytest.raises(StoreError, match="holds a tail and no autotune"):
        KeyedFolder.begin(tmp_path / "a", "autotune")
    # A refusal lets go of the folder.
    with KeyedFolder.begin(tmp_path / "a", "tail"):
        pass


def test_a_folder_that_was_left_before_its_first_record_is_taken_and_any_other_is_not(tmp_path):
    for name in (".lock", "manifest.json", ".stages.json.aside"):
        (tmp_path / "left").mkdir(exist_ok=True)
        (tmp_path / "left" / name).write_text("{}")
    assert folder_with(tmp_path / "left").joinpath("stages.json").exists()
    (tmp_path / "mine").mkdir()
    Path(tmp_path / "mine" / "thesis.txt").write_text("not yours")
    with pytest.raises(StoreError, match="exists already"):
        KeyedFolder.begin(tmp_path / "mine", "tail")
