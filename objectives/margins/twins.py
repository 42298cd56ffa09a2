"""Integrals of one error in several channels.

State feedback with several inputs has them. The channels of one output integrate the same error, so one integral is a multiple of
the other: no signal of the loop moves the difference, whose pole at 1 is none of the loop's. Such integrals become one state, and
set points of these channels move together.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.margins.linearise import LinearLoops
from plant.model.plan import LoopPlan
from plant.records import paths

Array = NDArray[np.float64]
# Relative difference of two rows that are multiples of each other.
PARALLEL = 1e-12


class Twins(NamedTuple):
    """Channels of one output and law.

    Attributes:
        channels: Their numbers.
        pairs: Numbers of states of two of them that may be multiples of each other.
    """

    channels: list[int]
    pairs: list[tuple[int, int]]


def twins_of(plan: LoopPlan, states: tuple[str, ...]) -> list[Twins]:
    """Return the channels that share output and law."""
    return [twins for twins in _groups(plan, states) if len(twins.channels) > 1]


def _groups(plan: LoopPlan, states: tuple[str, ...]) -> Iterator[Twins]:
    for output, law in dict.fromkeys((each.output, each.law) for each in plan.channels):
        members = [each for each in plan.channels if (each.output, each.law) == (output, law)]
        places = [[states.index(f"control.laws.{each.name}.{path}") for path in paths(law.Memory)] for each in members]
        pairs = [pair for one, other in combinations(places, 2) for pair in zip(one, other, strict=True)]
        yield Twins([plan.names.index(each.name) for each in members], pairs)


def merge_twins(loops: LinearLoops, groups: list[Twins]) -> LinearLoops:
    """Return the loops with integrals of one error as one state."""
    if not groups:
        return loops
    b, c, d = loops.b.copy(), loops.c.copy(), loops.d.copy()
    # What a limit takes off a command stays 0 within the limits.
    active = np.any(loops.a, axis=-1) | np.any(loops.b, axis=-1)
    a = np.where(np.asarray(active)[:, None, :], loops.a, 0.0)
    for channels, pairs in groups:
        merged = np.zeros(len(a), dtype=bool)
        for i, j in pairs:
            ratio = _ratio(a, b[..., : loops.terms.stop], i, j)
            rows = np.nonzero(ratio)[0]
            for part in (a, c):
                part[rows, :, i] += ratio[rows, None] * part[rows, :, j]
                part[rows, :, j] = 0.0
            a[rows, j] = b[rows, j] = 0.0
            merged[rows] = True
        columns = loops.reference.start + np.array(channels)
        for part in (b, d):
            part[np.ix_(merged, np.arange(part.shape[1]), columns)] = part[merged][..., columns].sum(axis=-1)[..., None]
    return replace(loops, a=a, b=b, c=c, d=d)


def _ratio(a: Array, b: Array, i: int, j: int) -> Array:
    """Return state j over state i (n,), both integrals of one signal; 0 where they are not."""
    one, other = (np.concatenate([a[:, k], b[:, k]], axis=-1) for k in (i, j))
    one[:, i] -= 1.0
    other[:, j] -= 1.0
    size = np.sum(one * one, axis=-1)
    ratio = np.sum(one * other, axis=-1) / np.where(size > 0.0, size, 1.0)
    difference = np.linalg.norm(other - ratio[:, None] * one, axis=-1)
    is_integral = (np.abs(one[:, i]) < PARALLEL) & (np.abs(other[:, j]) < PARALLEL)
    return np.where(is_integral & (difference <= PARALLEL * np.linalg.norm(other, axis=-1)), ratio, 0.0)
