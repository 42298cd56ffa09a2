"""First order plus dead time: our front beside the optimum of Grimholt and Skogestad, `python -m benchmarks.dead_time`.

C. Grimholt, S. Skogestad, "Optimal PI and PID control of first-order plus delay processes and evaluation of the original and
improved SIMC rules", J. Process Control 70, 2018: the least J = 0.5 (IAE_load/IAE_load* + IAE_output/IAE_output*) for a given Ms,
where the starred errors are the least that a PI controller reaches for one of the two steps alone at Ms = 1.59.

The optimum is recomputed here for the loop as it is sampled, from its transfer functions alone: responses by a recursion, Ms on a
frequency grid, a bisection for the largest gains of a ratio that Ms allows, and a local optimiser over the ratios. A period of a
thirty-second of the dead time adds half a period of delay; the column J(0) is what the optimum tends to without sampling, by
Richardson's extrapolation from half the period.
"""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize
from scipy.signal import lfilter

from objectives.problem import FlightBatch, Problem
from plant.quadrotor.scenarios import SEARCH
from plant.seeds import generator
from tuner.api.studies import make_study
from tuner.search.convergence import StoppingRule
from tuner.search.initial_design import initial_design
from tuner.search.loop import archive, search_generations
from tuner.search.registry import SEARCHES

Array = np.ndarray
STUDIES = Path(__file__).parents[1] / "studies"
PERIODS, DURATION = 32, 60.0
"""Control periods of a dead time of 1 s, and length of a flight [s]."""
RATIOS, PEAKS = (0.1, 1.0, 10.0), (1.4, 1.59, 2.0)
"""Dead time over lag, and limits on Ms."""


POPULATION, GENERATIONS = 48, 60
"""Of our search."""


class Loop(NamedTuple):
    """A sampled loop, dead time 1 s: control periods in it, and its lag [s]."""

    periods: int
    lag: float

    def parts(self, kp: float, ki: float, kd: float) -> tuple[Array, Array, Array, Array]:
        """Return numerator and denominator of plant (with its delay) and controller, in powers of 1/z."""
        h = 1.0 / self.periods
        a = np.exp(-h / self.lag)
        plant = np.append(np.zeros(self.periods + 1), 1.0 - a)
        controller = kp * np.array([1.0, -1.0, 0.0]) + ki * h * np.array([0.0, 1.0, 0.0])
        return plant, np.array([1.0, -a]), controller + kd / h * np.array([1.0, -2.0, 1.0]), np.array([1.0, -1.0])

    def response(self, gains: Array) -> Array:
        """Return the loop transfer function on the grid; it is proportional to the gains."""
        n, d, c, e = self.parts(*gains)
        z = np.exp(-1j * grid(self.periods) / self.periods)
        power = z ** (self.periods + 1)
        return power * n[-1] * np.polyval(c[::-1], z) / (np.polyval(d[::-1], z) * np.polyval(e[::-1], z))

    def errors(self, gains: Array) -> tuple[float, float]:
        """Return the integrated absolute errors of a unit step of the load and of one of the output."""
        n, d, c, e = self.parts(*gains)
        closed = np.convolve(d, e)
        back = np.convolve(n, c)
        closed = np.append(closed, np.zeros(len(back) - len(closed))) + back
        step = np.ones(round(DURATION * self.periods))
        # The load comes behind the dead time, as in a flight; it only shifts the response.
        load = lfilter(np.convolve(n[self.periods :], e), closed, step)
        output = lfilter(np.convolve(d, e), closed, step)
        of_load, of_output = (float(np.sum(np.abs(y), axis=0)) / self.periods for y in (load, output))
        return of_load, of_output


@cache
def grid(periods: int) -> Array:
    """Return frequencies [rad/s] up to the last one that sampling knows."""
    return np.concatenate([np.geomspace(1e-3, 1.0, 200), np.linspace(1.0, np.pi * periods, 40 * periods)])


def largest(loop: Loop, shape: Array, peak: float) -> Array | None:
    """Return the gains of these proportions whose Ms is the limit: the first factor that reaches it."""
    response = loop.response(shape)

    def excess(factor: float) -> float:
        return 1.0 / float(np.min(np.abs(1.0 + factor * response), axis=0)) - peak

    factors = np.geomspace(0.02, 50.0, 60)
    first = next((i for i, factor in enumerate(factors) if excess(factor) > 0.0), 0)
    if not first:
        return None
    factor: float = brentq(excess, factors[first - 1], factors[first], xtol=1e-10)  # type: ignore[assignment]
    return factor * shape


def least(loop: Loop, peak: float, derivative: bool, cost: Callable[[float, float], float]) -> tuple[float, Array]:
    """Return the least cost at a given Ms and its gains, by Nelder and Mead from several starts over the ratios of the gains."""
    scale = (loop.lag + 1.0 / 3.0) / 2.0

    def gains(x: Array) -> Array | None:
        shape = scale * np.array([1.0, np.exp(x[0]), np.exp(x[1]) if derivative else 0.0])
        most = largest(loop, shape, peak)
        # The last variable leaves Ms below its limit, where that is better.
        return None if most is None else np.exp(-(x[-1] ** 2)) * most

    def value(x: Array) -> float:
        at = gains(x)
        return 1e6 if at is None else min(cost(*loop.errors(at)), 1e6)

    times = (0.3, 1.0, 3.0)
    starts = [[-np.log(t), *([np.log(0.3)] if derivative else []), 0.2] for t in times]
    options = {"xatol": 1e-5, "fatol": 1e-9, "maxiter": 600}
    found = min(
        (minimize(value, start, method="Nelder-Mead", options=options) for start in starts), key=lambda f: f.fun
    )
    return float(found.fun), gains(found.x)  # type: ignore[return-value]


class Optimum(NamedTuple):
    """Least J, its gains kp, ki and kd, and the errors that J is counted in."""

    j: float
    gains: Array
    reference: tuple[float, float]


@cache
def reference(loop: Loop) -> tuple[float, float]:
    """Return the least errors of PI at Ms = 1.59, each step for itself."""
    load, _ = least(loop, 1.59, False, lambda load, _: load)
    output, _ = least(loop, 1.59, False, lambda _, output: output)
    return load, output


def optimum(loop: Loop, peak: float, derivative: bool) -> Optimum:
    """Return the optimum of Grimholt and Skogestad for one loop."""
    load, output = reference(loop)
    j, gains = least(loop, peak, derivative, lambda a, b: 0.5 * (a / load + b / output))
    return Optimum(j, gains, (load, output))


def study_of(lag: float, peak: float, derivative: bool):  # noqa: ANN201
    """Return our study of one loop: ranges a decade or so about the SIMC rule."""
    kc = (lag + 1.0 / 3.0) / 2.0
    ki = kc / min(lag + 1.0 / 3.0, 8.0)
    ranges = {"kp": (kc / 8.0, kc * 4.0), "ki": (ki / 8.0, ki * 4.0), "kd": (kc / 40.0, kc)}
    gains: dict = {f"level.{name}": {"low": low, "high": high} for name, (low, high) in ranges.items()}
    gains = {**gains, "level.t_f": 1e-4, **({} if derivative else {"level.kd": 0.0})}
    scenarios = [
        {"name": name, "duration": DURATION, "search": 1, "held_out": 2, "disturbance": {name: {"kind": "step"}}}
        for name in ("load", "shift")
    ]
    tables = {
        "title": "First order plus dead time",
        "seed": 1,
        "plant": {"file": "dead_time.py", "control_period": 1.0 / PERIODS, "parameters": {"lag": lag}},
        "actuator": [{"name": "valve", "delay": 1.0}],
        "channel": [{"name": "level", "law": "pid", "output": "level", "to": "valve", "limit": 100.0}],
        "gains": gains,
        "scenario": scenarios,
        "objective": [{"metric": "iae.level", "scenario": each["name"]} for each in scenarios],
        "margin": [{"quantity": "ms", "max": peak}],
        "search": {"algorithm": "nsga2", "population": POPULATION, "generations": GENERATIONS},
    }
    return make_study(tables, "dead_time", STUDIES)


def front_of(lag: float, peak: float, derivative: bool) -> tuple[Array, Array]:
    """Return the errors (n, 2) and gains (n, 4) of the front that our search finds."""
    study = study_of(lag, peak, derivative)
    problem = Problem(study.system, study.space, study.objectives, study.constraints, study.seed, 1, study.screens)
    flown = tuple(FlightBatch(batch.spec, SEARCH, 1) for batch in study.scenarios)
    draw = generator(study.seed, "search/initial", 0)
    first = initial_design(np.full((1, len(study.space.variables)), 0.5), POPULATION, draw)
    search = SEARCHES["nsga2"](first, 2, len(study.constraints) + len(study.requirements), 1)
    *_, done = search_generations(search, lambda points: problem.evaluate(points, flown), StoppingRule(GENERATIONS))
    found = archive(done)
    front = found.front()
    return found.values[front], study.space.gains(found.points[front])


def main() -> None:
    """Print the table."""
    print("| dead time / lag | law | Ms | J, optimum | J(0) | our front's least J | over the optimum |")
    print("|---:|---|---:|---:|---:|---:|---:|")
    for ratio in RATIOS:
        for derivative in (False, True):
            for peak in PEAKS:
                lag = 1.0 / ratio
                wanted = optimum(Loop(PERIODS, lag), peak, derivative)
                finer = optimum(Loop(2 * PERIODS, lag), peak, derivative).j
                errors, _ = front_of(lag, peak, derivative)
                ours = float(np.min(np.mean(errors / wanted.reference, axis=1), axis=0))
                print(
                    f"| {ratio:g} | {'PID' if derivative else 'PI'} | {peak:g} | {wanted.j:.4f} | {2 * finer - wanted.j:.4f} "
                    f"| {ours:.4f} | {100 * (ours / wanted.j - 1):+.2f} % |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
