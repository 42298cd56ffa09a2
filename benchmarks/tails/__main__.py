"""`python -m benchmarks.tails`: how often 95 % intervals hold an exact probability, and what they cost; one table.

A repeat is an estimate with its pilot, on a seed of its own. Cost is all its evaluations; beside it stands what crude Monte
Carlo would take for an interval as narrow. OpenTURNS estimates the same in an environment of its own under --envs; where that
cannot be made it is left out. Writes the table beside the JSON as .md.
"""

import argparse
import json
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.measuring import RESULTS, machine, write_json
from benchmarks.peers.environments import ROOT, NotInstalled, python_of, worker_environment
from benchmarks.tails.judges import Judge, judges
from objectives.risk import clopper_pearson
from tuner.extensions.tails.estimation.estimate import estimate_tail
from tuner.extensions.tails.estimation.planning import Request

Row = dict[str, float | str]
Estimate = tuple[float, float, float, int]
"""Probability, ends of the interval, evaluations."""
PROBABILITIES = (1e-4, 1e-5, 1e-6)
PEERS = {"SubsetSampling": 1.0, "NAIS": 0.2}
"""Algorithms and the part of the repeats: NAIS takes 5 s for an estimate in 100 dimensions."""
OPENTURNS = "openturns>=1.27"


def ours(judge: Judge, repeats: int, request: Request) -> list[Estimate]:
    """Return the estimates of all seeds."""
    estimates = (estimate_tail(judge, seed, request) for seed in range(repeats))
    return [(e.probability, e.low, e.high, e.evaluations) for e in estimates]


def peer(python: str, algorithm: str, probability: float, name: str, repeats: int) -> list[Estimate]:
    """Return the estimates of OpenTURNS."""
    command = [python, "-m", "benchmarks.tails.openturns_peer", algorithm, str(repeats), str(probability), name]
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=worker_environment(), cwd=ROOT)
    return [tuple(entry) for entry in json.loads(done.stdout)]


def row(who: str, name: str, exact: float, estimates: Sequence[Estimate]) -> Row:
    """Return coverage and cost of a case."""
    center, low, high, evaluations = np.array(estimates).T
    held = int(np.count_nonzero((low <= exact) & (exact <= high)))
    at_least, at_most = clopper_pearson(held, len(estimates))
    width = (high - low) / np.where(center > 0.0, center, np.inf)
    crude = (2.0 * 1.96 / float(np.median(width))) ** 2 / exact
    return {
        "who": who,
        "case": name,
        "probability": exact,
        "repeats": len(estimates),
        "coverage": held / len(estimates),
        "coverage_low": float(at_least),
        "coverage_high": float(at_most),
        "missed_below": float(np.mean(high < exact)),
        "mean_over_exact": float(np.mean(center) / exact),
        "median_width": float(np.median(width)),
        "mean_evaluations": float(np.mean(evaluations)),
        "crude_over_evaluations": float(crude / np.mean(evaluations)),
    }


def markdown(rows: Sequence[Row]) -> str:
    """Return the table."""
    lines = [
        "| estimator | case | probability | repeats | coverage of 95 % [95 % interval] | mean / exact | relative width |"
        " evaluations | crude's for that width, times |",
        "|---|---|---:|---:|---|---:|---:|---:|---:|",
    ]
    for entry in rows:
        lines.append(
            "| {who} | {case} | {probability:.4g} | {repeats} | {coverage:.3f} [{coverage_low:.3f}, {coverage_high:.3f}] |"
            " {mean_over_exact:.3f} | {median_width:.2f} | {mean_evaluations:,.0f} | {crude_over_evaluations:,.1f} |".format(
                **entry
            )
        )
    return "\n".join(lines) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, default=RESULTS / "tails.json")
    parser.add_argument(
        "--envs", type=Path, default=ROOT / ".benchmarks", help="where the environment of OpenTURNS lives"
    )
    parser.add_argument("--repeats", type=int, default=300)
    parser.add_argument("--width", type=float, default=0.5, help="relative width asked for")
    parser.add_argument("--peer-repeats", type=int, default=100, help="0 for none of OpenTURNS")
    chosen = parser.parse_args()
    where, left_out = machine(), dict[str, str]()
    rows: list[Row] = []

    def add(entry: Row) -> None:
        rows.append(entry)
        print(markdown([entry]).splitlines()[-1], flush=True)
        write_json(chosen.json, {"machine": where, "asked_width": chosen.width, "rows": rows, "left_out": left_out})
        chosen.json.with_suffix(".md").write_text(markdown(rows), encoding="utf-8")

    python = ""
    if chosen.peer_repeats:
        try:
            python = python_of("openturns", (OPENTURNS, "numpy", "scipy"), chosen.envs.resolve())
        except NotInstalled as error:
            left_out["OpenTURNS"] = str(error)
    cases = [(p, name, judge) for p in PROBABILITIES for name, judge in judges(p).items()]
    for probability, name, judge in cases:
        request = Request(relative_width=chosen.width, smallest=0.1 * probability)
        add(row("gainproof", name, judge.probability, ours(judge, chosen.repeats, request)))
    for algorithm, part in PEERS.items() if python else ():
        for probability, name, judge in cases:
            estimates = peer(python, algorithm, probability, name, max(round(part * chosen.peer_repeats), 1))
            add(row(f"OpenTURNS {algorithm}", name, judge.probability, estimates))


if __name__ == "__main__":
    main()
