"""Search by a model. For costly flights, some hundreds of candidates and up to some twenty gains.

A Gaussian process stands for each objective, each constraint that was ever broken and for what is known without flying. A
generation is chosen from a pool of points one after the other: each adds most to the hypervolume of the front and of those chosen
before it, in the mean over common samples of the models, times the chance that it keeps the limits. That is the expected
hypervolume improvement (M. Emmerich, K. Giannakoglou, B. Naujoks, IEEE Trans. Evolutionary Computation 10(4):421-439, 2006) of a
batch (S. Daulton, M. Balandat, E. Bakshy, "Differentiable expected hypervolume improvement for parallel multi-objective
Bayesian optimization", NeurIPS 2020), and with one objective the expected improvement.
"""

from collections.abc import Callable

import numpy as np
from scipy.stats.qmc import Sobol

from plant.seeds import generator
from tuner.search.constraint_ranking import power_of_two
from tuner.search.front import feasible_front
from tuner.search.improvement import directions, improvements, reached
from tuner.search.scaling import spread
from tuner.search.surrogate import Expectation, Shape, Surrogate, fitted_shape

Array = np.ndarray
Excess = Callable[[Array], Array]
# Points of the pool, and the share of them that fills the cube; the others lie around the best points so far.
POOL, GLOBAL = 512, 0.25
# Joint samples of the objectives over the pool, and directions in which the front is measured.
SAMPLES, DIRECTIONS = 128, 64
# Values beyond this many spreads above the smallest are as bad as any; logarithms even out what is below.
WORST = 1e4
# Largest number of points that a model is told: the best ones.
MOST_TOLD = 400
# Growth of the number of points after which length scales are looked for again.
GROWTH = 1.1
# Parents of the pool at least; and points that are looked at again, or screened, together.
PARENTS, TOGETHER = 8, 8
# Reach of the reference point beyond the default, in units of how far the front is ahead of it; and how far it is from the best
# values at least, in spreads.
BEYOND, LEAST_EDGE = 0.1, 2.0


class GaussianProcess:
    """Ask for a generation of points, tell what they were worth.

    first: points (n, d) of the first generation; its size is the batch. seed: of all later draws. excess: by how much points
    (n, d) break what is known without flying (n,), 0 or less where they keep it; what breaks it is not asked for, nor are the
    objectives of such a point believed.
    """

    def __init__(
        self, first: Array, n_objectives: int, n_constraints: int, seed: int, excess: Excess | None = None
    ) -> None:
        self._seed, self._objectives = seed, n_objectives
        self._points, self._values = np.empty((0, first.shape[1])), np.empty((0, n_objectives))
        self._violations = np.empty((0, n_constraints))
        self._screen = Screen(excess, first.shape[1]) if excess else None
        self._shapes: dict[str, tuple[int, Shape]] = {}
        self._sobol = Sobol(first.shape[1], scramble=True, rng=generator(seed, "search/gaussian_process/pool", 0))
        self._batch, self._generation = len(first), 0
        self._asked: Array | None = first.copy()

    def ask(self) -> Array:
        """Return the next generation (n, d), points of the unit cube."""
        if self._asked is None:
            self._asked = self._chosen()
        return self._asked.copy()

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and constraint violations (n, c) of the generation asked for."""
        points = self.ask()
        self._points = np.concatenate([self._points, points])
        self._values = np.concatenate([self._values, values])
        self._violations = np.concatenate([self._violations, violations])
        if self._screen:
            self._screen.known(points)
        self._generation += 1
        self._asked = None

    def _chosen(self) -> Array:
        """Return the next generation (n, d)."""
        draw = generator(self._seed, "search/gaussian_process", self._generation)
        pool = self._pool(draw)
        flown = self._screen.known(self._points) <= 0.0 if self._screen else np.ones(len(self._points), dtype=bool)
        limits = self._limits(pool, flown)
        chance = np.prod([below for _, below in limits], axis=0) * np.ones(len(pool))
        front = feasible_front(self._values, self._violations)
        if len(front):
            pick = self._improving(pool, flown, front, draw)
        else:
            pick = Hope([expected for expected, _ in limits], len(pool), draw)
        return pool[self._picked(pool, pick, chance)]

    def _pool(self, draw: np.random.Generator) -> Array:
        """Return different points (p, d), none of which was told before."""
        dimensions = self._points.shape[1]
        spread_out = self._sobol.random(round(POOL * GLOBAL))
        near = children(self._parents(), POOL - len(spread_out), draw)
        pool = np.concatenate([spread_out, near])
        _, rows = np.unique(np.concatenate([self._points, pool]), axis=0, return_index=True)
        return pool[np.sort(rows[rows >= len(self._points)]) - len(self._points)].reshape(-1, dimensions)

    def _parents(self) -> Array:
        """Return the best points (k, d) so far: the front, and those that break least or are next behind it."""
        front = feasible_front(self._values, self._violations)
        total = np.maximum(self._violations, 0.0) / units(self._violations)
        behind = np.lexsort((self._depth(), total.sum(axis=1)))
        return self._points[np.unique(np.concatenate([front, behind[:PARENTS]]))]

    def _depth(self) -> Array:
        """Return a measure (n,) of how far back each point is: the mean of its objectives, evened out."""
        return evened(self._values, np.ones(len(self._values), dtype=bool)).mean(axis=1)

    def _limits(self, pool: Array, flown: Array) -> list[tuple[Expectation, Array]]:
        """Return what is expected of each limit that was ever broken, and the chance (p,) that points of the pool keep it."""
        found = []
        if self._screen:
            found.append(self._kept("known", self._screen.points, self._screen.told(), pool, 0.0))
        for i, unit in enumerate(units(self._violations)):
            told = self._violations[flown, i]
            if np.any(told > 0.0):
                # Where no slack is told, a tenth of what is usual beyond the limit counts as none.
                level = 0.0 if np.any(told < 0.0) else 0.1
                evened_out = np.sign(told) * np.log1p(np.minimum(np.abs(told) / unit, WORST))
                found.append(self._kept(f"constraint {i}", self._points[flown], evened_out, pool, level))
        return found

    def _kept(
        self, name: str, points: Array, targets: Array, pool: Array, level: float
    ) -> tuple[Expectation, Array]:
        nearest = np.argsort(np.abs(targets), kind="stable")[:MOST_TOLD]
        expected = self._model(name, points[np.sort(nearest)], targets[np.sort(nearest)]).at(pool)
        return expected, expected.chance_below(level)

    def _model(self, name: str, points: Array, targets: Array) -> Surrogate:
        """Return the surrogate of a quantity; its shape is looked for again as points become more."""
        size, shape = self._shapes.get(name, (0, None))
        if shape is None or len(points) >= GROWTH * size:
            shape = fitted_shape(points, targets, shape)
            self._shapes[name] = (len(points), shape)
        return Surrogate(points, targets, shape)

    def _improving(self, pool: Array, flown: Array, front: Array, draw: np.random.Generator) -> "Improvement":
        """Return what rows of the pool (p, d) add to the hypervolume of the front."""
        rows = np.flatnonzero(flown)
        targets = evened(self._values, flown)
        told = np.sort(rows[np.argsort(targets[rows].mean(axis=1), kind="stable")[:MOST_TOLD]])
        samples = np.empty((SAMPLES, len(pool), self._objectives))
        for j in range(self._objectives):
            model = self._model(f"objective {j}", self._points[told], targets[told, j])
            normals = draw.standard_normal((SAMPLES, len(pool)))
            samples[:, :, j] = np.minimum(model.at(pool).samples(normals), np.log1p(WORST))
        box = Box(np.expm1(targets), front, bool(flown[0]))
        along = directions(DIRECTIONS, self._objectives, draw)
        return Improvement(box.ahead(np.expm1(samples)), box.ahead(np.expm1(targets[front])), along)

    def _picked(self, pool: Array, gain: "Improvement | Hope", chance: Array) -> Array:
        """Return rows of the pool (n,): the best one after the other, none that breaks what is known.

        What a row adds shrinks with every row chosen, so only rows that were worth more before are looked at again.
        """
        worth = gain.of(np.arange(len(pool))) * chance
        fresh, asked = np.ones(len(pool), dtype=bool), np.full(len(pool), self._screen is None)
        possible, picked = np.ones(len(pool), dtype=bool), list[int]()
        while len(picked) < self._batch:
            open_rows = np.flatnonzero(possible)
            order = open_rows[np.lexsort((-chance[open_rows], -worth[open_rows]))][:TOGETHER]
            if not fresh[order[0]]:
                stale = order[~fresh[order]]
                worth[stale], fresh[stale] = gain.of(stale) * chance[stale], True
            elif not asked[order[0]] and self._screen:
                few = order[~asked[order]]
                possible[few], asked[few] = self._screen.known(pool[few]) <= 0.0, True
                # Where nothing in the pool keeps what is known, what breaks it has to do.
                possible[few] |= np.sum(possible) < self._batch
            else:
                picked.append(int(order[0]))
                possible[order[0]] = False
                gain.choose(picked[-1])
                fresh[:] = False
        return np.array(picked)


class Improvement:
    """What points of a pool add to a front and to those chosen, in the mean over samples (s, p, m).

    samples, front (k, m): how far points are ahead of a reference in each objective; along (l, m): directions.
    """

    def __init__(self, samples: Array, front: Array, along: Array) -> None:
        self._samples, self._along = samples, along
        best = np.zeros(len(along))
        reached(front, along, best)
        self._best = np.tile(best, (len(samples), 1))

    def of(self, rows: Array) -> Array:
        """Return the improvement by each of some rows of the pool (r,)."""
        return improvements(np.ascontiguousarray(self._samples[:, rows]), self._along, self._best)

    def choose(self, row: int) -> None:
        """Count a row of the pool as tried: in each sample, as what it is there."""
        for sample, best in zip(self._samples, self._best, strict=True):
            reached(sample[row : row + 1], self._along, best)


class Hope:
    """How little points of a pool may break, while nobody knows one that keeps every limit: drawn anew for each choice."""

    def __init__(self, limits: list[Expectation], count: int, draw: np.random.Generator) -> None:
        self._limits, self._count, self._draw = limits, count, draw
        self.choose(0)

    def of(self, rows: Array) -> Array:
        """Return the hope put in rows of the pool (r,): 1 for one that breaks nothing."""
        return self._drawn[rows]

    def choose(self, _: int) -> None:
        """Draw anew."""
        broken = np.zeros(self._count)
        for limit in self._limits:
            broken += np.maximum(limit.mean + limit.deviation * self._draw.standard_normal(self._count), 0.0)
        self._drawn = np.exp(-broken)


class Screen:
    """What is known without flying, asked once for each point. points (n, d): those asked for so far."""

    def __init__(self, excess: Excess, dimensions: int) -> None:
        self._excess = excess
        self._known: dict[bytes, float] = {}
        self.points = np.empty((0, dimensions))

    def known(self, points: Array) -> Array:
        """Return by how much points (n, d) break what is known (n,), 0 or less where they keep it."""
        new = np.array([point for point in points if point.tobytes() not in self._known]).reshape(-1, points.shape[1])
        if len(new):
            for point, value in zip(new, self._excess(new), strict=True):
                self._known[point.tobytes()] = float(value)
            self.points = np.concatenate([self.points, new])
        return np.array([self._known[point.tobytes()] for point in points])

    def told(self) -> Array:
        """Return the excess (n,) of `points`, evened out."""
        excess = np.array([self._known[point.tobytes()] for point in self.points])
        return np.sign(excess) * np.log1p(np.minimum(np.abs(excess), WORST))


class Box:
    """The part of the objectives in which the front is measured: from its smallest values to a reference point.

    values (n, m): of all points, the default's first; front: rows. Its reference is a tenth beyond the default, as that of the
    hypervolume that people are shown, or beyond the middle of the front where that does not come up to the default.
    """

    def __init__(self, values: Array, front: Array, default_counts: bool) -> None:
        found = values[front]
        self._low = found.min(axis=0)
        anchor = np.median(found, axis=0)
        default_counts = default_counts and bool(np.all(values[0] < WORST))
        anchor = np.maximum(anchor, values[0] if default_counts else found.max(axis=0))
        self._reference = self._low + np.maximum((1.0 + BEYOND) * (anchor - self._low), LEAST_EDGE)

    def ahead(self, values: Array) -> Array:
        """Return how far values (..., m) are ahead of the reference, in edges of the box."""
        return (self._reference - values) / (self._reference - self._low)


def evened(values: Array, believed: Array) -> Array:
    """Return logarithms (n, m) of values, 0 at the smallest of those believed (n,), 0.7 at what is usual among the better ones."""
    targets = np.zeros_like(values)
    for j, column in enumerate(values.T):
        ordered = np.sort(column[believed])
        low, unit = (ordered[0], spread(ordered)) if len(ordered) else (0.0, 1.0)
        reach = np.clip(column, low, low + min(WORST * unit, 1e300)) - low
        targets[:, j] = np.log1p(reach / unit)
    return targets


def units(violations: Array) -> Array:
    """Return a unit (c,) for each constraint: the median of what is broken, see `constraint_ranking`."""
    broken = [column[column > 0.0] for column in violations.T]
    return np.array([power_of_two(float(np.median(column))) if len(column) else 1.0 for column in broken])


def children(parents: Array, count: int, draw: np.random.Generator) -> Array:
    """Return points (count, d) around and between parents (k, d)."""
    k, dimensions = parents.shape
    base, other = parents[draw.integers(k, size=count)], parents[draw.integers(k, size=count)]
    between = np.where(draw.uniform(size=(count, 1)) < 0.5, draw.uniform(-0.5, 1.5, size=(count, 1)), 0.0)
    width = np.exp(draw.uniform(np.log(0.003), np.log(0.3), size=(count, 1)))
    moved = draw.uniform(size=(count, dimensions)) < max(0.5, 3.0 / dimensions)
    step = width * draw.standard_normal((count, dimensions)) * moved
    return np.clip(base + between * (other - base) + step, 0.0, 1.0)
