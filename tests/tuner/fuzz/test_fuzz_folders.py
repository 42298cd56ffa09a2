"""Damaged folders of tails and autotunes: a command goes on with the rest, or ends in one line that says what to do.

Here a few of each; hundreds: pytest -m slow tests/tuner/fuzz/test_fuzz_folders.py.
"""

import json
import shutil
from collections import Counter
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

import tuner
from plant.errors import ToolError
from tests.tuner.conftest import QUICKSTART
from tests.tuner.fuzz.fuzzing import LONGEST_MESSAGE, fuzzed, patience
from tests.tuner.fuzz.hostile import broken, mutated, shaken
from tests.tuner.fuzz.hostile_text import json_of
from tuner.extensions.step_records.keyed_folder import KeyedFolder, StepsDocument
from tuner.extensions.tails.record import Record, ReplicaLine, line_digest
from tuner.study.build import load_study

OFTEN, RARELY = "peak.position > 1.1", "peak.position > 1.35"
"""Events that are counted in crude flights, and by splitting."""
SETTINGS = {"to": 1e-2, "width": 5.0, "most": 10_000, "threads": 1}
SECONDS = 60


@pytest.fixture(scope="module")
def study():
    return load_study(QUICKSTART, {"scenario.0.duration": 0.6, "limits.position": 1.4})


def tail_in(folder, study, event):
    """Make the folder of a tail of few replicas, without its drawing, which takes most of the time."""
    with pytest.MonkeyPatch.context() as patch:
        few(patch)
        tuner.tail(study, event, out=folder, **SETTINGS)
    return folder


@pytest.fixture(scope="module")
def made(study, tmp_path_factory):
    return tail_in(tmp_path_factory.mktemp("fuzz") / "tail", study, OFTEN)


def few(patch):
    patch.setattr("tuner.extensions.tails.estimation.estimate.FIRST", 2)
    patch.setattr("tuner.extensions.tails.estimation.planning.FAILURES", 2)
    patch.setattr("tuner.extensions.tails.run._draw", lambda *_: None)


def damaged_lines(content):
    lines = content.decode().splitlines()

    def joined(number, text):
        return ("\n".join([*lines[:number], text, *lines[number + 1 :]]) + "\n").encode("utf-8", "surrogatepass")

    tables = [json.loads(line) for line in lines]
    return st.integers(0, len(lines) - 1).flatmap(
        lambda i: st.one_of(mutated(tables[i]), shaken(tables[i])).map(lambda table: joined(i, json_of(table)))
    )


def damaged(content, name):
    """Damage of a file: of its values, of its structure or of its bytes."""
    if name.endswith(".jsonl"):
        return st.one_of(damaged_lines(content), damaged_lines(content), broken(content))
    table = json.loads(content)
    hostile = st.one_of(mutated(table), shaken(table)).map(lambda each: json_of(each).encode("utf-8", "surrogatepass"))
    return st.one_of(hostile, hostile, broken(content))


def ending(command):
    """Return "done", or "refused" for an ending in one line that says what to do."""
    try:
        with patience(SECONDS):
            command()
    except ToolError as error:
        text = str(error)
        assert text.isprintable() and len(text) <= LONGEST_MESSAGE, text[:300]
        assert any(advice in text for advice in ("--out", "--restart", "take the line out", "again")), text
        return "refused"
    return "done"


def damage_files(examples, folder, names, command, home, place):
    """Damage one file after the other; return how often a command ended how."""
    tally = Counter()
    for name in names:
        damage_file(examples, folder, name, command, home, place, tally)
    return tally


def damage_file(examples, folder, name, command, home, place, tally):
    @fuzzed(examples, home)
    @given(damaged((folder / name).read_bytes(), name))
    def attempt(hostile):
        copy = place / "damaged"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(folder, copy)
        (copy / name).write_bytes(hostile)
        tally[f"{name} {ending(lambda: command(copy))}"] += 1

    attempt()


def tails_go_on_or_are_refused(examples, made, study, event, tmp_path_factory, tmp_path, monkeypatch):
    few(monkeypatch)
    return damage_files(
        examples,
        made,
        ("stages.json", "replicas.jsonl", "tail.json", "manifest.json"),
        lambda folder: tuner.tail(study, event, out=folder, **SETTINGS),
        tmp_path_factory.mktemp("hypothesis"),
        tmp_path,
    )


@pytest.mark.slow
def test_damaged_folders_of_tails(made, study, tmp_path_factory, tmp_path, monkeypatch):
    tally = tails_go_on_or_are_refused(2, made, study, OFTEN, tmp_path_factory, tmp_path, monkeypatch)
    assert tally["stages.json refused"] and tally["replicas.jsonl refused"]


@pytest.mark.slow
@pytest.mark.parametrize(("event", "examples"), [(OFTEN, 60), (RARELY, 15)])
def test_many_damaged_folders_of_tails(event, examples, study, tmp_path_factory, tmp_path, monkeypatch, capsys):
    folder = tail_in(tmp_path / "tail", study, event)
    tally = tails_go_on_or_are_refused(examples, folder, study, event, tmp_path_factory, tmp_path, monkeypatch)
    with capsys.disabled():
        print(f"\ndamaged folders of a tail of {event}: {dict(tally)}")
    assert min(tally["stages.json refused"], tally["replicas.jsonl refused"]) >= examples // 3


@pytest.mark.parametrize("key", ["number", "probability", "ladders", "curve", "evaluations"])
def test_a_number_that_was_changed_within_its_bounds_is_damage(key, made, tmp_path):
    """A ladder of 1 beside a probability of 0.29 made an interval of no numbers, which ended in a traceback."""
    line = json.loads((made / "replicas.jsonl").read_text().splitlines()[0])
    line[key] = [1] if isinstance(line[key], list) else 1
    shutil.copytree(made, tmp_path / "copy")
    (tmp_path / "copy" / "replicas.jsonl").write_text(json.dumps(line) + "\n")
    document = StepsDocument.read(tmp_path / "copy" / "stages.json")
    with pytest.raises(ToolError, match=r"replicas.jsonl: line 1 is damaged; take the line out"):
        Record.begin(tmp_path / "copy", document.steps[0].inputs)


BAD = ("NaN", "Infinity", "-Infinity", "1e400", "-1.0", "1e300", '"0.1"', "null", "true", "[]", "9" * 5000)


@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("key", ["probability", "ladders", "curve", "evaluations", "number", "gains"])
def test_numbers_that_no_replica_has_are_damage(key, value, made, tmp_path):
    """Its numbers had no bounds: such a line came back as a probability, or ended in a traceback."""
    line = json.loads((made / "replicas.jsonl").read_text().splitlines()[0])
    assert ReplicaLine.model_validate_json(json.dumps(line))
    old = json.dumps(line[key])
    new = f"[{value}]" if isinstance(line[key], list) else value
    text = json.dumps(line).replace(f'"{key}": {old}', f'"{key}": {new}')
    # The digest is right, so the bounds alone refuse the line.
    with suppress(ValueError):
        text = text.replace(line["sha256"], line_digest(json.loads(text)))
    shutil.copytree(made, tmp_path / "copy")
    (tmp_path / "copy" / "replicas.jsonl").write_text(text + "\n")
    document = StepsDocument.read(tmp_path / "copy" / "stages.json")
    with pytest.raises(ToolError, match=r"replicas.jsonl: line 1 is damaged; take the line out") as refused:
        Record.begin(tmp_path / "copy", document.steps[0].inputs)
    assert str(refused.value).isprintable()
    # The folder is let go of.
    KeyedFolder.begin(tmp_path / "copy", "tail").folder.close()


@pytest.mark.parametrize("content", [b"", b"\x00\x80", b"[]", b"null", b'"text"', b"{" * 9999, b'{"format": "other"}'])
@pytest.mark.parametrize("kind", ["tail", "autotune"])
def test_a_record_that_is_none_is_refused_in_one_line(content, kind, tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "stages.json").write_bytes(content)
    assert ending(lambda: KeyedFolder.begin(tmp_path / "a", kind)) == "refused"
