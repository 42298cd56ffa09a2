"""`python -m benchmarks.search.published`: play published problems, write every run, print scores.

Runs that the document has are not repeated, so a command that was stopped goes on.
"""

import argparse
import json
from pathlib import Path
from typing import NamedTuple

from benchmarks.measuring import RESULTS
from benchmarks.search.published.play import MARKS, PublishedRun, SearchFactory, play
from benchmarks.search.published.suite import SUITE
from tuner.search.bayesian_optimization import BayesianOptimization, warm_up

CONTESTANTS: dict[str, SearchFactory] = {"ours": BayesianOptimization}


class RunKey(NamedTuple):
    """Name of a run."""

    problem: str
    contestant: str
    seed: int


Runs = dict[RunKey, PublishedRun]


def read_runs(file: Path) -> Runs:
    """Return the runs of a document."""
    if not file.exists():
        return {}
    runs = json.loads(file.read_text(encoding="utf-8"))["runs"]
    return {RunKey(*(run.pop(field) for field in RunKey._fields)): PublishedRun(**run) for run in runs}


def write_runs(file: Path, runs: Runs) -> None:
    """Write a document, a run a line."""
    lines = [json.dumps(key._asdict() | run._asdict()) for key, run in sorted(runs.items())]
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text('{"runs": [\n' + ",\n".join(lines) + "\n]}\n", encoding="utf-8")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--contestant", action="append", choices=CONTESTANTS, help="all unless given")
    parser.add_argument("--label", default="gaussian_process", help="name in the document of the tool's search")
    parser.add_argument("--problem", action="append", choices=SUITE, help="all unless given")
    parser.add_argument("--seed", action="append", type=int, help="1 unless given")
    parser.add_argument("--again", action="store_true", help="play those that the document has, too")
    parser.add_argument("--out", type=Path, default=RESULTS / "search_published.json")
    chosen = parser.parse_args()
    warm_up()
    print("problem contestant seed", *MARKS, "seconds")
    for seed in chosen.seed or [1]:
        for name in chosen.contestant or CONTESTANTS:
            for problem in chosen.problem or SUITE:
                key = RunKey(problem, chosen.label if name == "ours" else name, seed)
                runs = read_runs(chosen.out)
                if key not in runs or chosen.again:
                    runs[key] = play(CONTESTANTS[name], problem, seed)
                    write_runs(chosen.out, runs)
                run = runs[key]
                print(*key, *map(run.score_at, MARKS), f"{run.seconds:.1f} {run.stopped}", flush=True)


if __name__ == "__main__":
    main()
