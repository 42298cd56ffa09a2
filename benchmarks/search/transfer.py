"""`python -m benchmarks.search.transfer`: searches that start from the front of another study, beside searches that do not.

Each seed has an earlier run of the quickstart of its own. Its front starts searches of studies that differ in wind, vehicle or
reference. All fronts of a study are judged on the same held-out flights, which cost nothing; the best known is the hypervolume of
all of them together.
"""

import argparse
from collections.abc import Iterator
from math import inf
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from benchmarks.measuring import RESULTS, machine, write_json
from benchmarks.search.problems import FINALISTS, HERE, OF_QUADROTORS, ROOT, Course, finalists
from benchmarks.search.race import Step, tool_steps
from plant.seeds import generator
from tuner.experiments.tuning.run import TuningRun
from tuner.experiments.tuning.search import first_generation
from tuner.search import bayesian_optimization
from tuner.search.front import feasible_front, hypervolume
from tuner.search.watcher import Watcher
from tuner.store.environment import commit
from tuner.store.folder import Folder
from tuner.study.build import load_study
from tuner.study.study import Study

SEEDS = (2025, 2026, 2027, 2028, 2029)
ENOUGH = 0.95
QUICKSTART = ROOT / "studies/quickstart.toml"
SIZES = {"search.population": 12, "search.generations": 12}


class Target(NamedTuple):
    """A study that a search of another one starts: its file, what is changed in it, and how it differs from the quickstart."""

    study: Path
    changes: dict[str, Any]
    about: str


TARGETS = {
    "wind": Target(
        QUICKSTART, {**SIZES, "scenario.0.air.intensity": 5.0, "scenario.0.spread.mass": 0.15}, "5 m/s of wind at 20 ft"
    ),
    "vehicle": Target(QUICKSTART, {**SIZES, "airframe.name": "iris"}, "iris in place of hummingbird"),
    "reference": Target(
        QUICKSTART,
        {**SIZES, "scenario.0.reference": {"kind": "figure_eight", "size": 2.0, "period": 8.0}},
        "a figure eight in place of steps",
    ),
    "three": Target(HERE / "studies/three.toml", {}, "another study: three objectives, gust, 8 gains"),
    "study": Target(
        ROOT / "studies/figure_eight.toml", {}, "another study: reference, objective, limits, ranges and wind"
    ),
}
STARTS: tuple[str, ...] = ("usual", "earlier", "shipped", "misled")
"""Without starts; from the earlier front; from the one that comes with the tool; from points around a random one."""
# Points around the random one, and standard deviation of their steps.
CLUSTER, STEP = 12, 0.05


class Judge(Course):
    """The held-out flights of a target, common to all seeds."""

    def __init__(self, target: Target) -> None:
        self._target = target
        super().__init__("quickstart", 9000)

    def study(self, overrides: dict[str, Any]) -> Study:
        """Return the study with values of its file replaced."""
        return load_study(self._target.study, {**OF_QUADROTORS, "seed": self.seed, **self._target.changes, **overrides})


def earlier_run(folder: Path, seed: int) -> Path:
    """Return the results folder of an earlier run of the quickstart."""
    study = load_study(QUICKSTART, {**OF_QUADROTORS, **SIZES, "seed": 1000 + seed})
    TuningRun(study, Folder.create(folder), Watcher()).carry_out()
    return folder


def cluster(judge: Judge, seed: int) -> list[dict[str, float]]:
    """Return points around a random one that keeps the margins, another one for each seed."""
    study, draw = judge.study({}), generator(seed, "benchmarks/cluster", 0)
    space = study.space
    drawn = draw.uniform(size=(2000, len(space.variables)))
    middle = drawn[judge.problem(study).worth_flying(drawn)][0]
    rows = space.values(np.clip(middle + STEP * draw.standard_normal((CLUSTER, len(middle))), 0.0, 1.0))
    names = [variable.name for variable in space.variables]
    return [dict(zip(names, row, strict=True)) for row in rows.tolist()]


def starts_of(start: str, judge: Judge, seed: int, earlier: Path) -> list[Any]:
    """Return the entries of search.starts of a kind of start."""
    if start == "misled":
        return [{"origin": "a random place", "points": cluster(judge, seed)}]
    return {"usual": [], "earlier": [str(earlier)], "shipped": ["shipped"]}[start]


def fronts(judge: Judge, study: Study) -> Iterator[tuple[int, np.ndarray]]:
    """Yield flights and held-out front (k, m) after each generation of a search."""
    problem = judge.problem(study)
    steps: list[Step] = []
    for step in tool_steps(problem, study, first_generation(problem, study)[0]):
        steps = [step] if step.survivors else [*steps, step]
        points, values, violations = (np.concatenate(part) for part in zip(*[each[:3] for each in steps], strict=True))
        yield step.flights, judge.front(finalists(points, values, violations))


def measure(name: str, earlier: dict[int, Path], starts: list[str]) -> list[dict[str, Any]]:
    """Return a run for each seed and start of a target; earlier: results folder of each seed."""
    judge, runs = Judge(TARGETS[name]), list[dict[str, Any]]()
    curves: list[list[tuple[int, np.ndarray]]] = []
    for seed, folder in earlier.items():
        for start in starts:
            study = judge.study({"seed": seed, "search.starts": starts_of(start, judge, seed, folder)})
            curves.append(list(fronts(judge, study)))
            runs.append({"target": name, "seed": seed, "start": start})
            print(name, seed, start, hypervolume(curves[-1][-1][1], judge.default), flush=True)
    best = best_known(curves, judge.default)
    for run, curve in zip(runs, curves, strict=True):
        shares = [hypervolume(front, judge.default) / best for _, front in curve]
        run |= {"flights": [flights for flights, _ in curve], "shares": shares}
    return runs


def best_known(curves: list[list[tuple[int, np.ndarray]]], default: np.ndarray) -> float:
    """Return the hypervolume of all last fronts together."""
    values = np.concatenate([curve[-1][1] for curve in curves])
    return hypervolume(values[feasible_front(values, np.zeros((len(values), 0)))], default)


def flights_to(run: dict[str, Any], share: float) -> float:
    """Return the flights after which a run has a share of the best known, infinite where it never has."""
    reached = (flights for flights, value in zip(run["flights"], run["shares"], strict=True) if value >= share)
    return next(reached, inf)


def table(runs: list[dict[str, Any]]) -> str:
    """Return the medians and every seed as a table."""
    lines = [
        f"| target | start | flights to {ENOUGH:.0%} of the best known: median (each seed) | share at the end: median (each) |",
        "|---|---|---|---|",
    ]
    for target, start in dict.fromkeys((run["target"], run["start"]) for run in runs):
        mine = [run for run in runs if (run["target"], run["start"]) == (target, start)]
        needed, ends = [flights_to(run, ENOUGH) for run in mine], [run["shares"][-1] for run in mine]
        each = ", ".join(f"{value:.0f}" if value < inf else "never" for value in needed)
        last = ", ".join(f"{value:.3f}" for value in ends)
        middle = median(needed)
        words = f"{middle:.0f}" if middle < inf else "never"
        lines.append(f"| {target} | {start} | {words} ({each}) | {median(ends):.3f} ({last}) |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target", action="append", choices=TARGETS, help="all unless given")
    parser.add_argument("--start", action="append", choices=STARTS, help="all unless given")
    parser.add_argument("--seed", action="append", type=int, help="2025 to 2029 unless given")
    parser.add_argument("--out", type=Path, default=RESULTS / "transfer.json")
    chosen = parser.parse_args()
    bayesian_optimization.warm_up()
    seeds, starts = tuple(chosen.seed or SEEDS), chosen.start or list(STARTS)
    with TemporaryDirectory() as scratch:
        earlier = {seed: earlier_run(Path(scratch) / str(seed), seed) for seed in seeds}
        runs = [run for name in chosen.target or TARGETS for run in measure(name, earlier, starts)]
    write_json(chosen.out, {"machine": machine(), "revision": commit(), "finalists": FINALISTS[2], "runs": runs})
    text = "\n".join([*[f"- {name}: {target.about}" for name, target in TARGETS.items()], "", table(runs)])
    chosen.out.with_suffix(".md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
