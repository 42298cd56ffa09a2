"""Archives that are damaged, and what a killed process leaves of one."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from plant.errors import InputError
from tests.tuner.extensions.fmu.fmus import write_archive
from tuner.extensions.fmu.archive import LOCK, PREFIX, open_archive, remove_abandoned, unpacked

CONTENT = {"modelDescription.xml": b"<fmiModelDescription/>" * 40, "binaries/linux64/motor.so": b"code" * 100}


@pytest.mark.parametrize("fewer", [1, 20, 36, 100, 400])
def test_an_archive_cut_at_its_end_is_one_line(fewer, tmp_path):
    file = write_archive(tmp_path / "motor.fmu", CONTENT)
    file.write_bytes(file.read_bytes()[:-fewer])
    with pytest.raises(InputError, match="no archive that can be read"):
        open_archive(file)


@pytest.mark.parametrize("fewer", range(2, 80, 6))
def test_bytes_taken_out_of_an_archive_are_one_line(fewer, tmp_path):
    file = write_archive(tmp_path / "motor.fmu", CONTENT)
    whole = file.read_bytes()
    file.write_bytes(whole[fewer:])
    try:
        archive = open_archive(file)
        _ = archive.description
        unpacked(file, archive.digest)
    except InputError:
        pass


def test_the_folder_of_a_killed_process_goes_with_the_next_and_that_of_a_living_one_stays(tmp_path, monkeypatch):
    file = write_archive(tmp_path / "motor.fmu", CONTENT)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    code = (
        "import sys, time; from pathlib import Path; from tuner.extensions.fmu.archive import open_archive, unpacked\n"
        "file = Path(sys.argv[1]); print(unpacked(file, open_archive(file).digest), flush=True); time.sleep(60)"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(file)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )
    assert process.stdout is not None
    folder = Path(process.stdout.readline().strip())
    assert folder.parent == tmp_path and folder.name.startswith(PREFIX)
    remove_abandoned()
    assert (folder / "modelDescription.xml").exists()
    process.kill()
    process.wait()
    process.stdout.close()
    assert folder.exists()
    remove_abandoned()
    assert not folder.exists()


def test_a_link_in_place_of_a_lock_is_left_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "mine").write_text("mine")
    (tmp_path / f"{PREFIX}a").mkdir()
    (tmp_path / f"{PREFIX}a" / LOCK).symlink_to(tmp_path / "mine")
    (tmp_path / f"{PREFIX}b").symlink_to(tmp_path)
    remove_abandoned()
    assert (tmp_path / "mine").read_text() == "mine" and (tmp_path / f"{PREFIX}a").exists()
