"""The first run of a fresh install, a run from another cache, and one that is killed and resumed leave the same bytes.

Each with margins, whose kernel is compiled as well. With a fresh cache for the resumed session too: pytest -m slow.
"""

import json
import os
import signal
import subprocess

import pytest

from tests.tuner.conftest import QUICKSTART, SMALL
from tests.tuner.experiments.again.killing import command, compare, finish, finish_elsewhere, result_of

CHANGES = {**SMALL, "mission.off": ["rms.position", "rms.yaw"]}
RUN = [part for key, value in CHANGES.items() if key != "margin" for part in ("--set", f"{key}={json.dumps(value)}")]


def fresh(folder):
    """Return an environment of somebody who has never run the tool: an empty home and no kernels."""
    folder.mkdir()
    kept = {name: value for name, value in os.environ.items() if name not in ("TUNER_CACHE_DIR", "XDG_CACHE_HOME")}
    return kept | {"HOME": str(folder), "NUMBA_CACHE_DIR": str(folder)}


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fresh")
    home = fresh(folder / "home")
    finish_elsewhere("run", QUICKSTART, "--out", folder / "r", *RUN, env=home, timeout=400)
    return folder / "r", home


def killed(folder, home):
    """Start the run and kill it as soon as its first generation is recorded."""
    arguments = command("run", QUICKSTART, "--out", folder, *RUN)
    process = subprocess.Popen(
        arguments, env=home, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True
    )
    assert process.stdout is not None
    assert any(line.startswith("generation 1/") for line in process.stdout)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    assert not (folder / "front.csv").exists()


@pytest.mark.slow
def test_the_first_run_gives_the_bytes_of_the_second_and_of_one_killed_and_resumed(first, tmp_path):
    folder, home = first
    assert "requirement:ms" in (folder / "front.csv").read_text().splitlines()[0]
    finish("run", QUICKSTART, "--out", tmp_path / "second", *RUN)
    compare(result_of(tmp_path / "second"), result_of(folder))
    killed(tmp_path / "killed", home)
    finish("resume", tmp_path / "killed")
    compare(result_of(tmp_path / "killed"), result_of(folder))


@pytest.mark.slow
def test_killed_in_one_fresh_install_and_resumed_in_another(first, tmp_path):
    folder, _ = first
    killed(tmp_path / "r", fresh(tmp_path / "one"))
    finish_elsewhere("resume", tmp_path / "r", env=fresh(tmp_path / "other"), timeout=400)
    compare(result_of(tmp_path / "r"), result_of(folder))
