"""`python -m benchmarks.binding_limits`: one objective and a limit on flights that binds, 20 studies: how near is the best?

Each study runs in the tool's default budget, or in that of the shipped file. The gains that it recommends make fresh flights of
another seed, at most 10,000 of a plant and 2,000 of a quadrotor; their value is held against the limit. The best that keeps it
is looked for by differential evolution from the study's own finalists, 5,232 candidates of a plant and 1,640 of a quadrotor on
two to four times the flights. In three rounds, points on both sides of the limit make the fresh flights, and the next limit
is moved by their median difference; the gap counts from the best by value there, which column "at" is the limited value of.

A point whose interval keeps the limit lies as far inside as the interval is wide, and the best by value lies at the limit. So "at
its own" is the gap from the best of those that lie as far inside as the recommended point: the part of the gap that a search can
close without more flights. The last round of the dense search looks for it.
"""

import argparse
import tempfile
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import tuner
from benchmarks.measuring import RESULTS, machine, write_json
from objectives.evaluator import Evaluation
from objectives.problem import FlightBatch, Problem
from plant.seeds import generator
from plant.ties import first_smallest
from tuner.experiments.compare.entrants import rows_of
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study, TuningStudy
from tuner.text.errors import NOTHING_FEASIBLE

Row = dict[str, Any]
STUDIES = Path(__file__).parents[1] / "studies"
HEAD = "| study, limit | exit | point | limit | fresh | kept | objective | best | at | gap % | at its own % |"
ASKED_GAP, BESIDE = 3.0, (0.1, 0.04, 0.015)
"""Largest gap [%] that counts as near; shares of a limit up to which points beside it make fresh flights, by round."""
BUDGETS = {PlantStudy.kind: (48, 81, 4, 10_000), Study.kind: (40, 30, 2, 2000)}
"""Dense search of a kind of study: candidates of a generation, generations, times the flights, fresh flights at most."""


class Loop(NamedTuple):
    """A linear plant under PID: numerator, denominator; dead time, period, flight [s]; middle of its ranges."""

    polynomials: tuple[list[float], list[float]]
    times: tuple[float, float, float]
    middle: tuple[float, float, float]
    span: float = 10.0
    load: float = 0.5


class Case(NamedTuple):
    """A study, of a loop or shipped: objective, limited quantity and its most, and other keys of their tables."""

    study: Loop | str
    objective: str
    limit: str
    most: float
    judged: Row = {}
    limited: Row = {}


LAG = Loop(([1.0], [1.0, 1.0]), (0.2, 0.05, 20.0), (2.0, 2.0, 0.2))
GREENHOUSE = Loop(([0.3], [7200.0, 1.0]), (600.0, 60.0, 43_200.0), (15.0, 2e-3, 3000.0), 40.0, 2.0)
SWINGING = Loop(([1.0], [1.0, 0.4, 1.0]), (0.2, 0.05, 30.0), (1.0, 0.8, 1.0))
INTEGRATOR = Loop(([1.0], [2.0, 1.0, 0.0]), (0.5, 0.1, 60.0), (0.3, 0.02, 0.5), load=0.0)
WRONG_WAY = Loop(([-1.0, 1.0], [2.0, 3.0, 1.0]), (0.0, 0.1, 40.0), (0.8, 0.3, 0.5))
THIRD = Loop(([1.0], [1.0, 3.0, 3.0, 1.0]), (0.0, 0.05, 40.0), (2.0, 0.6, 1.5), load=0.0)
UNSTABLE = Loop(([1.0], [4.0, -1.0]), (0.4, 0.1, 40.0), (4.0, 0.6, 1.0))
TAIL, NINE_IN_TEN = {"risk": "cvar", "level": 0.8}, {"risk": "quantile", "level": 0.9}
CASES = {
    "lag, overshoot": Case(LAG, "iae.level", "overshoot.level", 5.0),
    "lag, travel": Case(LAG, "iae.level", "travel", 0.06),
    "greenhouse, overshoot": Case(GREENHOUSE, "iae.level", "overshoot.level", 6.0),
    "greenhouse, travel": Case(GREENHOUSE, "iae.level", "travel", 1.2e-4),
    "swinging, overshoot": Case(SWINGING, "itae.level", "overshoot.level", 12.0, limited=TAIL),
    "swinging, command": Case(SWINGING, "iae.level", "command_peak", 0.16),
    "integrator, overshoot": Case(INTEGRATOR, "iae.level", "overshoot.level", 2.5),
    "non-minimum phase, overshoot": Case(WRONG_WAY, "iae.level", "overshoot.level", 4.0),
    "third order, settling": Case(THIRD, "travel", "settling.level", 9.0),
    "unstable, overshoot": Case(UNSTABLE, "iae.level", "overshoot.level", 45.0, limited=NINE_IN_TEN),
    "dc_motor, overshoot": Case("dc_motor", "itae.angle", "overshoot.angle", 4.0),
    "two_masses, travel": Case("two_masses", "recovery.position", "travel", 0.016),
    "fixed_wing, travel": Case("fixed_wing", "rms.pitch", "travel", 1.0),
    "heater, peak": Case("heater", "travel", "peak.temperature", 1.2, limited={"scenario": "load"}),
    "quickstart, overshoot": Case("quickstart", "itae.position", "overshoot.position", 8.0, TAIL),
    "autopilot_pid, overshoot": Case("autopilot_pid", "itae.position", "overshoot.position", 17.8, TAIL),
    "f450, tilt": Case("f450", "rms.position", "rms.tilt", 0.02, TAIL),
    "px4, travel": Case("px4", "rms.position", "travel", 18.0, {**TAIL, "scenario": "gusts"}),
    "betaflight, noise": Case("betaflight", "rms.tilt", "noise", 0.06, TAIL),
    "crazyflie, overshoot": Case("crazyflie", "itae.position", "overshoot.position", 0.5, TAIL),
}


def loop_tables(loop: Loop) -> Row:
    """Return the study of a linear plant: a step of the reference, one of the load, noise; two coefficients known to 20 %."""
    (above, below), (dead_time, period, duration) = loop.polynomials, loop.times
    plant = {"transfer_function": {"numerator": above, "denominator": below}, "inputs": ["valve"], "outputs": ["level"]}
    gains = {f"level.{name}": at for name, at in zip(("kp", "ki", "kd"), loop.middle, strict=True)}
    ranges = {name: {"low": at / 8.0, "high": at * 8.0, "default": at / 2.0} for name, at in gains.items()}
    drawn = {"sensors": {"level": {"rms": 0.01}}, "spread": {"b0": 0.2, "a1": 0.2}}
    reference = {"level": {"kind": "step", "size": 1.0, "time": duration / 20.0}}
    load = {"valve_load": {"kind": "step", "size": -loop.load, "time": 0.6 * duration}}
    flights = {"name": "day", "duration": duration, "search": 8, "held_out": 64}
    return {
        **{"title": "Loop", "seed": 1, "margin": [{"quantity": "ms", "max": 2.0}]},
        "plant": {**plant, "dead_time": dead_time, "control_period": period},
        "actuator": [{"name": "valve", "low": -loop.span, "high": loop.span}],
        "channel": [{"name": "level", "law": "pid", "output": "level", "to": "valve", "lost_beyond": 20.0}],
        "gains": {**ranges, "level.t_f": 2.0 * period},
        "scenario": [{**flights, "reference": reference, "disturbance": load, **drawn}],
    }


def study_of(case: Case) -> Study | PlantStudy:
    """Return the study of a case with a limit, which stands first."""
    if isinstance(case.study, Loop):
        tables = loop_tables(case.study)
    else:
        tables = tomllib.loads((STUDIES / f"{case.study}.toml").read_text(encoding="utf-8"))
    others = [entry for entry in tables.get("constraint", []) if entry["metric"] != case.limit]
    tables["objective"] = [{"metric": case.objective, **case.judged}]
    tables["constraint"] = [{"metric": case.limit, "max": case.most, **case.limited}, *others]
    # A rule that weighs objectives has nothing to weigh.
    return tuner.make_study({key: tables[key] for key in tables if key != "pick"}, "one", STUDIES)


class Flown(NamedTuple):
    """Values of points on the same flights: objective, limited quantity, and violations of everything else."""

    objective: np.ndarray
    limited: np.ndarray
    others: np.ndarray

    def merit(self, most: float) -> tuple[np.ndarray, np.ndarray]:
        """Return objective and violations (n,) under a limit."""
        return self.objective, self.others + np.maximum(self.limited - most, 0.0) / most

    def and_(self, other: "Flown") -> "Flown":
        """Return the values of these points and others."""
        return Flown(*map(np.concatenate, zip(self, other, strict=True)))


def flown(study: TuningStudy, found: Evaluation) -> Flown:
    """Return the values of an evaluation; where a limit is 0, as on losses, up to 1 % of the flights are none."""
    most = np.array([entry.most for entry in study.constraints])
    relative = found.violations.copy()
    relative[:, : len(most)] = np.maximum(relative[:, : len(most)] - np.where(most == 0.0, 0.01, 0.0), 0.0)
    relative[:, : len(most)] /= np.where(most == 0.0, 1.0, np.abs(most))
    return Flown(found.values[:, 0], found.excess[:, 0] + most[0], relative[:, 1:].sum(axis=1))


class Dense:
    """Differential evolution of one study, on more flights than the tool's search makes and of another seed."""

    def __init__(self, study: Study | PlantStudy, starts: np.ndarray) -> None:
        count, self.generations, times, flights = BUDGETS[study.kind]
        # Which leaves 1,000 of betaflight's, at 4 kHz.
        self.flights = min(flights, 24_000_000 // max(each.spec.steps(study.system.timing) for each in study.scenarios))
        self.study, self.draw = study, generator(study.seed, "benchmark/dense", 0)
        judged = study.objectives, study.constraints
        self.problem = Problem(study.system, study.space, *judged, study.seed + 1, None, study.screens)
        self.batches = tuple(FlightBatch(entry.spec, "dense", times * entry.search) for entry in study.scenarios)
        self.points = self.draw.random((count, len(study.space.variables)))
        self.points[: min(len(starts), count // 2)] = starts[: count // 2]
        self.values = flown(study, self.problem.evaluate(self.points, self.batches))
        self.tried, self.seen = self.points, self.values

    def evolve(self, most: float, generations: int) -> None:
        """Go on for some generations under a limit."""
        for _ in range(generations):
            cost, beyond = self.values.merit(most)
            drawn = self.draw.integers(len(self.points), size=(3, len(self.points)))
            aim = self.points[np.lexsort((cost, beyond))[drawn[0] // 5]]
            one, two = self.points[drawn[1:]]
            moved = self.points + self.draw.uniform(0.3, 0.9, (len(self.points), 1)) * (aim - self.points + one - two)
            moved = np.where(self.draw.random(moved.shape) < 0.9, moved, self.points)
            moved = np.where((moved < 0.0) | (moved > 1.0), self.draw.random(moved.shape), moved)
            values = flown(self.study, self.problem.evaluate(moved, self.batches))
            self.tried, self.seen = np.concatenate([self.tried, moved]), self.seen.and_(values)
            new_cost, new_beyond = values.merit(most)
            better = (new_beyond < beyond) | ((new_beyond == beyond) & (new_cost <= cost))
            self.points = np.where(better[:, None], moved, self.points)
            self.values = Flown(*(np.where(better, new, old) for new, old in zip(values, self.values, strict=True)))

    def around(self, most: float, share: float) -> tuple[np.ndarray, Flown]:
        """Return the gains rows with the smallest objectives on both sides of a limit, and their values."""
        limits = most * (1.0 + np.linspace(-share, share, 9))
        within = [np.flatnonzero((self.seen.others <= 0.0) & (self.seen.limited <= limit)) for limit in limits]
        chosen = np.unique(np.concatenate([rows[np.argsort(self.seen.objective[rows])[:2]] for rows in within]))
        return self.study.space.gains(self.tried[chosen]), Flown(*(part[chosen] for part in self.seen))

    def fresh(self, gains: np.ndarray) -> Flown:
        """Return the values of gains rows on fresh flights, by scenario as many of them as of held-out ones."""
        share = self.flights / sum(entry.held_out for entry in self.study.scenarios)
        batches = tuple(FlightBatch(each.spec, "fresh", int(share * each.held_out)) for each in self.study.scenarios)
        return flown(self.study, self.problem.evaluate_gains(gains, batches, fly_all=True, complete=True))


def run(name: str, case: Case) -> Row:
    """Run the study of a case, hold its answer against fresh flights, and look for the best."""
    study = study_of(case)
    with tempfile.TemporaryDirectory() as folder:
        results = tuner.run(study, Path(folder) / "run")
        front, feasible, point = results.held_out_front, results.feasible, results.tuned
    finalists, tuned = rows_of(study, front.gains), front.points.index(point)
    dense = Dense(study, np.array([study.space.point(row) for row in finalists]))
    rows, fresh, shift = finalists, dense.fresh(finalists), 0.0
    own = min(float(fresh.limited[tuned]), case.most)
    for most, share in [*((case.most, share) for share in BESIDE), (own, BESIDE[-1])]:
        dense.evolve(most + shift, dense.generations // len(BESIDE))
        near, seen = dense.around(most + shift, share)
        found = dense.fresh(near)
        shift = float(np.median(seen.limited - found.limited))
        rows, fresh = np.concatenate([rows, near]), fresh.and_(found)
    best = best_within(fresh, case.most)
    alike = best_within(fresh, own)
    return {
        **{"case": name, "exit": 0 if feasible else NOTHING_FEASIBLE, "point": point, "limit": case.most},
        **{"value": float(fresh.limited[tuned]), "keeps": bool(fresh.limited[tuned] <= case.most)},
        **{"keeps_others": bool(fresh.others[tuned] <= 0.0), "objective": float(fresh.objective[tuned])},
        **{"best": float(fresh.objective[best]), "best_value": float(fresh.limited[best])},
        "gap_percent": 100.0 * float(fresh.objective[tuned] / fresh.objective[best] - 1.0),
        "own_gap_percent": 100.0 * float(fresh.objective[tuned] / fresh.objective[alike] - 1.0),
        **{"gains": rows[tuned].tolist(), "best_gains": rows[best].tolist()},
    }


def best_within(seen: Flown, most: float) -> int:
    """Return the row with the smallest objective within a limit."""
    return first_smallest(np.where(seen.merit(most)[1] <= 0.0, seen.objective, np.inf))


def markdown(runs: list[Row]) -> str:
    """Return the runs as a table, with counts."""
    lines = [HEAD, f"|---|{10 * '---:|'}"]
    for one in runs:
        kept = f"{one['limit']:.4g} | {one['value']:.4g} | {'yes' if one['keeps'] else 'no'}"
        judged = f"{one['objective']:.4g} | {one['best']:.4g} | {one['best_value']:.4g}"
        gaps = f"{one['gap_percent']:.2f} | {one['own_gap_percent']:.2f}"
        lines.append(f"| {one['case']} | {one['exit']} | {one['point']} | {kept} | {judged} | {gaps} |")
    ended, kept = sum(not one["exit"] for one in runs), sum(one["keeps"] for one in runs)
    near = sum(one["gap_percent"] <= ASKED_GAP for one in runs)
    alike = sum(one["own_gap_percent"] <= ASKED_GAP for one in runs)
    counts = f"{ended} of {len(runs)} recommend, {kept} keep the limit, {near} within {ASKED_GAP:g} %"
    return "\n".join([*lines, "", f"{counts}, {alike} at their own.", ""])


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--case", action="append", default=[], help="beginning of a name; all unless given")
    parser.add_argument("--json", type=Path, default=RESULTS / "binding_limits.json")
    asked, runs = parser.parse_args(), list[Row]()
    for name in [name for name in CASES if name.startswith(tuple(asked.case or [""]))]:
        runs.append(run(name, CASES[name]))
        write_json(asked.json, {"machine": machine(), "runs": runs})
        print(markdown(runs[-1:]).splitlines()[2], flush=True)
        asked.json.with_suffix(".md").write_text(markdown(runs), encoding="utf-8")
    print(*markdown(runs).splitlines()[-1:])


if __name__ == "__main__":
    main()
