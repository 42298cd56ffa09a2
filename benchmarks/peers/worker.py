"""One contestant in a process of its own and its own environment: reads a request a line, answers with what it took.

`python -m benchmarks.peers.worker NAME COURSE.npz SCRATCH`; a request is {"batch": 64, "periods": 100}; the first
request of a size prepares and flies once to warm up, each request flies once more and is timed.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any

from benchmarks.course import SUBSTEPS, read
from benchmarks.measuring import peak_memory, spent
from benchmarks.peers.contestant import CONTESTANTS, Work


def serve(name: str, file: Path, scratch: Path) -> None:
    """Answer requests until there are none."""
    answers = os.fdopen(os.dup(1), "w")
    # What libraries print must not get between the answers.
    os.dup2(2, 1)
    os.environ["TUNER_CACHE_DIR"] = str(scratch / "kernels")
    contestant = next(entry for entry in CONTESTANTS if entry.name == name)
    course, prepared = read(file), dict[tuple[int, int], Work]()
    for line in sys.stdin:
        asked = json.loads(line)
        answer: dict[str, Any] = {}
        size = (asked["batch"], asked["periods"])
        try:
            if size not in prepared:
                prepared.clear()

                def ready(size: tuple[int, int] = size) -> None:
                    prepared[size] = contestant.prepare()(course, *size, contestant.threads, scratch)
                    prepared[size]()

                took = spent(ready)
                answer |= {"ready_wall": took.wall, "ready_busy": took.busy}
            took = spent(prepared[size])
            answer |= {
                "wall": took.wall,
                "busy": took.busy,
                "steps": size[0] * size[1] * SUBSTEPS,
                "peak_mb": peak_memory(),
            }
        except Exception as error:  # noqa: BLE001
            answer = {"error": f"{type(error).__name__}: {error}".splitlines()[0][:300]}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    serve(sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3]))
