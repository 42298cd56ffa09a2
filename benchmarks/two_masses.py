"""Two masses and a spring: a tuned law beside a textbook one where the stiffness is uncertain, `python -m benchmarks.two_masses`.

B. Wie, D. S. Bernstein, "A benchmark problem for robust control design", American Control Conference 1990. The textbook law is
Z. Gao's bandwidth rule (American Control Conference 2003), zeta = 1 and omega_o = 4 omega_c, as fast as the nominal
spring allows; ours is the study `studies/two_masses.toml`. Both are linear active disturbance rejection that sees the second mass
alone. Instability is told by the poles, settling by flights; intervals are those of Clopper and Pearson at 95 %.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import beta

from objectives.margins.plant_margins import PlantMargins
from objectives.problem import FlightBatch, Problem
from plant.quadrotor.scenarios import HELD_OUT, SEARCH
from plant.seeds import generator
from tuner.api.studies import load_study
from tuner.search.convergence import StoppingRule
from tuner.search.initial_design import initial_design
from tuner.search.loop import archive, search_generations
from tuner.search.registry import SEARCHES
from tuner.study.plant_study import PlantStudy

Array = np.ndarray
STUDY = Path(__file__).parents[1] / "studies" / "two_masses.toml"
SPREAD, DRAWS, FLIGHTS = 0.2, 300, 1024


def growth(system, gains: Array, stiffness: float) -> Array:  # noqa: ANN001
    """Return the rate [1/s] of the slowest decay or fastest growth of gains rows (n, 3) with a spring of this stiffness."""
    there = replace(system, parameters=system.plant.Parameters(stiffness=stiffness))
    return PlantMargins(there, np.min(gains, axis=0), np.max(gains, axis=0)).evaluate(gains).growth[:, 0]


def textbook(system) -> Array:  # noqa: ANN001
    """Return the gains of the bandwidth rule whose slowest pole decays fastest with the nominal spring."""
    wc = np.geomspace(0.02, 1.0, 200)
    rows = np.stack([wc, np.ones_like(wc), 4.0 * wc], axis=1)
    return rows[np.argmin(growth(system, rows, 1.0), axis=0)]


def tuned(study, problem: Problem) -> Array:  # noqa: ANN001
    """Return the gains of our front that settle soonest in the worst of the search's flights."""
    batches = tuple(FlightBatch(entry.spec, SEARCH, entry.search) for entry in study.scenarios)
    draw = generator(study.seed, "search/initial", 0)
    start = study.space.point(study.default_row)[None]
    search = SEARCHES["nsga2"](initial_design(start, 24, draw), 2, 0, 1)
    *_, done = search_generations(search, lambda points: problem.evaluate(points, batches), StoppingRule(24))
    found = archive(done)
    front = found.front()
    best = front[np.argmin(found.values[front, 0], axis=0)]
    return study.space.gains(found.points[[best]])[0]


def interval(count: int, of: int) -> tuple[float, float]:
    """Return the interval of Clopper and Pearson at 95 % for a probability, from a count."""
    low = beta.ppf(0.025, count, of - count + 1) if count else 0.0
    high = beta.ppf(0.975, count + 1, of - count) if count < of else 1.0
    return float(low), float(high)


def share(count: int, of: int) -> str:
    """Return a probability with its interval, in percent."""
    low, high = interval(count, of)
    return f"{100 * count / of:.1f} [{100 * low:.1f}, {100 * high:.1f}] %"


def main() -> None:
    """Print the table."""
    study = load_study(STUDY, kind=PlantStudy)
    problem = Problem(study.system, study.space, study.objectives, study.constraints, study.seed, 1)
    spec = study.scenarios[0].spec
    flown = (FlightBatch(spec, HELD_OUT, FLIGHTS),)
    springs = 1.0 + SPREAD * np.random.default_rng(1990).uniform(-1.0, 1.0, DRAWS)
    laws = {"bandwidth rule": textbook(study.system), "tuned": tuned(study, problem)}
    rows = np.array(list(laws.values()))
    decay = np.array([growth(study.system, rows, k) for k in springs])
    print(
        "| law | omega_c, zeta, omega_o | unstable | settled in 120 s | settling: median, 95 % | nominal decay [1/s] |"
    )
    print("|---|---|---:|---:|---:|---:|")
    for i, (name, row) in enumerate(laws.items()):
        times = problem.evaluate(study.space.point(row)[None], flown).scores[0, 0]
        settled = int(np.sum(times < spec.duration - spec.recovery_from - 1e-9, axis=0))
        level = f"{np.median(times, axis=0):.1f}, {np.quantile(times, 0.95, axis=0):.1f} s"
        gains = ", ".join(f"{value:.3f}" for value in row)
        unstable = share(int(np.sum(decay[:, i] > 0.0, axis=0)), DRAWS)
        print(
            f"| {name} | {gains} | {unstable} | {share(settled, FLIGHTS)} | {level} | {-growth(study.system, rows, 1.0)[i]:.4f} |"
        )


if __name__ == "__main__":
    main()
