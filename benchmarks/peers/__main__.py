"""`python -m benchmarks.peers --json benchmarks/results/peers.json`: fly the course with everyone, in turns; one table.

Installs what a peer needs into a folder of its own under --envs, never into this environment. Writes the table beside the JSON as
.md and .csv.
"""

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.course import draw
from benchmarks.measuring import RESULTS, machine, write_json
from benchmarks.peers.contestant import CONTESTANTS, Contestant
from benchmarks.peers.environments import ROOT, NotInstalled, python_of
from benchmarks.peers.race import Runner, race
from benchmarks.peers.table import markdown, ratio_rows, speed_rows, write_csv

BATCHES = [1, 64, 1024, 65_536]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, default=RESULTS / "peers.json")
    parser.add_argument("--envs", type=Path, default=ROOT / ".benchmarks", help="where environments of peers live")
    parser.add_argument("--only", nargs="*", help="names of contestants", choices=[entry.name for entry in CONTESTANTS])
    parser.add_argument("--batches", nargs="*", type=int, default=BATCHES, help="1 to 64, or multiples of 64")
    parser.add_argument("--rounds", type=int, default=5)
    chosen = parser.parse_args()
    entries = [entry for entry in CONTESTANTS if not chosen.only or entry.name in chosen.only]
    document = run(entries, chosen.envs.resolve(), chosen.batches, chosen.rounds, chosen.json)
    print(markdown(document))


def run(entries: list[Contestant], envs: Path, batches: list[int], rounds: int, file: Path) -> dict[str, Any]:
    """Race the contestants and return the document, which is written anew after every round."""
    where, course, left_out = machine(), draw(), dict[str, str]()
    with TemporaryDirectory() as folder:
        scratch = Path(folder)
        course.save(scratch / "course.npz")
        runners = []
        for entry in entries:
            try:
                runners.append(
                    Runner.begin(
                        entry, python_of(entry.environment, entry.requires, envs), scratch / "course.npz", scratch
                    )
                )
            except NotInstalled as error:
                left_out[entry.name] = str(error)

        def document() -> dict[str, Any]:
            failed = {
                f"{runner.contestant.name}, batch {batch}": why
                for runner in runners
                for batch, why in runner.failed.items()
            }
            return {
                "machine": where,
                "rounds": rounds,
                "ratios": ratio_rows(runners, batches),
                "speeds": speed_rows(runners),
                "notes": {entry.name: entry.note for entry in entries},
                "left_out": left_out | failed,
            }

        def told(what: str) -> None:
            print(what, flush=True)
            write(document(), file)

        try:
            race(runners, batches, rounds, course, told)
        finally:
            for runner in runners:
                runner.end()
    return document()


def write(document: dict[str, Any], file: Path) -> None:
    """Write the document and its two tables."""
    write_json(file, document)
    file.with_suffix(".md").write_text(markdown(document), encoding="utf-8")
    write_csv(file.with_suffix(".csv"), document["speeds"])


if __name__ == "__main__":
    main()
