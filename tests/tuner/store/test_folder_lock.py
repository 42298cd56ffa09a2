"""One writer for a folder, nothing half written, and a word about what to do where the disk does not play along."""

import os
import resource
import subprocess
import sys
import threading
import time

import pytest

from plant.errors import InputError, StoreError
from plant.output_files import ASIDE
from tuner.store.folder import Folder


def test_a_second_writer_is_refused_and_told_who_holds_it(tmp_path):
    held = Folder.create(tmp_path / "r")
    with pytest.raises(StoreError, match=f"locked by process {os.getpid()}"):
        Folder.open(tmp_path / "r")
    held.close()
    Folder.open(tmp_path / "r").close()


def test_the_lock_of_a_killed_process_is_gone(tmp_path):
    code = (
        "from pathlib import Path; import sys, time; from tuner.store.folder import Folder\n"
        "folder = Folder.create(Path(sys.argv[1])); print('held', flush=True); time.sleep(60)"
    )
    process = subprocess.Popen([sys.executable, "-c", code, str(tmp_path / "r")], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "held\n"
    with pytest.raises(StoreError, match=f"process {process.pid}"):
        Folder.open(tmp_path / "r")
    process.kill()
    process.wait()
    process.stdout.close()
    Folder.open(tmp_path / "r").close()


def test_what_was_left_half_written_is_cleared_and_nothing_else(tmp_path):
    Folder.create(tmp_path / "r").close()
    half = tmp_path / "r" / "generations" / f".0001.npz{ASIDE}"
    half.write_bytes(b"half")
    (tmp_path / "r" / "notes.txt").write_text("mine")
    Folder.open(tmp_path / "r").close()
    assert not half.exists() and (tmp_path / "r" / "notes.txt").read_text() == "mine"


def test_an_existing_folder_is_never_begun_again(tmp_path):
    with pytest.raises(StoreError, match="--out") as told:
        Folder.create(tmp_path)
    assert "resume" not in str(told.value)
    (tmp_path / "run.json").write_text('{"kind": "tuning"}')
    with pytest.raises(StoreError, match="tuner resume"):
        Folder.create(tmp_path)


def test_an_error_before_anything_is_written_leaves_no_folder(tmp_path):
    path = tmp_path / "out"
    with pytest.raises(InputError), Folder.create(path, inside="", empty=True):
        raise InputError("the firmware is none")
    assert not path.exists()


def test_an_error_after_something_was_written_leaves_it(tmp_path):
    path = tmp_path / "out"
    with pytest.raises(InputError), Folder.create(path, inside="", empty=True) as folder:
        folder.write_text("notes.txt", "kept")
        raise InputError("the firmware died")
    assert (path / "notes.txt").read_text() == "kept"


def test_a_ctrl_c_that_an_error_hides_is_raised_with_its_advice(tmp_path):
    """`threading` raises a RuntimeError about its lock where Ctrl-C lands while a thread starts."""
    with pytest.raises(KeyboardInterrupt) as raised, Folder.create(tmp_path / "out") as folder:
        folder.write_text("notes.txt", "kept")
        try:
            raise KeyboardInterrupt
        finally:
            threading.Lock().release()
    assert isinstance(raised.value.__context__, RuntimeError)
    assert raised.value.__notes__ == [f"remove {tmp_path / 'out'} and give the command again"]


def test_an_error_while_another_is_handled_stays_itself(tmp_path):
    with pytest.raises(RuntimeError) as raised, Folder.create(tmp_path / "out") as folder:
        folder.write_text("notes.txt", "kept")
        try:
            raise OSError("a read failed")
        except OSError as error:
            raise RuntimeError("so did its repair") from error
    assert raised.value.__notes__ == [f"remove {tmp_path / 'out'} and give the command again"]


def test_there_must_be_a_folder_to_open(tmp_path):
    with pytest.raises(StoreError, match="no such results folder"):
        Folder.open(tmp_path / "none")


def test_where_a_file_cannot_be_written_the_error_says_so_and_the_old_content_stays(tmp_path):
    folder = Folder.create(tmp_path / "r")
    folder.write_text("a.txt", "first")
    folder.write_json("run.json", {"kind": "tuning"})
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    # A file larger than the limit fails in the middle of its writing, as one does on a full disk.
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        with pytest.raises(StoreError, match=r"a\.txt cannot be written .*tuner resume"):
            folder.write_text("a.txt", "x" * 100_000)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert (tmp_path / "r" / "a.txt").read_text() == "first"
    assert list((tmp_path / "r").glob(f".*{ASIDE}")) == []


def test_a_folder_in_the_place_of_a_file_is_told(tmp_path):
    folder = Folder.create(tmp_path / "r")
    (tmp_path / "r" / "front.csv").mkdir()
    with pytest.raises(StoreError, match="cannot be written"):
        folder.write_text("front.csv", "text")


@pytest.mark.slow
def test_readers_never_see_half_a_file(tmp_path):
    """A writer replaces a file of 2 MB over and over; whoever reads meanwhile finds one whole version."""
    code = (
        "from pathlib import Path; import sys; from tuner.store.folder import Folder\n"
        "folder = Folder.open(Path(sys.argv[1])); print('begun', flush=True)\n"
        "for i in range(400): folder.write_text('big', str(i % 10) * 2_000_000)"
    )
    Folder.create(tmp_path / "r").close()
    process = subprocess.Popen([sys.executable, "-c", code, str(tmp_path / "r")], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "begun\n"
    seen, end = set(), time.monotonic() + 1.5
    while time.monotonic() < end:
        if (tmp_path / "r" / "big").exists():
            text = (tmp_path / "r" / "big").read_text()
            assert len(text) == 2_000_000 and len(set(text)) == 1
            seen.add(text[0])
    process.kill()
    process.wait()
    process.stdout.close()
    assert len(seen) > 1
