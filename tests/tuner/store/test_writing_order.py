"""What a kill or a power cut leaves behind: the order in which a file is written, synced and renamed, and the time it took."""

import os
from pathlib import Path

import pytest

from plant.output_files import ASIDE
from tuner.store import clock as clock_module
from tuner.store.clock import Clock
from tuner.store.folder import Folder


@pytest.fixture
def seen(monkeypatch):
    """Every fsync and rename in order, as ("synced", path, bytes in it) and ("renamed", from, to)."""
    events, sync, replace = [], os.fsync, Path.replace

    def recorded_sync(handle):
        path = Path(os.readlink(f"/proc/self/fd/{handle}"))
        events.append(("synced", path, path.read_bytes() if path.is_file() else None))
        sync(handle)

    def recorded_replace(self, target):
        events.append(("renamed", self, Path(target)))
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", recorded_sync)
    monkeypatch.setattr(Path, "replace", recorded_replace)
    return events


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="names of open files are read from /proc")
@pytest.mark.parametrize("name", ["summary.json", "generations/0001.npz", "deep/er/front.csv"])
def test_a_file_is_on_the_disk_before_its_name_and_its_name_before_the_next(tmp_path, seen, name):
    folder = Folder.create(tmp_path / "run")
    # The first file of a folder has the manifest of an unfinished one written before it.
    folder.write_bytes("before", b"")
    seen.clear()
    folder.write_bytes(name, b"all of it")
    file = tmp_path / "run" / name
    aside = file.with_name(f".{file.name}{ASIDE}")
    assert seen == [("synced", aside, b"all of it"), ("renamed", aside, file), ("synced", file.parent, None)]
    folder.close()


@pytest.fixture
def at(monkeypatch):
    """Set the time that a clock reads [s]."""
    now = [1000.0]
    monkeypatch.setattr(clock_module, "perf_counter", lambda: now[0])

    def set_to(seconds):
        now[0] = 1000.0 + seconds

    return set_to


def test_what_was_replayed_counts_as_long_as_it_took_when_it_was_flown(at):
    """A generation that took 100 s is replayed in 2 s; then the search goes on for 5 s and meets one that took 103 s in all."""
    clock = Clock()
    at(2.0)
    assert clock.now() == 2.0
    clock.at_least(100.0)
    assert clock.now() == 100.0
    at(7.0)
    assert clock.now() == 105.0
    # What was reached already takes nothing back, and a second jump adds to the first.
    clock.at_least(103.0)
    assert clock.now() == 105.0
    clock.at_least(110.0)
    at(8.0)
    assert clock.now() == 111.0
