"""`python -m benchmarks.search.published`: play published problems, write every run and the tables.

Runs that the document has are not repeated, so a command that was stopped goes on.
"""

import argparse
import json
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from benchmarks.measuring import RESULTS
from benchmarks.peers.environments import ROOT, NotInstalled
from benchmarks.search.published.contestants import CONTESTANTS, OURS
from benchmarks.search.published.play import MARKS, PublishedRun, RunKey, play
from benchmarks.search.published.suite import SUITE
from benchmarks.search.published.table import TOOL, Runs, markdown
from tuner.search.bayesian_optimization import warm_up


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


def play_contestant(key: RunKey, name: str, envs: Path) -> PublishedRun:
    """Return the run of a contestant, without scores where its environment cannot be made."""
    contestant = CONTESTANTS[name]
    with ExitStack() as stack:
        start = partial(contestant.start, stack, envs)
        try:
            return play(start, key.problem, key.seed, max_seconds=contestant.max_seconds)
        except NotInstalled as error:
            return PublishedRun([], 0.0, f"not installed: {error}")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--contestant", action="append", choices=CONTESTANTS, help="all unless given")
    parser.add_argument("--label", default=TOOL, help=f'name in the document of "{OURS}"')
    parser.add_argument("--problem", action="append", choices=SUITE, help="all unless given")
    parser.add_argument("--seed", action="append", type=int, help="1 unless given")
    parser.add_argument("--again", action="store_true", help="play those that the document has, too")
    parser.add_argument("--out", type=Path, default=RESULTS / "search_published.json")
    parser.add_argument("--envs", type=Path, default=ROOT / ".benchmarks", help="folder of the environments of peers")
    parser.add_argument("--table", action="store_true", help="play nothing: write the table of the document")
    parser.add_argument("--baseline", default=f"{TOOL} at f52a461d", help="revision that the label is compared with")
    chosen = parser.parse_args()
    if not chosen.table:
        play_missing(chosen)
    text = markdown(read_runs(chosen.out), chosen.label, chosen.baseline)
    chosen.out.with_suffix(".md").write_text(text, encoding="utf-8")
    print(text)


def play_missing(chosen: argparse.Namespace) -> None:
    """Play what a command line asks for and the document lacks."""
    warm_up()
    for seed in chosen.seed or [1]:
        for name in chosen.contestant or CONTESTANTS:
            for problem in chosen.problem or SUITE:
                suited = CONTESTANTS[name].is_suited(SUITE[problem].n_objectives, SUITE[problem].n_constraints)
                key = RunKey(problem, name.replace(OURS, chosen.label), seed)
                runs = read_runs(chosen.out)
                if suited and (key not in runs or chosen.again):
                    run = play_contestant(key, name, chosen.envs.resolve())
                    # Another command may have written meanwhile.
                    write_runs(chosen.out, read_runs(chosen.out) | {key: run})
                    print(*key, *map(run.score_at, MARKS), f"{run.seconds:.1f} s", run.stopped, flush=True)


if __name__ == "__main__":
    main()
