"""`python -m benchmarks.search`: how good a front searches find, over flights and over processor time.

Every contestant meets the same black box: the study's points of the unit cube in, objectives and violations out, margins asked
before a flight. All start from the same first candidates of a seed. After so many flights the front so far flies held-out
scenarios; what counts is the share of the box up to 1.1 times the default that it dominates there. Held-out flights are not
counted, nor is their time. Processor time is that of the search itself, of asking for margins and of flying.
"""

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

import numpy as np

from benchmarks.measuring import RESULTS, machine, write_json
from objectives.problem import Problem
from plant.scenarios import HELD_OUT
from plant.seeds import generator
from tuner.experiments.tuning.problem import batches, problem_of
from tuner.experiments.tuning.search import algorithm_of, evaluated
from tuner.experiments.tuning.starts import starting_points
from tuner.search.first_generation import first_generation
from tuner.search.front import feasible_front, hypervolume
from tuner.search.loop import Generation, search_generations
from tuner.study import load_study
from tuner.study.study import SearchSpec, Study

ROOT = Path(__file__).resolve().parents[1]
FLIGHTS = (200, 400, 600, 1000, 3000, 11_000)
HELD_OUT_FLIGHTS, MOST_FINALISTS = 128, 64
PROBLEMS = {"quickstart": ROOT / "studies/quickstart.toml"}
"""Studies by the names of the problems that they pose."""


@dataclass(frozen=True)
class Contestant:
    """A search as a study asks for it: batch, flights of a candidate, races, where it starts, and flights in all."""

    algorithm: str
    population: int
    scenarios: int
    racing: bool
    most_flights: int
    initial: tuple[str, ...] = ("default",)


CONTESTANTS = {
    "gaussian_process, 4 scenarios": Contestant("gaussian_process", 8, 4, False, 1000),
    "gaussian_process, 4 scenarios, batches of 32": Contestant("gaussian_process", 32, 4, False, 1000),
    "gaussian_process, 8 scenarios": Contestant("gaussian_process", 8, 8, False, 1000),
    "nsga2, 4 scenarios": Contestant("nsga2", 32, 4, False, 3000),
    "nsga2, 32 scenarios, races": Contestant("nsga2", 32, 32, True, 11_000),
    "random, 4 scenarios": Contestant("random", 32, 4, False, 3000),
    "sobol, 4 scenarios": Contestant("sobol", 32, 4, False, 3000),
}


class HeldOut:
    """Flights that no search sees, each candidate's once. problem: of the study, with its own engine."""

    def __init__(self, study: Study, problem: Problem) -> None:
        scenarios = tuple(replace(entry, held_out=HELD_OUT_FLIGHTS) for entry in study.scenarios)
        self._problem, self._batches = problem, batches(replace(study, scenarios=scenarios), HELD_OUT)
        self._known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}
        self._default = self._flown(study.space.point(study.default_row)[None])[0][0]

    def hypervolume(self, points: np.ndarray) -> float:
        """Return the share of the box that points (n, d) dominate."""
        values, violations = self._flown(points)
        return hypervolume(values[feasible_front(values, violations)], self._default)

    def _flown(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        new = np.array([point for point in points if point.tobytes() not in self._known])
        if len(new):
            found = self._problem.evaluate(new, self._batches, fly_all=True)
            for point, *row in zip(new, found.values, found.violations, strict=True):
                self._known[point.tobytes()] = (row[0], row[1])
        rows = [self._known[point.tobytes()] for point in points]
        m, c = len(self._problem.objectives), len(self._problem.constraints) + len(self._problem.requirements)
        return np.array([row[0] for row in rows]).reshape(-1, m), np.array([row[1] for row in rows]).reshape(-1, c)


def study_of(problem: str, contestant: Contestant, seed: int) -> Study:
    """Return a problem's study with the search of a contestant; generations: more than it will need."""
    study = load_study(PROBLEMS[problem], {"seed": seed})
    spec = SearchSpec(contestant.algorithm, contestant.population, 10_000, contestant.initial, contestant.racing)
    scenarios = tuple(replace(entry, search=contestant.scenarios) for entry in study.scenarios)
    return replace(study, search=spec, scenarios=scenarios)


def raced(problem: str, contestant: Contestant, seed: int, held_out: HeldOut | None = None) -> dict[str, Any]:
    """Run a contestant and return its held-out hypervolume after so many flights."""
    study = study_of(problem, contestant, seed)
    posed = problem_of(study, None, None)
    posed.warm_up(study.default_row, study.scenarios[0].spec)
    held_out = held_out or HeldOut(study, posed)
    done, entries, aside = list[Generation](), list[dict[str, Any]](), 0.0
    begin = process_time()
    wanted = iter(flights for flights in FLIGHTS if flights <= contestant.most_flights)
    goal = next(wanted)
    for record in run(posed, study):
        done.append(record)
        while goal is not None and record.flights >= goal:
            paused = process_time()
            entries.append(
                {
                    "flights": record.flights, "candidates": len(done) * contestant.population,
                    "seconds": paused - begin - aside, "hypervolume": held_out.hypervolume(finalists(done)),
                    "searched": record.hypervolume,
                }
            )  # fmt: skip
            aside += process_time() - paused
            goal = next(wanted, None)
        if goal is None:
            break
    return {"seed": seed, "entries": entries}


def run(problem: Problem, study: Study) -> Iterator[Generation]:
    """Search without a results folder."""
    starts, _ = starting_points(study)
    draw = generator(study.seed, "search/initial", 0)
    worthy = problem.worth_flying if study.requirements else None
    first = first_generation(starts, study.search.population, draw, worthy)
    done: list[Generation] = []

    def evaluate(points: np.ndarray) -> Any:
        default = np.arange(len(points)) == 0 if not done else False
        return evaluated(problem, study, points, done, fly_all=default)

    for record in search_generations(algorithm_of(problem, study, first), evaluate, study.search.budget):
        done.append(record)
        yield record


def finalists(done: list[Generation]) -> np.ndarray:
    """Return the front's points (k, d), a long one thinned evenly along its first objective."""
    points = np.concatenate([entry.points for entry in done])
    values = np.concatenate([entry.evaluation.values for entry in done])
    front = feasible_front(values, np.concatenate([entry.evaluation.violations for entry in done]))
    front = front[np.argsort(values[front, 0], kind="stable")]
    keep = np.unique(np.linspace(0, len(front) - 1, min(len(front), MOST_FINALISTS)).round().astype(int))
    return points[front[keep]]


def table(document: dict[str, Any]) -> str:
    """Return medians and ranges of the hypervolume over flights, a row a contestant."""
    lines = []
    for problem, found in document["problems"].items():
        lines.append(f"{problem}: held-out hypervolume after so many flights, median [range]; processor seconds")
        for name, runs in found.items():
            lines.append(f"  {name}")
            for entries in zip(*[run["entries"] for run in runs], strict=True):
                volume = [entry["hypervolume"] for entry in entries]
                lines.append(
                    f"    {median(entry['flights'] for entry in entries):8.0f} {median(volume):.3f} "
                    f"[{min(volume):.3f}, {max(volume):.3f}] {median(entry['seconds'] for entry in entries):7.1f} s"
                )
    return "\n".join(lines)


def main() -> None:
    """Run contestants and write search.json."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", action="store_true", help="print the document in place of the table")
    parser.add_argument("--problem", action="append", choices=PROBLEMS, help="all unless given")
    parser.add_argument("--contestant", action="append", help="the beginning of a name; all unless given")
    parser.add_argument("--seed", action="append", type=int, help="2025 to 2027 unless given")
    parser.add_argument("--out", type=Path, default=RESULTS / "search.json")
    chosen = parser.parse_args()
    names = [name for name in CONTESTANTS if name.startswith(tuple(chosen.contestant or [""]))]
    found: dict[str, Any] = {}
    for problem in chosen.problem or PROBLEMS:
        found[problem] = {}
        for name in names:
            found[problem][name] = [
                raced(problem, CONTESTANTS[name], seed) for seed in chosen.seed or (2025, 2026, 2027)
            ]
    document = {"machine": machine(), "held_out_flights": HELD_OUT_FLIGHTS, "problems": found}
    write_json(chosen.out, document)
    print(json.dumps(document) if chosen.json else table(document))


if __name__ == "__main__":
    main()
