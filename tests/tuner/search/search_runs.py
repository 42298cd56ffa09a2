"""Problems and runs for the contract of the searches; as a program, digests of runs for a process of its own."""

import hashlib
import sys

import numpy as np

from plant.seeds import generator
from tuner.search.initial_design import initial_design
from tuner.search.names import ALGORITHMS
from tuner.search.registry import SEARCHES

# Two objectives for what takes them, one for what takes one; and each once at the other end of what it takes.
CASES = [(name, 2 if entry.supports(2) else 1) for name, entry in ALGORITHMS.items()]
MORE_CASES = [
    *CASES,
    ("gaussian_process", 4),
    ("nsga2", 1),
    ("nsga2", 3),
    ("nsga3", 5),
    ("age_moea", 3),
    ("random", 1),
    ("sobol", 1),
]
# No number of Das-Dennis directions in three objectives or more; small, for a model's points cost more the more there are.
POPULATION = 8
# Such a number too, for what is compared with chance.
LARGE_POPULATION = 26
# A model learns from one generation and proposes the others.
GENERATIONS, FEW_GENERATIONS = 5, 3


def started(dimensions, population=POPULATION, seed=1):
    return initial_design(np.full((1, dimensions), 0.5), population, generator(seed, "first", 0))


def run(name, objectives, problem, dimensions=4, population=POPULATION, generations=None, seed=1, first=None):
    """Return points, values and violations of all generations (generations, n, ...)."""
    generations = generations or (FEW_GENERATIONS if name == "gaussian_process" else GENERATIONS)
    first = started(dimensions, population) if first is None else first
    n_constraints = problem(first)[1].shape[1]
    return run_generations(SEARCHES[name](first, objectives, n_constraints, seed), problem, len(first), generations)


def run_generations(search, problem, population, generations):
    """Return points, values and violations of a search's generations (generations, n, ...)."""
    done = [ask_generation(search, problem, population) for _ in range(generations)]
    return tuple(np.stack(part, axis=0) for part in zip(*done, strict=True))


def ask_generation(search, problem, population):
    """Return points, values and violations of the next generation, which a search may ask for in parts."""
    parts = []
    while sum(len(part[0]) for part in parts) < population:
        points = search.ask()
        parts.append((points, *problem(points)))
        search.tell(*parts[-1][1:])
    return tuple(np.concatenate(part) for part in zip(*parts, strict=True))


def bowls(objectives):
    """Return a convex problem: squared distances to a point for each objective, all on a grid of 2^-30."""

    def values(points):
        middles = np.linspace(0.25, 0.75, objectives)[:, None] if objectives > 1 else np.array([[0.3125]])
        distance = np.square(points[None] - middles[:, None]).sum(axis=2).T
        return np.round(distance * 2.0**30) / 2.0**30

    return lambda points: (values(points), np.zeros((len(points), 0)))


def stepped(objectives):
    """Return the same with two constraints that many candidates break equally: a share of flights, and a length."""

    def problem(points):
        share = np.ceil(np.maximum(0.375 - points[:, 0], 0.0) * 8.0) / 8.0
        length = np.floor(points.mean(axis=1) * 4.0) * 256.0
        return bowls(objectives)(points)[0], np.stack([share, np.maximum(length - 256.0, 0.0)], axis=1)

    return problem


def digests(seed):
    """Return a line with the digest of a run for each case; seed: of NumPy's own generator, which no search uses."""
    np.random.seed(seed)  # noqa: NPY002
    np.random.uniform(size=7)  # noqa: NPY002
    runs = ((case, run(*case, stepped(case[1]), dimensions=12)[0]) for case in CASES)
    return [f"{case} {hashlib.sha256(points.tobytes()).hexdigest()}" for case, points in runs]


if __name__ == "__main__":
    print(*digests(int(sys.argv[1])), sep="\n")
