"""Run a small study, kill it at an instant as a process of its own, go on with it, and compare what it leaves behind."""

import json
import os
import signal
import subprocess
import sys
import time

from tests.tuner.conftest import QUICKSTART
from tests.tuner.in_process import called
from tuner.store import manifest
from tuner.store.manifest import first_damage, read_manifest

CHANGES = {
    "seed": 1,
    "search.population": 8,
    "search.generations": 5,
    "scenario.0.search": 6,
    "scenario.0.held_out": 32,
    "scenario.0.duration": 2.0,
    "margin": [],
}
# The default search through all of its stages: a model that asks for margins, survivors that make more flights, finalists that stop
# once their place is settled, and an end where the front has come to rest.
STAGES = {
    "search.starts": ["shipped"], "search.population": 8, "search.generations": 24, "search.stop": "converged", "scenario.0.search": 6,
    "scenario.0.held_out": 128, "scenario.0.duration": 2.0, "scenario.0.air.intensity": 2.0, "margin.0.min": 20,
    "margin.1.min": 3, "margin.2.max": 4, "margin.3.min": 0.5,
}  # fmt: skip
CODE = "from tuner.__main__ import run; run()"
# What tells how long something took, and where it was made.
TIMES = ("wall_seconds", "search_seconds")


def command(*arguments):
    return [sys.executable, "-c", CODE, *map(str, arguments)]


def run_arguments(folder, changes=CHANGES):
    sets = [part for key, value in changes.items() for part in ("--set", f"{key}={json.dumps(value)}")]
    return ["run", QUICKSTART, "--out", folder, *sets]


def finish(*arguments, code=0):
    """Run a command to its end in this process, which has imported and compiled everything, and return standard output, error."""
    ended, out, errors = called(*arguments)
    assert ended == code, errors + out
    return out, errors


def finish_elsewhere(*arguments, **named):
    """Run a command to its end as a process of its own, with an environment or a folder of its own, and return what it printed."""
    done = subprocess.run(command(*arguments), capture_output=True, text=True, **{"timeout": 120, **named})
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout


def killed(folder, reached, changes=CHANGES):
    """Start the study and kill it once `reached(seconds)` is true; return whether it was still running then."""
    begin = time.perf_counter()
    process = subprocess.Popen(
        command(*run_arguments(folder, changes)),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    while not reached(time.perf_counter() - begin):
        if process.poll() is not None:
            return False
        time.sleep(0.005)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    return True


def finished_after_kill(folder, reached, changes=CHANGES, threads=None):
    """Kill the study once `reached(seconds)` is true and bring it to its end the way its own messages say, on so many threads."""
    still_running, told = killed(folder, reached, changes), ["--threads", threads] if threads else []
    if not (folder / "run.json").exists():
        # Nothing was recorded yet: the tool says to remove the folder and run again.
        if folder.exists():
            said = finish("resume", folder, code=2)[1]
            assert "nothing was recorded yet, so remove it" in said and "Traceback" not in said
            for file in sorted(folder.rglob("*"), reverse=True):
                file.rmdir() if file.is_dir() else file.unlink()
            folder.rmdir()
        finish(*run_arguments(folder, changes), *told)
    else:
        finish("resume", folder, *told)
    return still_running


def result_of(folder):
    """All that a run leaves behind, as bytes by name, but for times, machine and session."""
    kept = {}
    for file in sorted(path for path in folder.rglob("*") if path.is_file()):
        name = file.relative_to(folder).as_posix()
        if name in ("environment.json", "history.csv", "report.html", "manifest.json", ".lock") or name.startswith(
            "figures/"
        ):
            continue
        content = file.read_bytes()
        if name == "summary.json":
            content = {key: value for key, value in json.loads(content).items() if key not in TIMES}
        kept[name] = content
    return kept


def manifest_of(folder):
    found = read_manifest(folder)
    assert found is not None
    return found


def unsealed(folder):
    """Have a folder say that it was not written to its end."""
    found = manifest_of(folder)
    (folder / manifest.FILE).write_bytes(manifest.manifest_of(False, found.files).text().encode())


def assert_covered(folder):
    """Everything in a new folder is in its manifest, or in that of a folder within."""
    found = manifest_of(folder)
    assert found.complete and first_damage(folder) is None
    within = [file.parent for file in folder.glob(f"contenders/*/{manifest.FILE}")]
    here = {
        file.relative_to(folder).as_posix()
        for file in folder.rglob("*")
        if file.is_file() and not any(file.is_relative_to(other) and file.name != manifest.FILE for other in within)
    }
    assert set(found.files) == here - {manifest.FILE, ".lock"} - {
        f"{other.relative_to(folder)}/.lock" for other in within
    }
    for other in within:
        assert_covered(other)


def assert_sealed(folder, expected):
    """A folder is complete, undamaged and consists of the same files as another; the figures are the same bytes."""
    assert first_damage(folder) is None
    one, other = manifest_of(folder), manifest_of(expected)
    assert one.complete and sorted(one.files) == sorted(other.files)
    drawn = [name for name in one.files if name.startswith("figures/")]
    different = [name for name in drawn if one.files[name] != other.files[name]]
    assert drawn and not different, different


def compare(one, other):
    """Assert that two results are the same, naming what is not."""
    assert sorted(one) == sorted(other)
    assert [name for name in one if one[name] != other[name]] == []


def timed(folder, changes=CHANGES):
    """Run the study as a process of its own and return the seconds that it took."""
    begin = time.perf_counter()
    finish_elsewhere(*run_arguments(folder, changes))
    return time.perf_counter() - begin
