"""`python -m benchmarks.search`: race the tool's searches and those of other packages, and write one table and one figure.

Runs that the document has are kept, so a race that was stopped goes on. The tool's own searches are raced anew by
`--contestant NAME --again` while the peers' runs stay, each with the revision it was measured at. Peers are installed into a
folder of their own under --envs, never into this environment. The default of an earlier revision is raced in a clone of
that revision, by `--contestant auto --out FILE`, and `--before FILE` takes its runs from there.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.measuring import RESULTS, machine, write_json
from benchmarks.peers.environments import ROOT, NotInstalled
from benchmarks.search.contestants import AUTO, CONTESTANTS
from benchmarks.search.figure import draw_figure
from benchmarks.search.problems import FLIGHTS, PROBLEMS, RACED, VALIDATION, Course
from benchmarks.search.race import raced
from benchmarks.search.table import markdown
from plant.errors import InputError
from tuner.store.environment import commit

SEEDS = (2025, 2026, 2027, 2028, 2029)


class Key(NamedTuple):
    """Name of a run."""

    problem: str
    contestant: str
    seed: int

    @classmethod
    def of(cls, run: dict[str, Any]) -> "Key":
        """Return the key of a run on record."""
        return cls(*(run[field] for field in cls._fields))


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print the document in place of the table")
    parser.add_argument("--validation", action="store_true", help="the problems on which no search was developed")
    parser.add_argument("--problem", action="append", choices=PROBLEMS, help="all of them unless given")
    parser.add_argument("--contestant", action="append", help="a name or the beginning of names; all unless given")
    parser.add_argument("--seed", action="append", type=int, help="2025 to 2029 unless given")
    parser.add_argument("--again", action="store_true", help="race those that the document has, too")
    parser.add_argument("--table", action="store_true", help="race nobody: write table and figure of the document")
    parser.add_argument("--before", type=Path, help="document of a race in a clone of an earlier revision")
    parser.add_argument("--out", type=Path, help="results/search.json, or search_validation.json, unless given")
    parser.add_argument("--envs", type=Path, default=ROOT / ".benchmarks", help="where environments of peers live")
    chosen = parser.parse_args()
    chosen.out = chosen.out or RESULTS / ("search_validation.json" if chosen.validation else "search.json")
    document = on_record(chosen.out)
    if chosen.before:
        document["runs"] = with_before(document["runs"], on_record(chosen.before)["runs"])
        write_json(chosen.out, document)
    if not chosen.table:
        known = set() if chosen.again else {Key.of(run) for run in document["runs"] if run["entries"]}
        for key, course in wanted(chosen, known):
            told = run(key, course, chosen.envs.resolve())
            document["runs"] = [entry for entry in document["runs"] if Key.of(entry) != key] + [told]
            write_json(chosen.out, document)
            last = told["entries"][-1] if told["entries"] else None
            print(*key, last or told["stopped"], flush=True)
    text = markdown(document["runs"])
    chosen.out.with_suffix(".md").write_text(text, encoding="utf-8")
    draw_figure(document["runs"], chosen.out.with_suffix(".png"))
    print(json.dumps(document) if chosen.json else text)


def on_record(file: Path) -> dict[str, Any]:
    """Return the document as far as it was written."""
    runs = json.loads(file.read_text(encoding="utf-8")).get("runs", []) if file.exists() else []
    return {"machine": machine(), "held_out_flights": FLIGHTS, "runs": runs}


def with_before(runs: list[dict[str, Any]], before: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return runs with those of the default of an earlier revision, named by it."""
    named = [
        {**run, "contestant": f"{AUTO} at {run['revision'].removesuffix('-dirty')}"}
        for run in before
        if run["contestant"] == AUTO
    ]
    taken = {Key.of(run) for run in named}
    return [run for run in runs if Key.of(run) not in taken] + named


def wanted(chosen: argparse.Namespace, known: set[Key]) -> Iterator[tuple[Key, Course]]:
    """Yield the runs that are asked for and not known, seed after seed, so that a part of the race is one of all problems."""
    names = [name for name in CONTESTANTS if any(_meant(name, given) for given in chosen.contestant or [""])]
    for seed in chosen.seed or SEEDS:
        for problem in chosen.problem or (VALIDATION if chosen.validation else RACED):
            keys = [key for name in names if (key := Key(problem, name, seed)) not in known]
            course = Course(problem, seed) if keys else None
            for key in keys:
                if course and CONTESTANTS[key.contestant].takes(course.objectives):
                    yield key, course


def _meant(name: str, given: str) -> bool:
    """Return whether a contestant is asked for: by its name, or by the beginning of it where that is nobody's name."""
    return name == given if given in CONTESTANTS else name.startswith(given)


def run(key: Key, course: Course, envs: Path) -> dict[str, Any]:
    """Return the run of a contestant, or why there is none."""
    try:
        found = raced(CONTESTANTS[key.contestant], course, envs).document()
    except (NotInstalled, InputError) as error:
        found = {"entries": [], "front": [], "stopped": f"left out: {error}"}
    where = machine()
    return {
        **key._asdict(),
        "revision": commit(),
        "processor": where["processor"],
        "default": course.default.tolist(),
        **found,
    }


if __name__ == "__main__":
    main()
