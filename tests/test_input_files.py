"""Every file that a person gives is opened through one door: a pipe does not hang it, a device or a huge file does not fill it."""

import ast
import os
import re
from functools import cache
from hashlib import sha256
from pathlib import Path

import pytest

from plant.errors import InputError, ToolError
from plant.input_files import MAX_TEXT_BYTES, InputFile, file_sha256, given_text, read_input, read_input_text
from plant.quadrotor.airframes import load
from plant.references.waypoint_file import read_waypoints
from tests.sources import sources, walk
from tests.tuner.fuzz.fuzzing import patience
from tests.tuner.in_process import tuner
from tuner.api.run_report import last_generation
from tuner.documents.summary import Summary
from tuner.documents.tables import Columns
from tuner.extensions.ardupilot.text import read_param
from tuner.extensions.betaflight.commands import read_cli
from tuner.extensions.crazyflie import text as param_file
from tuner.extensions.px4.text import read_params
from tuner.gains import read_gains
from tuner.store.document import read_text
from tuner.store.tables import TableFile
from tuner.study.build import load_study
from tuner.study.layers import read_layers

ROOT = Path(__file__).parents[1]
READERS = {
    "study": load_study, "contest": read_layers, "airframe": load, "gains": read_gains, "waypoints": read_waypoints,
    "px4": read_params, "ardupilot": read_param, "betaflight": lambda file: read_cli(file, 0), "crazyflie": param_file.read,
    "document": Summary.read, "columns": Columns.read, "table": TableFile, "text": read_text,
    "history": last_generation,
}  # fmt: skip
SECONDS = 5


def pipe(folder):
    os.mkfifo(folder / "input.toml")
    return folder / "input.toml"


def device(folder):
    (folder / "input.toml").symlink_to("/dev/zero")
    return folder / "input.toml"


def huge(folder):
    """A terabyte without a block on the disk."""
    with (folder / "input.toml").open("wb") as file:
        file.truncate(2**40)
    return folder / "input.toml"


ODD = {"pipe": (pipe, "it is a pipe"), "device": (device, "it is a device"), "huge": (huge, "MiB are read")}


@pytest.mark.parametrize("kind", ODD)
@pytest.mark.parametrize("reader", READERS)
def test_what_is_no_regular_file_is_refused_at_once(reader, kind, tmp_path):
    make, says = ODD[kind]
    file = make(tmp_path)
    with patience(SECONDS), pytest.raises(ToolError) as caught:
        READERS[reader](file)
    assert says in str(caught.value) and str(file) in str(caught.value) and str(caught.value).isprintable()


@pytest.mark.parametrize("kind", ODD)
@pytest.mark.parametrize(
    "words",
    [
        ("check", "FILE"),
        ("run", "FILE"),
        ("plan", "FILE"),
        ("validate", "FILE"),
        ("margins", "FILE"),
        ("fly", "FILE"),
        ("theory", "FILE"),
        ("export", "FILE", "--to", "c99"),
        ("import", "FILE", "--from", "px4", "--airframe", "iris"),
        ("import", "FILE", "--from", "betaflight", "--airframe", "iris"),
        ("fly", "--law", "pid", "--airframe", "FILE"),
        ("compare", "FILE", "FILE"),
        ("show", "RESULTS"),
        ("report", "RESULTS"),
        ("resume", "RESULTS"),
        ("verify", "RESULTS"),
    ],
    ids="-".join,
)
def test_every_command_refuses_it_in_one_line(words, kind, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    file = ODD[kind][0](tmp_path)
    for name in ("summary.json", "run.json"):
        (tmp_path / "results").mkdir(exist_ok=True)
        (tmp_path / "results" / name).symlink_to(file)
    given = {"FILE": file, "RESULTS": tmp_path / "results"}
    before = sorted(tmp_path.rglob("*"))
    with patience(SECONDS):
        code, out, err = tuner(monkeypatch, capsys, *[given.get(word, word) for word in words])
    assert (code, out) == (2, "") and err.startswith("Error: ") and err.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_a_regular_file_is_read_as_it_is(tmp_path):
    (file := tmp_path / "a").write_bytes(b"\xef\xbb\xbfa\r\nb\rc\n")
    assert read_input(file) == b"\xef\xbb\xbfa\r\nb\rc\n"
    assert read_input_text(file, "utf-8-sig") == "a\nb\nc\n" == file.read_text(encoding="utf-8-sig")


def test_a_file_of_the_largest_size_is_read_and_one_byte_more_is_not(tmp_path):
    (file := tmp_path / "a").write_bytes(b"x" * 10)
    assert len(read_input(file, 10)) == 10
    with pytest.raises(OSError, match="are read"):
        read_input(file, 9)
    assert MAX_TEXT_BYTES > 100 * (ROOT / "results/paper/contest/contest.json").stat().st_size


def test_a_file_that_grows_while_it_is_read_is_refused():
    """Files of /proc say that they have no byte."""
    file = Path("/proc/self/maps")
    if not file.exists():
        pytest.skip("no /proc here")
    assert file.stat().st_size == 0
    with pytest.raises(OSError, match="are read"):
        read_input(file, 10)


def test_a_file_that_is_read_once_keeps_its_content(tmp_path):
    (path := tmp_path / "a.txt").write_bytes(b"a\r\nb")
    file = InputFile(path)
    assert read_input_text(file) == "a\nb"
    path.unlink()
    assert given_text(file, "give one") == "a\nb" and file.content == b"a\r\nb"
    assert file_sha256(file) == sha256(b"a\r\nb").hexdigest()
    assert (str(file), os.fspath(file), file.name) == (str(path), str(path), "a.txt")


def test_a_file_with_a_content_is_not_opened(tmp_path):
    assert read_input(InputFile(tmp_path / "none", b"held")) == b"held"
    with pytest.raises(OSError, match="are read") as caught:
        read_input(InputFile(tmp_path / "none", b"held"), 3)
    assert caught.value.filename == str(tmp_path / "none")


@pytest.mark.parametrize("kind", ODD)
def test_a_file_to_be_read_once_is_refused_as_any_other(kind, tmp_path):
    make, says = ODD[kind]
    file = make(tmp_path)
    with patience(SECONDS), pytest.raises(InputError, match=says) as caught:
        given_text(InputFile(file), "give a text")
    assert caught.value.file == str(file) and "give a text" in str(caught.value)


def test_a_folder_is_told_as_one(tmp_path):
    with pytest.raises(IsADirectoryError):
        read_input(tmp_path)


# Modules that read what is no user's file: sources and data of the package, what they wrote themselves, the system's.
OWN = {
    "plant/input_files.py",
    "plant/output_files.py",
    "plant/backends/cache.py",
    "tuner/extensions/cuda/card.py",
    "objectives/memory.py",
    "tuner/extensions/rotorpy/export.py",
    "tuner/extensions/fmi/archive.py",
    "tuner/extensions/studio/page.py",
    "tuner/extensions/studio/server.py",
    "tuner/extensions/fmi/code.py",
    "tuner/report/page.py",
    "tuner/extensions/processor_cost/qemu.py",
    "tuner/extensions/processor_cost/cost.py",
    "tuner/extensions/processor_cost/measure.py",
    "tuner/store/environment.py",
    "tuner/store/manifest.py",
    "tuner/exchange/texts.py",
    "plant/backends/sealed.py",
    "tuner/study/template.py",
    "plant/entry_points.py",
    "tuner/extensions/scaffold/writing.py",
}
NAMES = {"read_text", "read_bytes", "open", "ParquetFile", "read_parquet", "read_csv", "fromfile", "loadtxt"}
SPAWN = "subprocess"
# Names of functions that a rule of this file looks at.
CALLED = NAMES | {"write_text", SPAWN}
# Calls of those names that open no file by its name to read it.
HARMLESS = (
    "BytesIO(",
    "StringIO(",
    'open("x"',
    'open("w")',
    'open("ab")',
    "Folder.open(",
    "_zip.open(",
    "cls.open(",
    "os.open(",
)


def reads(node):
    """Whether a call opens a file by its name."""
    by_name = isinstance(node.func, ast.Name) and node.func.id == "open"
    if not by_name and not (isinstance(node.func, ast.Attribute) and node.func.attr in NAMES):
        return False
    return not any(text in ast.unparse(node).replace("'", '"') for text in HARMLESS)


@cache
def calls():
    """Name of a source file -> its calls of functions that open a file or start a process."""
    return {
        name: [node for node in walk(ast.parse(text)) if isinstance(node, ast.Call) and callee(node) in CALLED]
        for name, text in sources(pattern="|".join(map(re.escape, CALLED)))
    }


def callee(node):
    """Last name of a called function; of what lies in `subprocess` that one."""
    function = node.func.value if isinstance(node.func, ast.Subscript) else node.func
    if not isinstance(function, ast.Attribute):
        return getattr(function, "id", "")
    return SPAWN if getattr(function.value, "id", "") == SPAWN else function.attr


def test_nothing_else_opens_a_file_for_reading():
    found = [
        f"{name}:{node.lineno}" for name, nodes in calls().items() if name not in OWN for node in nodes if reads(node)
    ]
    assert not found


def lacks_encoding(node):
    """Whether a call turns bytes into text, or text into bytes, by the encoding of this machine."""
    options = {keyword.arg for keyword in node.keywords}
    name = ast.unparse(node.func)
    if name.endswith((".read_text", ".write_text")):
        # Folders of the project write UTF-8 alone.
        return "encoding" not in options and name != "self.write_text" and not name.endswith("older.write_text")
    if name.startswith("subprocess."):
        return bool({"text", "universal_newlines"} & options) and not {"encoding", "errors"} <= options
    # Files with an opener are opened in binary, with the mode that the caller gives.
    is_text = name in ("open", "io.open") and not any("b" in ast.unparse(each) for each in node.args[1:2])
    return is_text and not {"encoding", "opener"} & options


def test_no_text_hangs_on_the_encoding_of_the_machine():
    found = [
        f"{name}:{node.lineno} {ast.unparse(node)[:60]}"
        for name, nodes in calls().items()
        for node in nodes
        if lacks_encoding(node)
    ]
    assert not found


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ('file.read_text(errors="replace")', True),
        ('Path("a").write_text(text, encoding="utf-8")', False),
        ("subprocess.run(command, text=True)", True),
        ('subprocess.run(command, encoding="utf-8", errors="replace")', False),
        ('open(file, "w")', True),
        ('open(file, "rb")', False),
    ],
)
def test_a_call_without_encoding_is_recognized(call, expected):
    assert lacks_encoding(ast.parse(call).body[0].value) is expected
