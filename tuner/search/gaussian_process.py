"""Search by a model. For costly flights, some hundreds of candidates and up to some twenty gains.

A Gaussian process stands for each objective, each constraint that was ever broken and each limit that is known without flying. A
generation is chosen from a pool of points one after the other: each adds most to the hypervolume of the front and of those chosen
before it, in the mean over common samples of the models, times the chance that it keeps the limits. That is the expected
hypervolume improvement (M. Emmerich, K. Giannakoglou, B. Naujoks, IEEE Trans. Evolutionary Computation 10(4):421-439, 2006) of a
batch (S. Daulton, M. Balandat, E. Bakshy, "Differentiable expected hypervolume improvement for parallel multi-objective
Bayesian optimization", NeurIPS 2020), and with one objective the expected improvement.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from plant.seeds import generator
from plant.threads import side_by_side
from tuner.search.constraint_ranking import power_of_two
from tuner.search.front import feasible_front
from tuner.search.improvement import Box, Hope, Improvement, directions
from tuner.search.scaling import spread
from tuner.search.sobol import Sobol
from tuner.search.surrogate import Shape, Surrogate, fitted_shape

Array = np.ndarray
# Points of the pool, and how many of them fill the cube; the others lie around the best points so far.
POOL, GLOBAL = 512, 128
# Of these, those that stay for the choice, and of them those that have children in place of the others.
STAY, HOPEFUL = 192, 32
# Joint samples of the objectives over the pool, and directions in which a front of two objectives is measured and one of more: in
# space 64 are so far apart that many a point of the front decides nothing (0.939 of the best known held out, with 256 0.964).
SAMPLES, OF_TWO, OF_MORE = 64, 64, 256
# Values beyond this many spreads above the smallest are as bad as any; logarithms even out what is below.
WORST = 1e4
# Largest number of points that a model is told: of an objective the best, of a limit the closest to it.
MOST_TOLD, MOST_CLOSE = 400, 250
# Growth of the number of points after which length scales are looked for again.
GROWTH = 1.3
# Parents of the pool at least; and points that are looked at again together.
PARENTS, TOGETHER = 8, 8
# Points for which is asked what is known: for each that is still to be picked, and at least. One by one takes far longer.
ASKED, LEAST_ASKED = 3, 48


class LimitModel(NamedTuple):
    """The model of a limit, kept where its value is not above a level."""

    model: Surrogate
    level: float


class GaussianProcess:
    """Ask for a generation of points, tell what they were worth.

    first: points (n, d) of the first generation; its size is the batch. seed: of all later draws. excesses: analyses, the
    longest last, of by how much points (n, d) exceed what is known without flying (n, h), 0 or less where they keep it; what
    exceeds it is not asked for, nor are the objectives of such a point believed.
    """

    def __init__(
        self,
        first: Array,
        n_objectives: int,
        n_constraints: int,
        seed: int,
        excesses: Sequence[Callable[[Array], Array]] = (),
    ) -> None:
        self._seed, self._objectives = seed, n_objectives
        self._points, self._values = np.empty((0, first.shape[1])), np.empty((0, n_objectives))
        self._violations = np.empty((0, n_constraints))
        self._screens = [
            KnownLimits(excess, partial(self._limits, f"{'further ' * level}known"))
            for level, excess in enumerate(excesses)
        ]
        self._shapes: dict[str, tuple[int, Shape]] = {}
        self._sobol = Sobol(first.shape[1], generator(seed, "search/gaussian_process/pool", 0))
        self._batch, self._generation = len(first), 0
        self._asked: Array | None = first.copy()

    def ask(self) -> Array:
        """Return the next generation (n, d), points of the unit cube."""
        if self._asked is None:
            self._asked = self._chosen(generator(self._seed, "search/gaussian_process", self._generation))
        return self._asked.copy()

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and constraint violations (n, c) of the generation asked for."""
        self._points = np.concatenate([self._points, self.ask()])
        self._values = np.concatenate([self._values, values])
        self._violations = np.concatenate([self._violations, violations])
        self._generation += 1
        self._asked = None

    def _chosen(self, draw: np.random.Generator) -> Array:
        """Return the next generation (n, d)."""
        believed = np.ones(len(self._points), dtype=bool)
        for screen in self._screens:
            believed[believed] = screen.keeps(self._points[believed])
        known = [limit for screen in self._screens for limit in screen.models]
        broken = self._broken_limits(believed)
        front = feasible_front(self._values, self._violations)
        front = front[believed[front]]
        aims = Aims(self._points, self._values, believed, front, self._model, draw) if len(front) else None

        def gain_of(pool: Array, jointly: bool) -> Improvement | Hope:
            if aims:
                return aims.improvement(pool, jointly)
            return Hope(side_by_side(lambda limit: limit.model.at(pool), [*known, *broken]), len(pool), draw)

        pool = self._pool(draw)
        chance = chance_of(known, pool) * chance_of(broken, pool)
        order = np.argsort(-gain_of(pool, jointly=False).of(np.arange(len(pool))) * chance, kind="stable")
        offspring = children(pool[order[:HOPEFUL]], POOL - STAY, draw)
        pool = self._new(np.concatenate([pool[order[:STAY]], offspring]))
        chances = Chances(pool, chance_of(broken, pool), self._screens)
        return pool[picked(gain_of(pool, jointly=True), chances, self._batch)]

    def _pool(self, draw: np.random.Generator) -> Array:
        """Return points (p, d) over the cube and around the best so far: the front and what breaks least or is next behind it."""
        front = feasible_front(self._values, self._violations)
        depth = evened(self._values, np.ones(len(self._values), dtype=bool)).mean(axis=1)
        total = (np.maximum(self._violations, 0.0) / units(self._violations)).sum(axis=1)
        best = np.union1d(front, np.lexsort((depth, total))[:PARENTS])
        return self._new(
            np.concatenate([self._sobol.random(GLOBAL), children(self._points[best], POOL - GLOBAL, draw)])
        )

    def _new(self, pool: Array) -> Array:
        """Return the points (p, d) that were not told, each once."""
        known = {point.tobytes() for point in self._points}
        return np.array(list({point.tobytes(): point for point in pool if point.tobytes() not in known}.values()))

    def _broken_limits(self, believed: Array) -> list[LimitModel]:
        """Return a model of each constraint that was ever broken."""
        broken = self._violations[believed] / units(self._violations)
        return self._limits("constraint", self._points[believed], broken)

    def _limits(self, kind: str, points: Array, excess: Array) -> list[LimitModel]:
        """Return a model of each column of excess (n, c) at points (n, d) that was ever above 0."""

        def limit_of(i: int) -> LimitModel | None:
            return self._limit(f"{kind} {i}", points, excess[:, i])

        return [limit for limit in side_by_side(limit_of, range(excess.shape[1])) if limit is not None]

    def _limit(self, name: str, points: Array, excess: Array) -> LimitModel | None:
        """Return the model of an excess (n,) at points (n, d), None where it was never above 0."""
        if not np.any(excess > 0.0):
            return None
        # Far from the limit it says nothing of where the limit is. Where no slack is told, a tenth counts as none.
        targets = np.clip(excess, -1.0, 1.0)
        level = 0.0 if np.any(excess < 0.0) else 0.1
        rows = np.sort(np.argsort(np.abs(targets), kind="stable")[:MOST_CLOSE])
        return LimitModel(self._model(name, points[rows], targets[rows]), level)

    def _model(self, name: str, points: Array, targets: Array) -> Surrogate:
        """Return the surrogate of a quantity; its shape is looked for again as points become more."""
        size, shape = self._shapes.get(name, (0, None))
        if shape is None or len(points) >= GROWTH * size:
            shape = fitted_shape(points, targets, shape)
            self._shapes[name] = (len(points), shape)
        return Surrogate(points, targets, shape)


def warm_up() -> None:
    """Have what a model is made of compiled, by a search of a few points."""
    search = GaussianProcess(np.linspace(0.0, 1.0, 4)[:, None], 1, 1, 1)
    for _ in range(3):
        points = search.ask()
        search.tell(points, points - 0.5)


def picked(gain: Improvement | Hope, chances: "Chances", batch: int) -> Array:
    """Return rows of the pool (n,): the best one after the other, none that breaks what is known.

    What a row adds shrinks with every row chosen, so only rows that were worth more before are looked at again.
    """
    worth = gain.of(np.arange(len(chances.of)))
    fresh, rows = np.ones(len(worth), dtype=bool), list[int]()
    while len(rows) < batch:
        open_rows = np.flatnonzero(chances.possible)
        order = open_rows[np.lexsort((-chances.of[open_rows], -worth[open_rows] * chances.of[open_rows]))]
        stale = order[:TOGETHER][~fresh[order[:TOGETHER]]]
        if not fresh[order[0]]:
            worth[stale], fresh[stale] = gain.of(stale), True
        elif not chances.asked[order[0]]:
            chances.ask(order, batch - len(rows))
        else:
            rows.append(int(order[0]))
            chances.possible[rows[-1]] = False
            gain.choose(rows[-1])
            fresh[:] = False
            rows = rows if len(rows) < batch else chances.confirm(rows)
    return np.array(rows)


def chance_of(limits: list[LimitModel], pool: Array) -> Array:
    """Return the probability (p,) that points of a pool (p, d) keep all limits."""
    chance = np.ones(len(pool))
    for kept in side_by_side(lambda limit: limit.model.at(pool).chance_below(limit.level), limits):
        chance *= kept
    return chance


class Chances:
    """What is known and believed of the limits at the points of a pool (p, d).

    of (p,): probability that a point keeps them; possible (p,): whether it may be picked; asked (p,): whether the first analysis
    of what is known was asked. kept (p,): probability of keeping constraints.
    """

    def __init__(self, pool: Array, kept: Array, screens: "Sequence[KnownLimits]") -> None:
        self._pool, self._kept, self._screens = pool, kept, screens
        self.possible = np.ones(len(pool), dtype=bool)
        self.asked = np.full(len(pool), not screens)
        self.of = kept * self._guessed(self.asked)

    def ask(self, order: Array, needed: int) -> None:
        """Ask what is known of the first rows (k,) in an order and learn from it; needed: number of rows still to be picked."""
        rows = order[~self.asked[order]][: max(ASKED * needed, LEAST_ASKED)]
        self.asked[rows] = True
        keeps = self._screens[0].keeps(self._pool[rows])
        if keeps.sum() + len(order) - len(rows) < needed:
            # Where nothing in the pool keeps what is known, what breaks it has to do.
            return
        self.possible[rows] = keeps
        self.of = self._kept * self._guessed(self.asked)

    def confirm(self, rows: list[int]) -> list[int]:
        """Return those of the rows picked that keep the longer analyses too, or all where the pool has no others."""
        for screen in self._screens[1:]:
            keeps = screen.keeps(self._pool[rows])
            if np.count_nonzero(self.possible) < np.count_nonzero(~keeps):
                return rows
            if not keeps.all():
                rows = [row for row, kept in zip(rows, keeps, strict=True) if kept]
                self.of = self._kept * self._guessed(self.asked)
        return rows

    def _guessed(self, asked: Array) -> Array:
        """Return the probability (p,) of keeping what is known; of the first analysis 1 where it was asked."""
        chance = np.ones(len(self._pool))
        for level, screen in enumerate(self._screens):
            rows = np.full(len(chance), True) if level else ~asked
            chance[rows] *= chance_of(screen.models, self._pool[rows])
        return chance


class Aims:
    """Models of the objectives beside the front that they are to improve.

    points (n, d), values (n, m); believed (n,): mask of those whose values count; front (k,): rows; model: of a name, points and
    targets.
    """

    def __init__(
        self,
        points: Array,
        values: Array,
        believed: Array,
        front: Array,
        model: Callable[[str, Array, Array], Surrogate],
        draw: np.random.Generator,
    ) -> None:
        targets = evened(values, believed)
        rows = np.flatnonzero(believed)
        rows = np.sort(rows[np.argsort(targets[rows].mean(axis=1), kind="stable")[:MOST_TOLD]])
        self._models = side_by_side(
            lambda j: model(f"objective {j}", points[rows], targets[rows, j]), range(targets.shape[1])
        )
        values = np.expm1(targets)
        self._box = Box(values[front], None if np.any(values[0] > 0.99 * WORST) else values[0])
        self._front = self._box.ahead(values[front])
        count = OF_TWO if len(self._models) <= 2 else OF_MORE
        self._along = directions(count, len(self._models), draw)
        self._draw = draw

    def improvement(self, pool: Array, jointly: bool) -> Improvement:
        """Return what points of the pool (p, d) add to the front; jointly: to each other too."""
        samples = np.empty((SAMPLES, len(pool), len(self._models)))
        normals = [self._draw.standard_normal((SAMPLES, len(pool) if jointly else 1)) for _ in self._models]

        def sample(j: int) -> None:
            expected = self._models[j].at(pool)
            drawn = expected.samples(normals[j]) if jointly else expected.mean + expected.deviation * normals[j]
            samples[:, :, j] = np.expm1(np.minimum(drawn, np.log1p(WORST)))

        side_by_side(sample, range(len(self._models)))
        return Improvement(self._box.ahead(samples), self._front, self._along)


class KnownLimits:
    """Limits known without flying, asked once for each point. points (n, d), excess (n, h): of those asked for so far.

    ask: function of points that returns their excess. model: function of points and excess that returns a model of each limit
    that a point was seen to break.
    """

    def __init__(self, ask: Callable[[Array], Array], model: Callable[[Array, Array], list[LimitModel]]) -> None:
        self._ask, self._model = ask, model
        self._rows: dict[bytes, int] = {}
        self._models: tuple[int, list[LimitModel]] = (0, [])

    @property
    def models(self) -> list[LimitModel]:
        """Models of the limits, from all points asked for so far."""
        if self._models[0] < len(self._rows):
            self._models = (len(self._rows), self._model(self.points, self.excess))
        return self._models[1]

    def keeps(self, points: Array) -> Array:
        """Return which points (n, d) keep what is known (n,)."""
        new = {point.tobytes(): point for point in points if point.tobytes() not in self._rows}
        if new:
            asked = np.array(list(new.values()))
            # Margins come from LAPACK: the last digits are left out of what decides where the search goes.
            excess = np.round(self._ask(asked), 9)
            self.points = np.concatenate([self.points, asked]) if self._rows else asked
            self.excess = np.concatenate([self.excess, excess]) if self._rows else excess
            self._rows |= {key: len(self._rows) + i for i, key in enumerate(new)}
        if not len(points):
            return np.ones(0, dtype=bool)
        return np.all(self.excess[[self._rows[point.tobytes()] for point in points]] <= 0.0, axis=1)


def evened(values: Array, believed: Array) -> Array:
    """Return logarithms (n, m) of values: 0 at the smallest of those believed (n,), 0.7 one `spread` above it."""
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
