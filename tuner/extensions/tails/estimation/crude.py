"""Crude Monte Carlo in bounded memory: batches of independent rows, counted."""

import numpy as np

from tuner.extensions.tails.estimation.limit_function import Array, LimitFunction, Replica
from tuner.extensions.tails.estimation.splitting import evaluate

BATCH = 4096
NUMBERS = 6_000_000
"""Standard normals held at once, 48 MB."""


def count_failures(limit: LimitFunction, number: int, rows: int, curve: Array, rng: np.random.Generator) -> Replica:
    """Return the shares of rows that reach a curve's levels.

    Args:
        limit: limit function.
        number: number of the batch.
        rows: drawn.
        curve: increasing levels; the last is 1.
        rng: source of random numbers of the batch alone.
    """
    reached, failed = np.zeros(len(curve), dtype=int), np.zeros(len(limit.modes), dtype=int)
    at_once = max(NUMBERS // max(limit.dimension, 1), 1)
    for begin in range(0, rows, at_once):
        values = evaluate(limit, rng.standard_normal((min(at_once, rows - begin), limit.dimension)))
        reached += np.count_nonzero(np.max(values, axis=1)[:, None] >= curve, axis=0)
        failed += np.count_nonzero(values >= 1.0, axis=0)
    shares = tuple((reached / rows).tolist())
    return Replica(number, shares[-1], tuple((failed / rows).tolist()), shares, rows)
