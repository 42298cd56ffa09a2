"""`python -m benchmarks.profile STUDY`: where the time of a run goes, as a table.

A thread looks at the main thread's stack every few milliseconds and books the time since its last look on the innermost
frame that has a stage of its own. Nothing is patched, so nothing runs differently; the kernels give the lock away, so
waiting for flights is seen as flights. Figures are drawn by another process: what is booked on them is what the run waits
for them, and the processor time of that process stands in a line of its own.

Whoever has PYTHONDONTWRITEBYTECODE set has every file compiled anew that has no bytecode, some 0.7 ms of imports each. Here
bytecode is written, and the number of files that were compiled all the same stands below the table: profile once more then.

Neighbours stretch wall time, so processor time is booked too, of the main thread and of the whole process. A stage takes at
least the larger of the first and of the second shared by two cores: that sum is what an idle machine with two cores would take.
"""

import argparse
import os
import sys
from collections import defaultdict
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from tempfile import TemporaryDirectory
from threading import Event, Thread, get_ident
from time import clock_gettime, perf_counter, process_time, pthread_getcpuclockid
from types import FrameType
from typing import Any, NamedTuple

from benchmarks.measuring import RESULTS, machine, write_json

EVERY, CORES = 0.004, 2
STAGES: tuple[tuple[str, str], ...] = (
    ("importlib._bootstrap", "imports"),
    ("/numba/", "compiling"),
    ("/plant/air/", "drawing the air"),
    ("/plant/sensors.py", "drawing the air"),
    ("/plant/scenarios.py", "drawing the air"),
    ("/plant/seeds.py", "drawing the air"),
    ("/plant/backends/flyer.py", "flights"),
    ("/objectives/engine.py", "flights"),
    ("/objectives/margins/", "margins"),
    ("/tuner/analysis/margins/", "margins"),
    ("/tuner/report/drawing.py", "figures"),
    ("/tuner/report/figures.py", "figures"),
    ("figures.py", "figures"),
    ("/tuner/report/", "report"),
    ("/tuner/search/", "search"),
    ("/tuner/store/", "results folder"),
    ("/objectives/memory.py", "results folder"),
    ("/objectives/metrics/", "statistics"),
    ("/objectives/risk/", "statistics"),
    ("/objectives/racing.py", "statistics"),
    ("/objectives/problem.py", "statistics"),
    ("/objectives/meters.py", "statistics"),
    ("/tuner/", "the rest of the run"),
    ("/plant/", "the rest of the run"),
    ("/objectives/", "the rest of the run"),
)
"""Part of a file's path and the stage it stands for; the first that fits counts."""


def stage_of(frame: FrameType | None) -> str:
    """Return the stage of the innermost frame that has one."""
    while frame is not None:
        file = frame.f_code.co_filename.replace("\\", "/")
        for part, stage in STAGES:
            # What waits for tasks side by side belongs to who gave them.
            if part in file and "/benchmarks/" not in file and not file.endswith("/plant/threads.py"):
                return stage
        frame = frame.f_back
    return "start and end of the process"


class Times(NamedTuple):
    """Seconds: by the clock, of processor time of the main thread, and of all threads of the process."""

    wall: float
    main: float
    all: float

    @property
    def idle(self) -> float:
        """Seconds that an idle machine with two cores would take at least."""
        return max(self.main, self.all / CORES)

    def since(self, earlier: "Times") -> "Times":
        """Return what went by."""
        return Times(*[now - before for now, before in zip(self, earlier, strict=True)])

    def plus(self, other: "Times") -> "Times":
        """Return the sum."""
        return Times(*[one + more for one, more in zip(self, other, strict=True)])


NOTHING = Times(0.0, 0.0, 0.0)


class Sampler:
    """Books the times of the thread that made it on stages."""

    def __init__(self) -> None:
        self.stages: defaultdict[str, Times] = defaultdict(lambda: NOTHING)
        self._watched, self._stop = get_ident(), Event()
        self._clock = pthread_getcpuclockid(self._watched)
        self._thread = Thread(target=self._look, daemon=True)

    def __enter__(self) -> "Sampler":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def _now(self) -> Times:
        return Times(perf_counter(), clock_gettime(self._clock), process_time())

    def _look(self) -> None:
        last = self._now()
        while not self._stop.wait(EVERY):
            stage = stage_of(sys._current_frames().get(self._watched))
            now = self._now()
            self.stages[stage] = self.stages[stage].plus(now.since(last))
            last = now


class CompiledFiles:
    """Files of Python that were compiled from their source, for lack of bytecode."""

    def __init__(self) -> None:
        self.names: set[str] = set()
        sys.addaudithook(self._hear)

    def _hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        if event == "compile" and str(arguments[1]).endswith(".py"):
            self.names.add(str(arguments[1]))


def profile(study: Path, changes: list[str], threads: int | None) -> dict[str, Any]:
    """Run a study into a folder that is thrown away and return the times of each stage."""
    compiled = CompiledFiles()
    with TemporaryDirectory() as folder:
        command = ["tuner", "run", str(study), "--out", str(Path(folder) / "results"), "--json"]
        command += [word for change in changes for word in ("--set", change)]
        command += [] if threads is None else ["--threads", str(threads)]
        arguments, sys.argv = sys.argv, command
        try:
            with Sampler() as sampler:
                _run()
        finally:
            sys.argv = arguments
    stages = dict(sorted(sampler.stages.items(), key=lambda entry: -entry[1].idle))
    used = getrusage(RUSAGE_CHILDREN)
    return {
        "study": study.stem,
        "changes": changes,
        "compiled": len(compiled.names),
        "beside": used.ru_utime + used.ru_stime,
        "stages": {stage: {**times._asdict(), "idle": times.idle} for stage, times in stages.items()},
    }


def _run() -> None:
    from tuner.cli.main import main

    try:
        main()
    except SystemExit as ended:
        if ended.code not in (0, None):
            raise


COLUMNS = ("idle", "main", "all", "wall")


def table(found: dict[str, Any]) -> str:
    """Return the table for people."""
    stages = found["stages"]
    total = {name: sum(times[name] for times in stages.values()) for name in COLUMNS}
    lines = [
        f"### {' '.join([found['study'], *found['changes']])}",
        "",
        "| stage | two idle cores [s] | main thread [s] | process [s] | wall here [s] |",
        "|---|---:|---:|---:|---:|",
    ]
    rows = [*stages.items(), ("all", total)]
    lines += [f"| {stage} | " + " | ".join(f"{times[name]:.2f}" for name in COLUMNS) + " |" for stage, times in rows]
    lines += ["", f"Processes beside it: {found['beside']:.2f} s of processor time."]
    lines += [f"Files compiled from source: {found['compiled']}."]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=Path)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes")
    parser.add_argument("--threads", type=int)
    chosen = parser.parse_args()
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    found = profile(chosen.study, chosen.changes, chosen.threads)
    write_json(RESULTS / f"profile_{chosen.study.stem}.json", {"machine": machine()} | found)
    print(table(found), file=sys.stderr)


if __name__ == "__main__":
    main()
