"""Modes that a ladder loses behind a nearer one: a ladder for each.

Demand that rises early draws the states of the first levels away from a mode whose demand rises late, though failures of that
mode may be the more probable ones: K. Breitung, "The geometry of limit state function graphs and subset simulation:
counterexamples", Reliability Engineering & System Safety 182:98-106, 2019 (arXiv 1705.04453). So failures are looked for
without any level: under normals of inflated deviation (C. G. Bucher, "Asymptotic sampling for high-dimensional reliability
analysis", Probabilistic Engineering Mechanics 24(4):504-510, 2009). The design points next to them are sought, to states that
hardly hold, and to those of the ladder. If they differ by more than 60 degrees, the space is split into the two sectors of
normals closer in direction to either kind, and both get a ladder. Together they count every failure once, so the estimate is
unbiased wherever the border lies. They replace the one ladder where one of them is starved on the way: its part of the states
at some level is `STARVED` times less than its part of the failures.

Looked for in up to `MAX_DIMENSIONS`, as each gradient takes that many rows, and inflated noise of more dimensions no longer
fails as noise does. Beyond that, the one ladder stays: its replicas are unbiased and spread widely, so the interval of such an
event at 1e-4 in 100 dimensions took ten times the evaluations (30 of 30 held it). A mode that no replica meets is missed; only
named modes are safe. Of three modes, two that hide from each other share a sector.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tuner.extensions.tails.estimation.design_point import WholeSpace, find_design_point, search_evaluations
from tuner.extensions.tails.estimation.limit_function import Array, LimitFunction
from tuner.extensions.tails.estimation.splitting import Ascent, Sampler, climb, run_together

MAX_DIMENSIONS = 64
INFLATED = (1.5, 2.0, 3.0, 4.0)
"""Deviations that are tried until `ENOUGH` states fail."""
ROWS, ENOUGH = 200, 8
STEPS = 3
"""Number of steps of the search for a design point: directions are enough."""
SAME_MODE = 0.5
"""Cosine of design points above which two failures belong together: 60 degrees."""
STARVED = 4.0
SHARPNESS = 10.0
"""Sharpness of the border between sectors, in demand per standard deviation: levels below 1 lie up to 0.1 beyond it."""


class Sector(NamedTuple):
    """Normals closer to directions `near` than to `far`; unit vectors (k, d), (l, d)."""

    mode: int
    near: Array
    far: Array


@dataclass(frozen=True)
class SectorLimit:
    """A limit function with a further column for each sector: the demand of its mode, less outside.

    Attributes:
        limit: limit function.
        sectors: sectors whose columns follow those of the limit function.
    """

    limit: LimitFunction
    sectors: tuple[Sector, ...]

    @property
    def dimension(self) -> int:
        """Return that of the limit function."""
        return self.limit.dimension

    @property
    def modes(self) -> tuple[str, ...]:
        """Return a name for each column."""
        names = self.limit.modes
        return (*names, *(names[sector.mode] for sector in self.sectors))

    def values(self, normals: Array) -> Array:
        """Return demand over capacity (n, m + sectors); at least 1 within a sector where its mode fails."""
        values = self.limit.values(normals)
        return np.column_stack([values, *(np.minimum(values[:, s.mode], _inside(s, normals)) for s in self.sectors)])


def _inside(sector: Sector, normals: Array) -> Array:
    """Return a demand (n,) that reaches 1 within a sector."""
    return 1.0 + SHARPNESS * (_largest(normals, sector.near) - _largest(normals, sector.far))


def _largest(normals: Array, directions: Array) -> Array:
    """Return the largest projection (n,) on directions; summed row by row, so bits do not depend on the company."""
    return np.max([np.sum(normals * direction, axis=1) for direction in directions], axis=0)


def look_for_failures(mode: int, dimension: int, rng: np.random.Generator) -> Sampler[Array]:
    """Return failures (n, d) found without levels, and states near one."""
    for scale in INFLATED:
        states = scale * rng.standard_normal((ROWS, dimension))
        values = yield states
        order = np.argsort(-values[:, mode], kind="stable")
        fail = np.count_nonzero(values[:, mode] >= 1.0)
        if fail >= ENOUGH:
            # The largest demands of flights that still hold belong to what draws the ladder's states away.
            chosen = [*rng.permutation(order[:fail])[:ENOUGH], *order[fail : fail + ENOUGH]]
            return states[chosen]
    return np.empty((0, dimension))


def directions(limit: LimitFunction, mode: int, states: Array) -> Array:
    """Return unit vectors (n, d) to the design points next to states."""
    space = WholeSpace(limit.dimension)
    ends = [find_design_point(limit, mode, space, state, STEPS) for state in states]
    points = [point / np.linalg.norm(point) for point in ends if point is not None and np.any(point)]
    return np.array(points).reshape(-1, states.shape[-1])


def divide(
    limit: LimitFunction, ascent: Ascent, chains: int, smallest: float, rng: np.random.Generator
) -> tuple[tuple[Sector, Ascent], ...]:
    """Return sectors with their ascents where a mode hides; none otherwise.

    Args:
        limit: limit function.
        ascent: to a mode of it.
        chains: number of seeds of a level.
        smallest: probability below which the climb ends.
        rng: source of random numbers of the search.
    """
    mode = ascent.ladder.mode
    [failures] = run_together(limit, [look_for_failures(mode, limit.dimension, rng)])
    sectors = split_off(mode, directions(limit, mode, np.concatenate([ascent.some_states(ENOUGH), failures])))
    if not sectors:
        return ()
    within = SectorLimit(limit, sectors)
    columns = (len(limit.modes), len(limit.modes) + 1)
    ascents = run_together(within, [climb(column, limit.dimension, chains, smallest, rng) for column in columns])
    # What no ladder reaches is left out, which must be for its rarity alone.
    is_complete = not any(ascent.is_stalled for ascent in ascents)
    return tuple(zip(sectors, ascents, strict=True)) if is_complete and is_starved(*ascents) else ()


def most_evaluations(dimension: int) -> int:
    """Return the most rows of a search before any ladder."""
    return ROWS * len(INFLATED) + 3 * ENOUGH * search_evaluations(dimension, STEPS)


def split_off(mode: int, directions: Array) -> tuple[Sector, Sector] | None:
    """Return sectors of the failures like the first and of all others; None where none differs.

    Args:
        mode: column of the limit function's values.
        directions: unit vectors to design points (n, d).
    """
    if not len(directions):
        return None
    is_alike = directions @ directions.T > SAME_MODE
    far = ~is_alike[0]
    # A search that ends where two limits meet belongs to both modes, and would chain one to the other.
    near = is_alike[0] & ~np.any(is_alike[:, far], axis=1)
    if not near.any() or not far.any():
        return None
    return Sector(mode, directions[near], directions[far]), Sector(mode, directions[far], directions[near])


def is_starved(first: Ascent, second: Ascent) -> bool:
    """Return True if either part is starved at some level."""
    levels = sorted({*first.ladder.levels, *second.ladder.levels, min(first.ladder.target, second.ladder.target)})
    logs = [np.log(ascent.probability_at(level)) for ascent in (first, second) for level in levels]
    odds = np.subtract(*np.split(np.array(logs), 2))
    ends = first.probability / (first.probability + second.probability)
    shares = 1.0 / (1.0 + np.exp(-odds))
    return bool(ends > STARVED * np.min(shares) or 1.0 - ends > STARVED * np.min(1.0 - shares))
