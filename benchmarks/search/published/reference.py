"""`python -m benchmarks.search.published.reference`: write the reference of each problem's score.

The front is the exact one where a formula has it; that of the authors of the RE suite (files of approximated_Pareto_fronts in
github.com/ryojitanabe/reproblems) where --fronts names their folder; else what long runs of pymoo's NSGA-II find together.
Ideal point, nadir and hypervolume are kept.
"""

import argparse
import json
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.measuring import RESULTS, write_json
from benchmarks.search.published.problem import Array, PublishedProblem
from benchmarks.search.published.suite import EXACT, SUITE
from tuner.search.front import non_dominated

FILE = RESULTS / "search_published_fronts.json"
# Share of the front's range by which the reference point of the hypervolume lies beyond the nadir.
BEYOND_NADIR = 0.1
POPULATION, GENERATIONS, SEEDS = 200, 500, (1, 2)


class ReferenceFront(NamedTuple):
    """A reference front: its ideal point (m,), nadir (m,) and hypervolume, and its source."""

    ideal: list[float]
    nadir: list[float]
    hypervolume: float
    source: str


@cache
def references() -> dict[str, ReferenceFront]:
    """Return the reference fronts by problem."""
    return {name: ReferenceFront(**entry) for name, entry in json.loads(FILE.read_text(encoding="utf-8")).items()}


def score(name: str, objectives: Array, constraints: Array) -> float | None:
    """Return the score of evaluations: objectives (n, m) and constraint values (n, c).

    With several objectives, their hypervolume as a share of the reference front's; with one, the gap to the optimum in units of
    the optimum, at least 1, None where none is feasible.
    """
    problem = SUITE[name]
    feasible = objectives[np.all(constraints <= 0.0, axis=1)]
    if problem.optimum is not None:
        return float(feasible.min() - problem.optimum) / max(abs(problem.optimum), 1.0) if len(feasible) else None
    reference = references()[problem.reference or name]
    return _hypervolume(feasible, np.array(reference.ideal), np.array(reference.nadir)) / reference.hypervolume


def _hypervolume(front: Array, ideal: Array, nadir: Array) -> float:
    """Return the hypervolume of points (n, m) in units of the front's range."""
    from moocore import hypervolume

    scaled = (front - ideal) / (nadir - ideal)
    scaled = scaled[np.all(scaled < 1.0 + BEYOND_NADIR, axis=1)]
    return float(hypervolume(scaled, ref=np.full(len(ideal), 1.0 + BEYOND_NADIR))) if len(scaled) else 0.0


def make_reference(name: str, folder: Path | None) -> ReferenceFront:
    """Return the reference front of a problem; folder: of fronts by the authors of the RE suite."""
    problem = EXACT[name]
    file = None if folder is None else folder / f"reference_points_{name}.dat"
    if problem.front is not None:
        front, source = problem.front(), "formula"
    elif file is not None and file.exists():
        front, source = np.loadtxt(file), "authors"
    else:
        front = np.concatenate([long_run(problem, seed) for seed in SEEDS])
        front, source = front[non_dominated(front)], f"NSGA-II, {POPULATION} x {GENERATIONS}, seeds {SEEDS}"
    ideal, nadir = front.min(axis=0), front.max(axis=0)
    return ReferenceFront(ideal.tolist(), nadir.tolist(), _hypervolume(front, ideal, nadir), source)


def long_run(problem: PublishedProblem, seed: int) -> Array:
    """Return the objectives (k, m) of the front that a long run of NSGA-II finds."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    class Cube(Problem):
        def _evaluate(self, x: Array, out: dict[str, Array], *args: object, **kwargs: object) -> None:  # type: ignore[override]
            out["F"], out["G"] = problem.evaluate(x)

    cube = Cube(n_var=problem.dimension, n_obj=problem.n_objectives, n_ieq_constr=problem.n_constraints, xl=0.0, xu=1.0)
    result = minimize(cube, NSGA2(pop_size=POPULATION), ("n_gen", GENERATIONS), seed=seed)
    assert result.F is not None, "a long run finds feasible points"
    return np.asarray(result.F)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fronts", type=Path, help="folder of the fronts by the authors of the RE suite")
    parser.add_argument("--problem", action="append", choices=EXACT, help="all unless given")
    chosen = parser.parse_args()
    entries = json.loads(FILE.read_text(encoding="utf-8")) if FILE.exists() else {}
    for name in chosen.problem or [name for name, problem in EXACT.items() if problem.optimum is None]:
        entries[name] = make_reference(name, chosen.fronts)._asdict()
        write_json(FILE, entries)
        print(name, entries[name], flush=True)


if __name__ == "__main__":
    main()
