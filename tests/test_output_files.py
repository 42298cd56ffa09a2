"""Every file is written through one door: not through a link, not where a file has a second name, not for others to write."""

import ast
import errno
import io
import os
import shutil
import stat
from pathlib import Path

import pytest

from plant.errors import StoreError
from plant.output_files import open_in_place, replace_file, write_new_file
from tests.sources import sources, walk
from tests.tuner.conftest import QUICKSTART, run_small
from tests.tuner.extensions.trials.bench import bowls
from tests.tuner.in_process import tuner as in_this_process
from tests.undrawn import undrawn
from tuner.store.folder import Folder

ROOT = Path(__file__).parents[1]
SECRET = b"nobody writes here\n"
# What a run leaves: each is put behind a link in turn. The last three are written by exports and by a killed process.
FILES = (
    ".lock",
    "manifest.json",
    "run.json",
    "study.toml",
    "resolved.json",
    "environment.json",
    "inputs/quickstart.toml",
    "history.csv",
    "front.csv",
    "front.gains.csv",
    "summary.json",
    "gains.json",
    "responses.npz",
    "report.html",
    "generations/0001.npz",
    "figures/front.svg",
    ".report.html.aside",
    "figures/.front.svg.aside",
    "export/c99/export.json",
)
FOLDERS = ("inputs", "generations", "flights", "figures", "export", "export/c99")


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """A small run, complete with report and blank figures."""
    folder = tmp_path_factory.mktemp("links") / "r"
    with undrawn():
        run_small(folder)
    return folder


@pytest.fixture
def victim(tmp_path):
    """A folder with a file outside, which must stay as it is; and a look at all that lies there."""
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "secret").write_bytes(SECRET)
    return outside


def untouched(outside):
    return {path.name: path.read_bytes() for path in outside.iterdir()} == {"secret": SECRET}


def copied(finished, tmp_path):
    return Path(shutil.copytree(finished, tmp_path / "r"))


def linked(place, target):
    """Put a link in the place of a file or folder."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.is_dir() and not place.is_symlink():
        shutil.rmtree(place)
    place.unlink(missing_ok=True)
    place.symlink_to(target)


def refused(tmp_path, monkeypatch, capsys, *words):
    """Run a command where it cannot leave anything else; return its one line."""
    monkeypatch.chdir(tmp_path)
    code, out, err = in_this_process(monkeypatch, capsys, *words)
    assert (code, err.count("\n")) == (2, 1) and err.startswith("Error: "), (code, out, err)
    return err


@pytest.mark.parametrize("name", [*FILES, *FOLDERS])
@pytest.mark.parametrize("command", ["report", "resume"])
def test_a_results_folder_with_a_link_where_something_is_written_is_refused(
    command, name, finished, victim, tmp_path, monkeypatch, capsys
):
    results = copied(finished, tmp_path)
    if name in ("run.json", "summary.json"):
        # Read before anything is written, and so behind the link as it stands.
        (results / name).rename(victim.parent / name)
        linked(results / name, victim.parent / name)
        before = (victim.parent / name).read_bytes()
        told = refused(tmp_path, monkeypatch, capsys, command, results)
        assert (victim.parent / name).read_bytes() == before
    else:
        linked(results / name, victim if name in FOLDERS else victim / "secret")
        told = refused(tmp_path, monkeypatch, capsys, command, results)
    assert "link" in told or "damaged" in told or "missing" in told
    assert untouched(victim)


@pytest.mark.parametrize("name", [".lock", "manifest.json", "figures", "asked.jsonl", "told.jsonl", "report.html"])
@pytest.mark.parametrize("dangling", [False, True])
@pytest.mark.parametrize("command", ["ask", "tell"])
def test_trials_are_not_written_through_links(command, dangling, name, victim, tmp_path, monkeypatch, capsys):
    study = bowls(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert in_this_process(monkeypatch, capsys, "ask", study.path, "--out", "r")[0] == 0
    lines = tmp_path / "lines"
    lines.write_text('{"id": "t0001", "metrics": {"left": 1.0, "right": 1.0}}\n')
    linked(tmp_path / "r" / name, victim / "new" if dangling else victim if name == "figures" else victim / "secret")
    words = ["ask", study.path, "--out", "r"] if command == "ask" else ["tell", "r", lines]
    told = refused(tmp_path, monkeypatch, capsys, *words)
    assert "link" in told or (name == "manifest.json" and "damaged" in told)
    assert untouched(victim)


@pytest.mark.parametrize("name", [".lock", "told.jsonl"])
def test_a_second_name_of_a_file_outside_is_not_written(name, victim, tmp_path, monkeypatch, capsys):
    study = bowls(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert in_this_process(monkeypatch, capsys, "ask", study.path, "--out", "r")[0] == 0
    (tmp_path / "r" / name).unlink(missing_ok=True)
    os.link(victim / "secret", tmp_path / "r" / name)
    lines = tmp_path / "lines"
    lines.write_text('{"id": "t0001", "metrics": {"left": 1.0, "right": 1.0}}\n')
    refused(tmp_path, monkeypatch, capsys, "tell", "r", lines)
    assert untouched(victim)


# Commands that write a new file or folder, and what they are given; OUT is a link.
NEW = {
    "run": ("run", QUICKSTART, "--out", "OUT"), "rejudge": ("rejudge", "RESULTS", "--out", "OUT"),
    "compare": ("compare", "RESULTS", "RESULTS/gains.json", "--out", "OUT"),
    "sensitivity": ("sensitivity", QUICKSTART, "--samples", 8, "--out", "OUT"),
    "margins": ("margins", "--law", "pid", "--out", "OUT"), "export": ("export", "RESULTS/gains.json", "--to", "c99", "--out", "OUT"),
    "fly": ("fly", "--law", "hybrid", "--seeds", 2, "--plot", "OUT"), "new": ("new", "OUT"),
    "new --mass": ("new", "OUT", *"--mass 1 --wheelbase 0.4 --propeller 10x4.5 --kv 900 --cells 3".split()),
    "approach": ("approach", "RESULTS/gains.json", "RESULTS/gains.json", "--out", "OUT"),
}  # fmt: skip


@pytest.mark.parametrize("target", ["folder", "file", "nothing"])
@pytest.mark.parametrize("command", NEW)
def test_nothing_new_is_written_through_a_link(command, target, finished, victim, tmp_path, monkeypatch, capsys):
    results = copied(finished, tmp_path)
    out = tmp_path / {"fly": "out.svg", "new": "out.toml", "new --mass": "out.toml"}.get(command, "out")
    empty = tmp_path / "empty"
    empty.mkdir()
    leads = {"folder": empty, "file": victim / "secret", "nothing": victim / "new"}[target]
    out.symlink_to(leads)
    given = {"OUT": out, "RESULTS": results}
    words = [str(word).replace("RESULTS", str(results)) if isinstance(word, str) else word for word in NEW[command]]
    refused(tmp_path, monkeypatch, capsys, *[given.get(word, word) for word in words])
    assert untouched(victim) and not any(empty.iterdir()) and out.is_symlink()


@pytest.mark.parametrize("name", ["export", "export/c99"])
def test_an_export_beside_the_gains_follows_no_link(name, finished, victim, tmp_path, monkeypatch, capsys):
    results = copied(finished, tmp_path)
    linked(results / name, victim)
    assert "link" in refused(tmp_path, monkeypatch, capsys, "export", results / "gains.json", "--to", "c99")
    assert untouched(victim)


def test_a_folder_that_is_being_written_follows_no_link_that_comes_later(victim, tmp_path):
    with Folder.create(tmp_path / "r") as folder:
        (tmp_path / "r" / "figures").symlink_to(victim)
        with pytest.raises(StoreError, match="figures is a link"):
            folder.write_text("figures/front.svg", "drawn")
    assert untouched(victim)


def test_what_is_written_is_for_others_to_read_at_most(tmp_path):
    before = os.umask(0)
    try:
        with Folder.create(tmp_path / "deep" / "r") as folder:
            folder.write_together({"a.json": b"1", "figures/b.svg": b"2"})
        with open_in_place(tmp_path / "lines", "ab"):
            pass
    finally:
        os.umask(before)
    modes = {path: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.rglob("*")}
    assert modes and all(mode == (0o755 if path.is_dir() else 0o644) for path, mode in modes.items()), modes


def test_a_file_is_whole_or_as_it_was(tmp_path):
    (tmp_path / "a").write_bytes(b"old")

    def full(path):
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="space"):
        replace_file(tmp_path / "a", b"new", full)
    assert [path.name for path in tmp_path.iterdir()] == ["a"] and (tmp_path / "a").read_bytes() == b"old"
    replace_file(tmp_path / "a", b"new")
    assert (tmp_path / "a").read_bytes() == b"new"
    with pytest.raises(FileExistsError):
        write_new_file(tmp_path / "a", b"newer")


class Full:
    """An open file on a disk that is full after three bytes."""

    def __init__(self, stream):
        self._stream = stream

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stream.close()

    def write(self, content):
        self._stream.write(content[:3])
        self._stream.flush()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_full_disk_leaves_no_part_of_a_new_file(tmp_path, monkeypatch):
    opened = io.open
    monkeypatch.setattr(io, "open", lambda *given, **named: Full(opened(*given, **named)))
    with pytest.raises(OSError, match="space"):
        write_new_file(tmp_path / "a", b"parameters to go back to")
    assert not list(tmp_path.iterdir())


def test_a_new_file_has_its_name_only_once_it_is_whole(tmp_path, monkeypatch):
    names = []
    link = os.link

    def watched(source, target):
        names.append((Path(source).read_bytes(), Path(target).exists()))
        link(source, target)

    monkeypatch.setattr(os, "link", watched)
    write_new_file(tmp_path / "a", b"content")
    assert names == [(b"content", False)]
    assert [path.name for path in tmp_path.iterdir()] == ["a"] and (tmp_path / "a").stat().st_nlink == 1


def test_a_disk_without_second_names_has_new_files_too(tmp_path, monkeypatch):
    def refused(*_):
        raise OSError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", refused)
    write_new_file(tmp_path / "a", b"content")
    assert [path.name for path in tmp_path.iterdir()] == ["a"] and (tmp_path / "a").read_bytes() == b"content"


def test_a_file_that_another_process_made_meanwhile_stays(tmp_path, monkeypatch):
    link = os.link

    def raced(source, target):
        Path(target).write_bytes(b"theirs")
        link(source, target)

    monkeypatch.setattr(os, "link", raced)
    with pytest.raises(FileExistsError):
        write_new_file(tmp_path / "a", b"ours")
    assert (tmp_path / "a").read_bytes() == b"theirs" and [path.name for path in tmp_path.iterdir()] == ["a"]


# Modules that write by themselves: the door, caches in private folders, folders of their own that go when they end.
OWN = {
    "plant/output_files.py",
    "plant/backends/sealed.py",
    "tuner/extensions/fmi/code.py",
    "tuner/extensions/processor_cost/qemu.py",
    "tuner/extensions/processor_cost/measure.py",
    "tuner/extensions/betaflight/bench.py",
    "tuner/extensions/betaflight/board.py",
    "tuner/extensions/autopilots/libraries/building.py",
}
WRITES = {"write_text", "write_bytes", "savefig", "mkdir", "makedirs", "touch", "copy", "copyfile", "copytree"}
HARMLESS = (
    "folder.write_",
    "self.write_",
    "table.copy",
    "np.copy",
    ".copy()",
    "sheet.copy",
    "BytesIO",
    "figure.savefig(content",
    "path.mkdir(mode=",
)


def writes(node):
    """Whether a call writes a file, or makes a folder, by its name."""
    if getattr(node.func, "attr", getattr(node.func, "id", "")) not in ("open", *WRITES):
        # Texts of all calls take a second.
        return False
    text = ast.unparse(node).replace("'", '"')
    opens = isinstance(node.func, ast.Name | ast.Attribute) and text.split("(")[0].rpartition(".")[2] == "open"
    if opens and any(f'"{mode}"' in text for mode in ("w", "wb", "a", "ab", "x", "xb", "r+", "r+b")):
        return True
    named = isinstance(node.func, ast.Attribute) and node.func.attr in WRITES
    return named and not any(harmless in text for harmless in HARMLESS)


def test_nothing_else_writes_a_file():
    found = []
    for name, text in sources(pattern=r"\b(?:open|{})\b".format("|".join(WRITES))):
        if name not in OWN:
            calls = [node for node in walk(ast.parse(text)) if isinstance(node, ast.Call)]
            found += [f"{name}:{node.lineno} {ast.unparse(node)[:60]}" for node in calls if writes(node)]
    assert not found
