"""`python -m benchmarks.studio_soak`: memory of one process of `tuner.studio` over as many moves as an hour by hand makes.

Three studios answer 3,600 moves, each with all its stages of 16, 64 and 256 flights, over HTTP as a page asks for them. A move
changes one gain at random within its range, now and then with a pin. The resident memory of the process is read at every tenth.
"""

import argparse
import json
import random
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPConnection
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any
from urllib.parse import urlsplit

from benchmarks.measuring import RESULTS, machine, write_json

STUDIES = ("quickstart", "dc_motor", "heater")
N_MOVES, N_PARTS = 3600, 10
"""Moves of all studios together, and parts after which the memory is read."""
MAX_MEMORY = 700.0
"""Allowed resident memory at the end [MB]."""
PROGRAM = "import sys, tuner; pages = [tuner.studio(name) for name in sys.argv[1:]]; sys.stdin.read()"


class Page:
    """Moves of one studio, as its page sends them."""

    def __init__(self, address: str, seed: int) -> None:
        self._split, self._rng, self.number = urlsplit(address), random.Random(seed), 0
        self.opened = self.post("/open", {})[-1]
        self.values = {gain["name"]: gain["start"] for gain in self.opened["gains"]}
        self.seconds: list[float] = []

    def post(self, path: str, content: dict[str, Any]) -> list[dict[str, Any]]:
        """Return the lines of an answer."""
        assert self._split.hostname is not None, "an address of the studio"
        connection = HTTPConnection(self._split.hostname, self._split.port, timeout=600)
        headers = {"Content-Type": "application/json"}
        connection.request("POST", f"{path}?{self._split.query}", json.dumps(content), headers)
        lines = [json.loads(line) for line in connection.getresponse().read().splitlines()]
        connection.close()
        return lines

    def move(self) -> None:
        """Move one gain, and take the whole answer."""
        gain = self._rng.choice(self.opened["gains"])
        self.values |= {gain["name"]: self._rng.uniform(gain["low"], gain["high"])}
        self.number += 1
        pins = [{"name": "pin", "values": self.values}] if self.number % 10 == 0 else []
        channel = self._rng.choice(self.opened["channels"])
        content = {"number": self.number, "page": "soak", "values": self.values, "pins": pins, "channel": channel}
        begin = perf_counter()
        last = self.post("/answer", content)[-1]
        self.seconds.append(perf_counter() - begin)
        assert last.get("last"), f"no full answer: {str(last)[:200]}"


def memory(process: int) -> float:
    """Return the resident memory of a process [MB]."""
    text = Path(f"/proc/{process}/status").read_text(encoding="utf-8")
    return int(text.partition("VmRSS:")[2].split()[0]) / 1024.0


def soak(moves: int) -> float:
    """Return the memory [MB] of a process with three studios after so many moves."""
    command = [sys.executable, "-c", PROGRAM, *STUDIES]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8") as process:
        assert process.stdout is not None and process.stdin is not None, "both are pipes"
        addresses = [process.stdout.readline().split()[-1] for _ in STUDIES]
        pages = [Page(address, seed) for seed, address in enumerate(addresses)]
        sizes = [memory(process.pid)]
        print(f"opened: {sizes[0]:.0f} MB", flush=True)
        with ThreadPoolExecutor(len(pages)) as pool:
            for part in range(1, N_PARTS + 1):
                each = moves // N_PARTS // len(pages)
                list(pool.map(lambda page, each=each: [page.move() for _ in range(each)], pages))
                sizes.append(memory(process.pid))
                print(f"{10 * part} %: {sizes[-1]:.0f} MB", flush=True)
                write(pages, sizes)
        process.stdin.close()
    return sizes[-1]


def write(pages: Sequence[Page], sizes: Sequence[float]) -> None:
    """Write the result so far: a soak that is interrupted leaves its part."""
    document = {
        "machine": machine(),
        "moves": sum(page.number for page in pages),
        "memory_mb": [round(size, 1) for size in sizes],
        "seconds": {name: round(median(page.seconds), 3) for name, page in zip(STUDIES, pages, strict=True)},
    }
    write_json(RESULTS / "studio_soak.json", document)


def main() -> None:
    """Soak and check the memory."""
    parser = argparse.ArgumentParser(description="Memory of the studio over an hour's moves.")
    parser.add_argument("--moves", type=int, default=N_MOVES)
    size = soak(parser.parse_args().moves)
    assert size <= MAX_MEMORY, f"{size:.0f} MB; allowed: {MAX_MEMORY:.0f} MB"


if __name__ == "__main__":
    main()
