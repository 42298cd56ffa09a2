"""The key of a compiled kernel changes with every source that its machine code depends on, records without functions included."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from plant.backends.cache import fingerprint

ROOT = Path(__file__).parents[3]

# Functions of the closed loop, and the modules that only say which fields a record has and in which order: loads are
# by position, so an old kernel would read the new order wrongly.
SOURCES = (
    "objectives/meters.py",
    *(f"plant/{name}.py" for name in ("primitives", "records", "sample", "vectors")),
    *(f"plant/quadrotor/{name}.py" for name in (
        "allocation", "attitude", "cascade", "closed_loop", "disturbance", "integrator", "nominal", "rigid_body", "sample",
        "sensors", "vehicle",
    )),
    *(f"plant/laws/{name}.py" for name in ("channel", "hybrid", "ladrc", "observer", "surface")),
    "plant/references/track.py",
    *(f"plant/backends/{name}.py" for name in ("lanes", "vector_math")),
)  # fmt: skip

KEYS = """
import sys
from pathlib import Path

from plant.backends.cache import fingerprint
sys.path.insert(0, ".")
from plant.backends import lanes
from tests.plant.harness import loop_of

def key():
    lanes._MODULES.clear()  # as in a new process
    return lanes.kernel_of(loop_of("ladrc", "hybrid")).run.__module__

unedited = key()
assert key() == unedited
for name in sys.argv[1:]:
    file = Path(name)
    text = file.read_bytes()
    file.write_bytes(text + b"# edited\\n")
    if key() == unedited:
        print(name)
    file.write_bytes(text)
assert key() == unedited
"""


@pytest.mark.slow
def test_an_edit_of_any_source_of_the_kernel_changes_its_key(tmp_path: Path) -> None:
    for package in ("plant", "objectives", "tuner", "tests/plant"):
        shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
    command = [sys.executable, "-B", "-c", KEYS, *SOURCES]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == []


def test_a_source_has_the_same_key_in_any_folder(tmp_path: Path) -> None:
    """A study that is copied, or reached by a relative path, flies the kernel that is there."""
    keys = []
    for folder in ("a", "c"):
        files = {tmp_path / folder / "motor.py": "torque = 1", tmp_path / "b" / "meters.py": "peak = 2"}
        for file, text in files.items():
            file.parent.mkdir(exist_ok=True)
            file.write_text(text, encoding="utf-8")
        keys.append(fingerprint("", files))
    assert keys[0] == keys[1]
    (tmp_path / "c" / "motor.py").write_text("peak = 2", encoding="utf-8")
    (tmp_path / "b" / "meters.py").write_text("torque = 1", encoding="utf-8")
    assert fingerprint("", files) != keys[0]
