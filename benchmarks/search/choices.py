"""`python -m benchmarks.search.choices`: a search over choices by successive halving beside one search of each combination.

All searches of a seed fly the same flights. The fronts of the whole searches are compared in one box, up to 1.1 times the nadir
of all; the winner has the largest share. Flights are those that every candidate makes, without those of survivors.
"""

import argparse
import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.measuring import RESULTS, machine, write_json
from benchmarks.search.problems import HERE
from tuner.extensions.contests.race import raced, shares, stand
from tuner.extensions.contests.study import Contest
from tuner.search.watcher import Watcher
from tuner.store.environment import commit
from tuner.store.folder import Folder
from tuner.study.kinds import load_any

STUDIES = {"quadrotor": HERE / "studies/laws_of_quadrotor.toml", "motor": HERE / "studies/law_of_motor.toml"}
SEEDS = (2025, 2026, 2027)


def whole_searches(contest: Contest, scratch: Path) -> tuple[dict[str, float], int]:
    """Return the share of each contender after its whole search, and the flights of all."""
    with Folder.create(scratch / "whole", inside="contenders") as folder:
        standings = [
            stand(contest, each, each.study.search.generations, folder, Watcher(), None) for each in contest.contenders
        ]
    names = [each.name for each in contest.contenders]
    return dict(zip(names, shares(standings), strict=True)), sum(entry.flights for entry in standings)


def race(contest: Contest, scratch: Path) -> tuple[str, int]:
    """Return the finalist of a race, and the flights of all its searches."""
    with Folder.create(scratch / "race", inside="contenders") as folder:
        left, rows = raced(contest, folder, Watcher(), None)
        (last,) = left.contenders
        final = stand(left, last, last.study.search.generations, folder, Watcher(), None)
    return last.name, final.flights + sum(row.flights for row in rows if not row.goes_on)


def measure(name: str, seed: int, starts: bool) -> dict[str, Any]:
    """Return winner, finalist, shares and flights of whole searches and race."""
    contest = load_any(STUDIES[name], {"seed": seed, **({} if starts else {"search.starts": []})})
    assert isinstance(contest, Contest)
    with TemporaryDirectory() as scratch:
        whole, flights = whole_searches(contest, Path(scratch))
        finalist, raced_flights = race(contest, Path(scratch))
    return {
        "study": name,
        "starts": starts,
        "seed": seed,
        "shares": whole,
        "winner": max(whole, key=lambda each: whole[each]),
        "finalist": finalist,
        "flights": flights,
        "race_flights": raced_flights,
    }


def table(runs: list[dict[str, Any]]) -> str:
    """Return a row for each run."""
    lines = [
        "| study | starts | seed | winner of whole searches (share) | finalist of the race (its share) | flights of the race |",
        "|---|---|---|---|---|---|",
    ]
    for run in runs:
        cells = [f"{run[key]} ({run['shares'][run[key]]:.3f})" for key in ("winner", "finalist")]
        part = f"{run['race_flights']:,} of {run['flights']:,} ({run['race_flights'] / run['flights']:.0%})"
        lines.append(f"| {run['study']} | {run['starts']} | {run['seed']} | {' | '.join(cells)} | {part} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", action="append", type=int, help="2025 to 2027 unless given")
    parser.add_argument("--out", type=Path, default=RESULTS / "choices.json")
    chosen = parser.parse_args()
    runs: list[dict[str, Any]] = []
    for name, starts in (("quadrotor", True), ("quadrotor", False), ("motor", False)):
        for seed in chosen.seed or SEEDS:
            runs.append(measure(name, seed, starts))
            print(json.dumps(runs[-1]), flush=True)
    write_json(chosen.out, {"machine": machine(), "revision": commit(), "runs": runs})
    chosen.out.with_suffix(".md").write_text(table(runs), encoding="utf-8")
    print(table(runs))


if __name__ == "__main__":
    main()
