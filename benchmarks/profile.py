"""`python -m benchmarks.profile STUDY`: where the wall time of a run goes, as a table.

A thread looks at the main thread's stack every few milliseconds and books the time since its last look on the innermost
frame that has a stage of its own. Nothing is patched, so nothing runs differently; the kernels give the lock away, so
waiting for flights is seen as flights. Figures are drawn by another process: what is booked on them is what the run waits
for them.
"""

import argparse
import sys
from collections import defaultdict
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event, Thread
from time import perf_counter, process_time
from types import FrameType
from typing import Any

from benchmarks.measuring import RESULTS, machine, write_json

EVERY = 0.004
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
            if part in file and "/benchmarks/" not in file:
                return stage
        frame = frame.f_back
    return "start and end of the process"


class Sampler:
    """Books the wall time of the thread that made it on stages."""

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self._watched, self._stop = _own_identity(), Event()
        self._thread = Thread(target=self._look, daemon=True)

    def __enter__(self) -> "Sampler":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def _look(self) -> None:
        last = perf_counter()
        while not self._stop.wait(EVERY):
            frame = sys._current_frames().get(self._watched)
            now = perf_counter()
            self.seconds[stage_of(frame)] += now - last
            last = now


def _own_identity() -> int:
    from threading import get_ident

    return get_ident()


def profile(study: Path, changes: list[str], threads: int | None) -> dict[str, Any]:
    """Run a study into a folder that is thrown away and return seconds a stage."""
    with TemporaryDirectory() as folder:
        command = ["tuner", "run", str(study), "--out", str(Path(folder) / "results"), "--json"]
        command += [word for change in changes for word in ("--set", change)]
        command += [] if threads is None else ["--threads", str(threads)]
        arguments, sys.argv = sys.argv, command
        wall, busy = perf_counter(), process_time()
        try:
            with Sampler() as sampler:
                _run()
        finally:
            sys.argv = arguments
        wall, busy = perf_counter() - wall, process_time() - busy
    seconds = dict(sorted(sampler.seconds.items(), key=lambda entry: -entry[1]))
    return {"study": study.stem, "changes": changes, "wall": wall, "busy": busy, "seconds": seconds}


def _run() -> None:
    from tuner.cli.main import main

    try:
        main()
    except SystemExit as ended:
        if ended.code not in (0, None):
            raise


def table(found: dict[str, Any]) -> str:
    """Return the table for people."""
    title = " ".join([found["study"], *found["changes"]])
    lines = [
        f"### {title}: {found['wall']:.1f} s of wall time, {found['busy']:.1f} s of processor time", "",
        "| stage | wall [s] | share |", "|---|---:|---:|",
    ]  # fmt: skip
    total = sum(found["seconds"].values())
    lines += [f"| {stage} | {each:.2f} | {100 * each / total:.1f} % |" for stage, each in found["seconds"].items()]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=Path)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="changes")
    parser.add_argument("--threads", type=int)
    chosen = parser.parse_args()
    found = profile(chosen.study, chosen.changes, chosen.threads)
    write_json(RESULTS / f"profile_{chosen.study.stem}.json", {"machine": machine()} | found)
    print(table(found), file=sys.stderr)


if __name__ == "__main__":
    main()
