"""Hostile names and texts: refused at the border, and inert in every exporter where something let them through."""

import ast
import inspect
import json
import shutil
import subprocess
import sys
import zipfile
from dataclasses import replace
from typing import Any, cast

import pytest

from plant.errors import InputError, one_line
from plant.quadrotor.airframes import load
from tests.clients import program
from tests.tuner.exchange.hostile_texts import CANARY, HOSTILE
from tests.tuner.exchange.skeleton import skeleton
from tests.tuner.exchange.test_export_contract import CARRIED, CONTROLLERS, request_of
from tests.tuner.in_process import tuner
from tuner.exchange.registry import exporters
from tuner.exchange.texts import c_comment, c_string, matlab_string, python_docstring
from tuner.exchange.writing import as_json
from tuner.extensions.betaflight.map import SWITCHES
from tuner.gains import read_gains, to_document

# How many texts stand alone in the usual run, where not all do: code is traced and written for a third of a second a time.
ALONE = {"c99": 0, "fmi": 0, "crazyflie": 10, "rotorpy": 5}
FIRST = {entry.name: name for entry, name in reversed(CARRIED)}
"""Controller of each exporter whose export holds every text; of others the way of the texts is the same."""
PAIRS = [
    pytest.param(
        entry,
        CONTROLLERS[name],
        id=f"{entry.name}-{name}",
        marks=[] if FIRST[entry.name] == name else pytest.mark.slow,
    )
    for entry, name in CARRIED
]
# Half of a surrogate pair has no bytes: the hash of the gains to go back to refuses it, too.
WRITTEN = [text for text in HOSTILE if "\ud800" not in text]
# Hostile texts in one, so that a few bundles hold them all.
BATCHES = [" ".join(WRITTEN[k::2]) for k in range(2)]


def named(given, name, title):
    return replace(given, airframe=replace(given.airframe, name=name, title=title))


def contents(entry, given):
    bundle = entry.export(request_of(entry, given))
    return {**bundle.files, **{f"rollback/{name}": content for name, content in bundle.rollback.items()}}


def assert_inert(entry, given, texts):
    """The files with each text as name and title are those with harmless ones, but for comments and strings."""
    harmless = contents(entry, named(given, "quad", "A quadrotor"))
    usual = {}
    for text in texts:
        found = contents(entry, named(given, text, text))
        assert found.keys() == harmless.keys()
        for name in [name for name in found if found[name] != harmless[name]]:
            usual[name] = usual.get(name) or skeleton(name, harmless[name])
            assert skeleton(name, found[name]) == usual[name], (name, text)


def test_there_are_two_hundred():
    assert len(set(HOSTILE)) == 200


# The border.


def gains_of(tmp_path, **airframe):
    document = to_document(CONTROLLERS["pid"], {})
    del document["sha256"]
    document["airframe"] |= airframe
    path = tmp_path / "gains.json"
    path.write_text(json.dumps(document))
    return path


def test_a_gains_file_with_a_hostile_name_is_refused(tmp_path):
    for text in HOSTILE:
        with pytest.raises(InputError) as caught:
            read_gains(gains_of(tmp_path, name=text))
        assert caught.value.key == "airframe.name" and caught.value.file, text
        assert str(caught.value).isprintable() and "a name is 1 to 64 letters" in str(caught.value)


def test_a_gains_file_with_a_title_that_does_not_print_is_refused(tmp_path):
    texts = [text for text in HOSTILE if not text.isprintable()]
    assert len(texts) > 50
    for text in texts:
        with pytest.raises(InputError) as caught:
            read_gains(gains_of(tmp_path, title=text))
        assert caught.value.key == "airframe.title" and str(caught.value).isprintable()


def test_an_airframe_in_a_file_with_a_hostile_name_is_refused(tmp_path):
    source = load("hummingbird").path
    count = 0
    for text in HOSTILE:
        if "/" in text or "\0" in text or "\ud800" in text or len(text.encode()) > 200:
            continue
        shutil.copy(source, file := tmp_path / f"{text}.toml")
        with pytest.raises(InputError) as caught:
            load(file)
        assert str(caught.value).isprintable() and "a name is 1 to 64 letters" in str(caught.value), text
        file.unlink()
        count += 1
    assert count > 100


@pytest.mark.parametrize("name", ["hummingbird", "my quad", "Iris-2_b.v3", "7", "x" * 64])
def test_a_usual_name_is_taken(name, tmp_path):
    assert read_gains(gains_of(tmp_path, name=name)).airframe.name == name
    shutil.copy(load("hummingbird").path, file := tmp_path / f"{name}.toml")
    assert load(file).name == name


POC = HOSTILE[0]
FIRMWARE = {"ardupilot": ["--firmware", "4.7"]}


@pytest.mark.parametrize(
    "words",
    [
        ["validate"],
        *[["export", "--to", name, *FIRMWARE.get(name, ())] for name in exporters()],
        ["fly", "--seeds", "1"],
        ["margins"],
    ],
    ids=lambda words: "-".join(words[:3]),
)
def test_every_command_refuses_the_name_in_one_line(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    path = gains_of(tmp_path, name=POC)
    code, out, err = tuner(monkeypatch, capsys, words[0], path, *words[1:])
    assert (code, out) == (2, "") and "airframe.name" in err and err.count("\n") == 1 and err.strip().isprintable()
    assert [file.name for file in tmp_path.iterdir()] == ["gains.json"]


def test_an_import_and_a_study_refuse_an_airframe_of_that_name(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copy(load("hummingbird").path, file := tmp_path / '"""; poc.toml')
    (tmp_path / "quad.params").write_text("1\t1\tMC_ROLL_P\t6.5\t9\n")
    code, out, err = tuner(monkeypatch, capsys, "import", "quad.params", "--from", "px4", "--airframe", file)
    assert (code, out) == (2, "") and "a name is 1 to 64 letters" in err and err.count("\n") == 1
    code, out, err = tuner(monkeypatch, capsys, "fly", "--law", "pid", "--airframe", file, "--seeds", "1")
    assert (code, out) == (2, "") and "a name is 1 to 64 letters" in err and err.count("\n") == 1


# Behind the border.


@pytest.mark.usefixtures("few_golden_vectors", "uncompiled")
@pytest.mark.parametrize(("entry", "given"), PAIRS)
def test_hostile_texts_leave_an_export_as_it_is(entry, given):
    first = CONTROLLERS[FIRST[entry.name]]
    alone = WRITTEN[: ALONE.get(entry.name, len(WRITTEN))] if given is first else []
    assert_inert(entry, given, [*alone, *BATCHES] if given is first else BATCHES[:1])


@pytest.mark.slow
@pytest.mark.usefixtures("few_golden_vectors", "uncompiled")
@pytest.mark.parametrize(
    ("entry", "given"), [pair for pair, (entry, _) in zip(PAIRS, CARRIED, strict=True) if entry.name in ALONE]
)
def test_every_hostile_text_leaves_an_export_as_it_is(entry, given):
    assert_inert(entry, given, WRITTEN)


def test_a_setting_of_a_previous_file_leaves_no_control_character_in_the_rollback(tmp_path):
    """Betaflight's command line ends at Ctrl-D."""
    entry, (switch, *_) = exporters()["betaflight"], SWITCHES
    (previous := tmp_path / "diff.txt").write_text(f"set {switch} = A\x04\x1b[2JB\n")
    request = replace(request_of(entry, CONTROLLERS["pid"]), previous=previous)
    text = dict(entry.export(request).rollback)["gainproof.betaflight.txt"].decode()
    assert f"set {switch} = A\\x04" in text and all(line.isprintable() for line in text.splitlines())


def test_a_document_of_an_export_is_json():
    assert json.loads(as_json({"airframe": HOSTILE})) == {"airframe": HOSTILE}


def put(folder, files):
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)


def run(folder, *command):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    assert not list(folder.rglob(CANARY))
    return done.stdout


@pytest.mark.usefixtures("few_golden_vectors")
def test_exported_c_compiles_without_a_warning_and_runs_nothing_of_a_text(tmp_path):
    entry, text = exporters()["c99"], " ".join(WRITTEN)
    put(tmp_path, entry.export(request_of(entry, named(CONTROLLERS["pid"], text, text))).files)
    ask = '#include <stdio.h>\n#include "gainproof_controller.h"\nint main(void) { return fputs(GAINPROOF_AIRFRAME, stdout) < 0; }'
    (tmp_path / "ask.c").write_text(ask)
    units = ["ask.c", "gainproof_controller.c"]
    run(tmp_path, program("gcc"), "-std=c99", "-Wall", "-Wextra", "-Wtrigraphs", "-Werror", *units, "-o", "ask", "-lm")
    assert run(tmp_path, "./ask") == one_line(text)
    run(tmp_path, "make", "-s", "test")


def test_an_fmu_loads_and_runs_nothing_of_a_text(tmp_path):
    program("gcc")
    entry, text = exporters()["fmi"], " ".join(WRITTEN)
    put(tmp_path, entry.export(request_of(entry, named(CONTROLLERS["pid"], text, text))).files)
    with zipfile.ZipFile(tmp_path / "gainproof.fmu") as archive:
        archive.extractall(tmp_path)
    load_it = "import ctypes, sys; ctypes.CDLL(sys.argv[1]).fmi2GetVersion"
    run(tmp_path, sys.executable, "-c", load_it, "binaries/linux64/gainproof_controller.so")


def test_an_exported_python_package_runs_nothing_of_a_text(tmp_path):
    entry, text = exporters()["rotorpy"], " ".join(WRITTEN)
    put(tmp_path, entry.export(request_of(entry, named(CONTROLLERS["pid"], text, text))).files)
    run(tmp_path, sys.executable, "-c", "from gainproof_rotorpy import controller; controller()")


# Each text by itself in each kind of place.


def test_every_text_is_a_comment_and_a_string_of_c(tmp_path):
    units = [f"/* {c_comment(text)} */ /*{c_comment(text)}*/ {c_string(text)}," for text in HOSTILE]
    loop = "int main(void) { for (unsigned i = 0; i < sizeof all / sizeof *all; ++i) puts(all[i]); return 0; }"
    (tmp_path / "all.c").write_text(
        "\n".join(["#include <stdio.h>", "static const char *all[] = {", *units, "};", loop])
    )
    run(tmp_path, program("gcc"), "-std=c99", "-Wall", "-Wextra", "-Wtrigraphs", "-Werror", "all.c", "-o", "all")
    assert run(tmp_path, "./all").split("\n")[:-1] == [one_line(text) for text in HOSTILE]


def test_every_text_is_a_docstring_of_python(tmp_path):
    functions = [f'def f{i}():\n    """{python_docstring(text)}"""' for i, text in enumerate(HOSTILE)]
    source = "\n".join(functions)
    constants = [cast(Any, definition).body[0].value.value for definition in ast.parse(source).body]
    assert constants == [one_line(text) for text in HOSTILE]
    # From Python 3.13 on the compiler takes the indentation off docstrings.
    show = f"import json\nprint(json.dumps([globals()[f'f{{i}}'].__doc__ for i in range({len(HOSTILE)})]))"
    (tmp_path / "all.py").write_text("\n".join([source, show]), encoding="utf-8")
    shown = json.loads(run(tmp_path, sys.executable, "all.py"))
    assert [inspect.cleandoc(text) for text in shown] == [inspect.cleandoc(text) for text in constants]


def test_every_text_is_a_string_of_octave(tmp_path):
    lines = [f"disp({matlab_string(text)});" for text in HOSTILE]
    (tmp_path / "all.m").write_text("\n".join(["1;", *lines]), encoding="utf-8")
    said = run(tmp_path, program("octave"), "--no-gui", "--norc", "--quiet", "all.m")
    assert said.split("\n")[:-1] == [one_line(text) for text in HOSTILE]
