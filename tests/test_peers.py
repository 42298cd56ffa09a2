"""Peers of the benchmark fly in processes of their own: what they import, and why they fail."""

import subprocess
import sys

from benchmarks.peers.contestant import CONTESTANTS
from benchmarks.peers.race import Runner


def test_a_worker_needs_no_package_of_the_person_s_side():
    code = (
        "import sys; sys.modules.update(dict.fromkeys(('pydantic', 'casadi', 'pandas', 'typer', 'rich')))\n"
        "import benchmarks.peers.worker"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_worker_that_ends_is_left_out_with_its_last_message(tmp_path):
    runner = Runner.begin(CONTESTANTS[0], sys.executable, tmp_path / "no_course.npz", tmp_path)
    runner.fly(64, 5)
    runner.end()
    assert "no_course.npz" in runner.failed[64] and runner.failed[64].startswith("FileNotFoundError")
