"""Constrained multi-objective Bayesian optimization: for costly flights, some hundreds of candidates and up to some forty gains.

A Gaussian process models each objective, each constraint that was ever violated and each limit that is computed without flying.
A batch is chosen greedily from a pool of points: each maximizes the expected hypervolume improvement over the front and the
points chosen before it, times the probability of feasibility (see `acquisition`; with one objective, the expected improvement).
While the front is small, the first point of a generation improves one objective alone, in turn: what is not seen is not searched.
"""

from collections.abc import Callable, Sequence
from functools import partial
from math import prod
from typing import NamedTuple

import numpy as np

from plant.seeds import generator
from plant.threads import parallel_map
from tuner.search.acquisition import FeasibilityAcquisition, HypervolumeImprovement
from tuner.search.constraint_ranking import power_of_two
from tuner.search.front import feasible_front
from tuner.search.gaussian_process import GaussianProcess, Hyperparameters, fit_hyperparameters
from tuner.search.objective_models import MAX_SPREADS, ObjectiveModels, OutputScale, fit_output_scale, scale_values
from tuner.search.sobol import Sobol

Array = np.ndarray
Acquisition = HypervolumeImprovement | FeasibilityAcquisition
# Points of the pool, and how many of them fill the cube; the others lie around the best points so far.
N_CANDIDATES, N_GLOBAL = 512, 128
# Points drawn for each of those that fill the cube, while few points are known and limits are computed without flying: where 2 of
# 100 keep them, 128 points hold next to nothing to explore. Least weight of one.
EARLY_DRAWS, MIN_WEIGHT = 16, 1e-12
# Least number of points of the pool for each point of a generation.
CANDIDATES_PER_PICK = 2
# Of these, those that stay for the choice, and of them those whose perturbations replace the others.
N_SHORTLIST, N_PARENTS = 192, 32
# Batch while few points are known, and number of points up to which: the models learn most from the first points, and a batch
# is chosen without its own values (over 27 published problems the mean share of the front after 50 points is 0.62, else 0.57).
EARLY_BATCH, N_EARLY = 4, 60
# Growth of the number of points after which hyperparameters are fitted again.
REFIT_GROWTH = 1.3
# Improvement of an objective by itself below which its end of the front is left alone, in units of the reference box.
MIN_END_IMPROVEMENT = 1e-6
# Coordinates of a point that are perturbed, in the mean: a share, in many dimensions so many, and at least so many in few (random
# subspaces: R. G. Regis, C. A. Shoemaker, Engineering Optimization 45(5):529-555, 2013).
MAX_SHARE, N_PERTURBED, MIN_PERTURBED = 0.5, 10.0, 3.0
# Least number of parents of the pool; and points that are re-evaluated at once.
N_INCUMBENTS, REEVALUATION_BATCH = 8, 8
# Points checked without flying: for each that is still to be picked, and at least. One by one takes far longer.
CHECKS_PER_PICK, MIN_CHECKS = 2, 16


class ModelBudget(NamedTuple):
    """Work that a constraint's model may make.

    Attributes:
        most: Largest number of points that it is conditioned on: the closest to its threshold.
        growth: Growth of the number of points after which its hyperparameters are fitted again.
    """

    most: int = 250
    growth: float = REFIT_GROWTH


# Limits that are computed have several times the points of those that are flown, and models that are made anew with each check.
FLOWN_BUDGET, COMPUTED_BUDGET = ModelBudget(), ModelBudget(most=150, growth=1.5)


class ConstraintModel(NamedTuple):
    """The model of a constraint that is satisfied up to a threshold."""

    model: GaussianProcess
    threshold: float


class BayesianOptimization:
    """Search by greedy batches of the expected hypervolume improvement under constraints.

    Args:
        first: points (n, d) of the first generation; its size is the batch.
        n_objectives: number of objectives m.
        n_constraints: number of constraints c.
        seed: root seed of all later draws.
        excesses: analyses without flights, the longest last: points (n, d) -> excess over limits (n, h), 0 or less where they
            hold. Points that exceed one are never proposed, nor do their objectives count.
        reference: objectives (m,) up to which the front is searched; None or NaN where front and default decide.
    """

    def __init__(
        self,
        first: Array,
        n_objectives: int,
        n_constraints: int,
        seed: int,
        excesses: Sequence[Callable[[Array], Array]] = (),
        reference: Array | None = None,
    ) -> None:
        self._seed = seed
        self._reference = np.full(n_objectives, np.nan) if reference is None else reference
        self._points, self._values = np.empty((0, first.shape[1])), np.empty((0, n_objectives))
        self._violations = np.empty((0, n_constraints))
        self._screens = [
            DeterministicConstraints(
                excess, partial(self._constraint_models, f"{'further ' * level}known", COMPUTED_BUDGET)
            )
            for level, excess in enumerate(excesses)
        ]
        self._fits: dict[str, tuple[int, Hyperparameters]] = {}
        self._scales: dict[int, tuple[int, OutputScale]] = {}
        self._sobol = Sobol(first.shape[1], generator(seed, "search/gaussian_process/pool", 0))
        self._population, self._n_batches = len(first), 0
        self._n_candidates = max(N_CANDIDATES, CANDIDATES_PER_PICK * len(first))
        self._pending: Array | None = first.copy()

    def ask(self) -> Array:
        """Return the next batch (n, d), points of the unit cube: a generation, or part of an early one."""
        if self._pending is None:
            self._pending = self._select(generator(self._seed, "search/gaussian_process", self._n_batches))
        return self._pending.copy()

    def tell(self, values: Array, violations: Array) -> None:
        """Record the objectives and constraint violations of the pending batch.

        values (n, m); violations (n, c): below 0 where there is slack.
        """
        self._points = np.concatenate([self._points, self.ask()])
        self._values = np.concatenate([self._values, values])
        self._violations = np.concatenate([self._violations, violations])
        self._n_batches += 1
        self._pending = None

    def retell(self, values: Array, violations: Array) -> None:
        """Replace the objectives (n, m) and constraint violations (n, c) of all points so far."""
        self._values, self._violations = values.copy(), violations.copy()

    def forget_fits(self) -> None:
        """Fit all models from the beginning, not from where earlier fits ended."""
        self._fits, self._scales = {}, {}

    def _select(self, rng: np.random.Generator) -> Array:
        """Return the next generation (n, d)."""
        is_valid = np.ones(len(self._points), dtype=bool)
        for screen in self._screens:
            is_valid[is_valid] = screen.is_feasible(self._points[is_valid])
        computed = [constraint for screen in self._screens for constraint in screen.models]
        flown = self._flown_constraints(is_valid)
        objectives = self._objective_models(is_valid, rng)
        pool = self._pool(computed, rng)
        probability = probability_of_feasibility(computed, pool) * probability_of_feasibility(flown, pool)
        if objectives:
            values = objectives.marginal_improvement(pool, probability).evaluate(np.arange(len(pool)))
        else:
            values = self._feasibility(pool, [*computed, *flown], rng).evaluate(np.arange(len(pool)))
        order = np.argsort(-values * probability, kind="stable")
        offspring = perturb(pool[order[:N_PARENTS]], self._n_candidates - N_SHORTLIST, rng)
        pool = self._enough(self._new(np.concatenate([pool[order[:N_SHORTLIST]], offspring])))
        feasibility = FeasibilityProbabilities(pool, probability_of_feasibility(flown, pool), self._screens)
        if objectives:
            return pool[self._select_improving(objectives.joint_improvement(pool), feasibility)]
        return pool[select_batch(self._feasibility(pool, [*computed, *flown], rng), feasibility, self._batch)]

    @property
    def _batch(self) -> int:
        """Size of the next batch: what remains of the generation, in small parts while few points are known."""
        rest = self._population - len(self._points) % self._population
        return min(EARLY_BATCH, rest) if len(self._points) < N_EARLY else rest

    def _select_improving(self, improvement: HypervolumeImprovement, feasibility: "FeasibilityProbabilities") -> Array:
        """Return rows (n,) of the pool: the first improves an end of the front, the others the hypervolume."""
        n_objectives, batch = self._values.shape[1], self._batch
        rows = np.empty(0, dtype=int)
        begins = len(self._points) % self._population == 0
        if begins and batch > 1 and n_objectives > 1:
            index = len(self._points) // self._population % n_objectives
            rows = select_batch(improvement.of_objective(index), feasibility, 1, batch - 1)
            # Whoever was chosen is pending there, and improves nothing any more.
            end = improvement.of_objective(index)
            if end.evaluate(rows)[0] * feasibility.probability[rows[0]] > MIN_END_IMPROVEMENT:
                improvement.add_pending(int(rows[0]))
            else:
                feasibility.is_selectable[rows], rows = True, rows[:0]
        return np.concatenate([rows, select_batch(improvement, feasibility, batch - len(rows))])

    def _objective_models(self, is_valid: Array, rng: np.random.Generator) -> ObjectiveModels | None:
        """Return models of the objectives; None without a feasible point."""
        values, reference = scale_values(self._values, is_valid, self._reference[None])
        front = feasible_front(self._values, self._violations)
        # A value beyond all bounds is no end of a front, however good the other objectives are there.
        front = front[is_valid[front] & np.all(values[front] < MAX_SPREADS, axis=1)]
        if not len(front):
            return None
        return ObjectiveModels(self._points, values, is_valid, front, self._fit_objective, rng, reference[0])

    def _fit_objective(self, index: int, points: Array, values: Array) -> OutputScale:
        """Return the output scale of an objective; it is fitted again as data grow."""
        size, fit = self._scales.get(index, (0, None))
        if fit is None or len(points) >= REFIT_GROWTH * size:
            fit = fit_output_scale(points, values, fit)
            self._scales[index] = (len(points), fit)
        return fit

    def _feasibility(
        self, pool: Array, models: "list[ConstraintModel]", rng: np.random.Generator
    ) -> FeasibilityAcquisition:
        posteriors = parallel_map(lambda constraint: constraint.model.posterior(pool), models)
        return FeasibilityAcquisition(posteriors, len(pool), rng)

    def _pool(self, computed: list[ConstraintModel], rng: np.random.Generator) -> Array:
        """Return points (p, d) over the cube and around the incumbents: the front and the least violating points."""
        front = feasible_front(self._values, self._violations)
        (values,) = scale_values(self._values, np.ones(len(self._values), dtype=bool))
        depth = np.log1p(values).mean(axis=1)
        total = (np.maximum(self._violations, 0.0) / violation_scales(self._violations)).sum(axis=1)
        best = np.union1d(front, np.lexsort((depth, total))[:N_INCUMBENTS])
        filling = self._global_points(computed, rng)
        around = perturb(self._points[best], self._n_candidates - N_GLOBAL, rng)
        return self._new(np.concatenate([filling, around]))

    def _global_points(self, computed: list[ConstraintModel], rng: np.random.Generator) -> Array:
        """Return points (p, d) that fill the cube.

        While few points are known they fill the part of it where what is computed is probably satisfied. Sampling without
        replacement: P. S. Efraimidis, P. G. Spirakis, Information Processing Letters 97(5):181-185, 2006.
        """
        if not computed or len(self._points) >= N_EARLY:
            return self._sobol.random(N_GLOBAL)
        points = self._sobol.random(EARLY_DRAWS * N_GLOBAL)
        probability = np.maximum(probability_of_feasibility(computed, points), MIN_WEIGHT)
        return points[np.argsort(rng.exponential(size=len(points)) / probability, kind="stable")[:N_GLOBAL]]

    def _enough(self, pool: Array) -> Array:
        """Return a pool (p, d) of at least a generation."""
        while len(pool) < self._batch:
            pool = self._new(np.concatenate([pool, self._sobol.random(self._batch)]))
        return pool

    def _new(self, pool: Array) -> Array:
        """Return the points (p, d) that were never evaluated, each once."""
        evaluated = {point.tobytes() for point in self._points}
        return np.array(list({point.tobytes(): point for point in pool if point.tobytes() not in evaluated}.values()))

    def _flown_constraints(self, is_valid: Array) -> list[ConstraintModel]:
        """Return a model of each constraint that was ever violated: of the logarithms of violation and slack.

        D. Eriksson, M. Poloczek, "Scalable constrained Bayesian optimization", AISTATS 2021, section 3 (bilog transform).
        """
        points, scaled = self._points[is_valid], self._violations[is_valid] / violation_scales(self._violations)
        (values,) = scale_values(self._values[is_valid], np.ones(len(points), dtype=bool))
        # A value beyond all bounds counts as a limit broken: whoever seeks an end of the front would go there again and again.
        unbounded = np.any(values >= MAX_SPREADS, axis=1, keepdims=True).astype(float)
        return [
            *self._constraint_models("constraint", FLOWN_BUDGET, points, np.sign(scaled) * np.log1p(np.abs(scaled))),
            *self._constraint_models("unbounded", FLOWN_BUDGET, points, unbounded),
        ]

    def _constraint_models(self, kind: str, budget: ModelBudget, points: Array, excess: Array) -> list[ConstraintModel]:
        """Return a model of each column of excess (n, c) ever above 0."""
        columns = range(excess.shape[1])
        models = parallel_map(lambda i: self._constraint_model(f"{kind} {i}", budget, points, excess[:, i]), columns)
        return [model for model in models if model is not None]

    def _constraint_model(self, name: str, budget: ModelBudget, points: Array, excess: Array) -> ConstraintModel | None:
        """Return the model of an excess (n,), None where never above 0."""
        if not np.any(excess > 0.0):
            return None
        # Without values below 0, a tenth is the threshold.
        threshold = 0.0 if np.any(excess < 0.0) else 0.1
        rows = np.sort(np.argsort(np.abs(excess), kind="stable")[: budget.most])
        return ConstraintModel(self._model(name, budget.growth, points[rows], excess[rows]), threshold)

    def _model(self, name: str, growth: float, points: Array, targets: Array) -> GaussianProcess:
        """Return the model of a quantity; hyperparameters are fitted again as data grow."""
        size, hyperparameters = self._fits.get(name, (0, None))
        if hyperparameters is None or len(points) >= growth * size:
            hyperparameters = fit_hyperparameters(points, targets, hyperparameters)
            self._fits[name] = (len(points), hyperparameters)
        return GaussianProcess(points, targets, hyperparameters)


def warm_up() -> None:
    """Compile the linear algebra, by a search of a few points."""
    search = BayesianOptimization(np.linspace(0.0, 1.0, 4)[:, None], 1, 1, 1)
    for _ in range(3):
        points = search.ask()
        search.tell(points, points - 0.5)


def select_batch(
    acquisition: Acquisition, feasibility: "FeasibilityProbabilities", batch: int, reserve: int = 0
) -> Array:
    """Return rows (n,) of the pool: chosen greedily by acquisition times probability of feasibility.

    reserve: number of rows that stay selectable for a later batch.
    Acquisition values only decrease with pending points (submodularity), so only the best stale ones are evaluated again.
    """
    values = acquisition.evaluate(np.arange(len(feasibility.probability)))
    fresh, rows = np.ones(len(values), dtype=bool), list[int]()
    while len(rows) < batch:
        selectable = np.flatnonzero(feasibility.is_selectable)
        probability = feasibility.probability[selectable]
        order = selectable[np.lexsort((-probability, -values[selectable] * probability))]
        stale = order[:REEVALUATION_BATCH][~fresh[order[:REEVALUATION_BATCH]]]
        if not fresh[order[0]]:
            values[stale], fresh[stale] = acquisition.evaluate(stale), True
        elif not feasibility.is_checked[order[0]]:
            feasibility.check(order, batch - len(rows), reserve)
        else:
            rows.append(int(order[0]))
            feasibility.is_selectable[rows[-1]] = False
            acquisition.add_pending(rows[-1])
            fresh[:] = False
            rows = rows if len(rows) < batch else feasibility.confirm(rows)
    return np.array(rows, dtype=int)


def probability_of_feasibility(constraints: list[ConstraintModel], pool: Array) -> Array:
    """Return the probability (p,) of satisfying all constraints: taken as independent, at points (p, d)."""
    probabilities = parallel_map(lambda limit: limit.model.posterior(pool).cdf(limit.threshold), constraints)
    return prod(probabilities, start=np.ones(len(pool)))


class FeasibilityProbabilities:
    """Probabilities of feasibility over a pool of candidates: 0 or 1 once checked.

    probability (p,): of satisfying all constraints; is_selectable (p,): mask of the candidates to choose from; is_checked (p,):
    mask of those that the first analysis has checked.

    Args:
        pool: candidates (p, d).
        flown: their probability (p,) of satisfying the constraints that need flights.
        screens: constraints computed without flights.
    """

    def __init__(self, pool: Array, flown: Array, screens: "Sequence[DeterministicConstraints]") -> None:
        self._pool, self._flown, self._screens = pool, flown, screens
        self.is_selectable = np.ones(len(pool), dtype=bool)
        self.is_checked = np.full(len(pool), not screens)
        self._latest: list[tuple[list[ConstraintModel], Array, Array]] = [([], np.zeros(0), np.zeros(0))] * len(screens)
        self.probability = flown * self._computed()

    def check(self, order: Array, needed: int, reserve: int = 0) -> None:
        """Check the first rows (k,) of an order by the first analysis.

        needed: number still to be picked; reserve: number that must be left then.
        """
        rows = order[~self.is_checked[order]][: max(CHECKS_PER_PICK * needed, MIN_CHECKS)]
        self.is_checked[rows] = True
        is_feasible = self._screens[0].is_feasible(self._pool[rows])
        if is_feasible.sum() + len(order) - len(rows) < needed + reserve:
            # Too few candidates remain: infeasible ones stay selectable.
            return
        self.is_selectable[rows] = is_feasible
        self.probability = self._flown * self._computed()

    def confirm(self, rows: list[int]) -> list[int]:
        """Return the rows that satisfy the longer analyses.

        All rows stay where the pool has too few others.
        """
        needed = len(rows)
        for screen in self._screens[1:]:
            is_feasible = screen.is_feasible(self._pool[rows])
            if np.count_nonzero(self.is_selectable) < needed - np.count_nonzero(is_feasible):
                return rows
            if not is_feasible.all():
                rows = [row for row, feasible in zip(rows, is_feasible, strict=True) if feasible]
                self.probability = self._flown * self._computed()
        return rows

    def _computed(self) -> Array:
        """Return the probability (p,) of satisfying all analyses: of the first, 1 where checked."""
        product = np.ones(len(self._pool))
        for level, screen in enumerate(self._screens):
            rows = np.full(len(product), True) if level else ~self.is_checked
            product[rows] *= self._probability(level, screen.models, rows)
        return product

    def _probability(self, level: int, models: list[ConstraintModel], rows: Array) -> Array:
        """Return the probability of satisfying an analysis at some rows (p,); models change when its analysis is asked."""
        models_before, rows_before, probability = self._latest[level]
        if models is not models_before or not np.array_equal(rows, rows_before):
            probability = probability_of_feasibility(models, self._pool[rows])
            self._latest[level] = models, rows, probability
        return probability


class DeterministicConstraints:
    """Constraints computed without flying, once for each point. points (n, d), excess (n, h): of all points so far.

    evaluate: points -> excess, 0 or less where they hold. model: points and excess -> models of the constraints ever violated.
    """

    def __init__(
        self, evaluate: Callable[[Array], Array], model: Callable[[Array, Array], list[ConstraintModel]]
    ) -> None:
        self._evaluate, self._model = evaluate, model
        self._rows: dict[bytes, int] = {}
        self._models: tuple[int, list[ConstraintModel]] = (0, [])

    @property
    def models(self) -> list[ConstraintModel]:
        """Models of the constraints, from all points so far."""
        if self._models[0] < len(self._rows):
            # Values far from the threshold do not locate it.
            self._models = (len(self._rows), self._model(self.points, np.clip(self.excess, -1.0, 1.0)))
        return self._models[1]

    def is_feasible(self, points: Array) -> Array:
        """Return a mask (n,) of the points (n, d) that satisfy all."""
        new = {point.tobytes(): point for point in points if point.tobytes() not in self._rows}
        if new:
            added = np.array(list(new.values()))
            # Margins come from LAPACK: their last digits must not decide the course of the search.
            excess = np.round(self._evaluate(added), 9)
            self.points = np.concatenate([self.points, added]) if self._rows else added
            self.excess = np.concatenate([self.excess, excess]) if self._rows else excess
            self._rows |= {key: len(self._rows) + i for i, key in enumerate(new)}
        if not len(points):
            return np.ones(0, dtype=bool)
        return np.all(self.excess[[self._rows[point.tobytes()] for point in points]] <= 0.0, axis=1)


def violation_scales(violations: Array) -> Array:
    """Return the median violation (c,) of each constraint, see `constraint_ranking`."""
    positive = [column[column > 0.0] for column in violations.T]
    return np.array([power_of_two(float(np.median(column))) if len(column) else 1.0 for column in positive])


def perturb(parents: Array, count: int, rng: np.random.Generator) -> Array:
    """Return points (count, d) around and between parents (k, d)."""
    k, dimensions = parents.shape
    base, other = parents[rng.integers(k, size=count)], parents[rng.integers(k, size=count)]
    between = np.where(rng.uniform(size=(count, 1)) < 0.5, rng.uniform(-0.5, 1.5, size=(count, 1)), 0.0)
    width = np.exp(rng.uniform(np.log(0.003), np.log(0.3), size=(count, 1)))
    share = max(min(MAX_SHARE, N_PERTURBED / dimensions), MIN_PERTURBED / dimensions)
    is_perturbed = rng.uniform(size=(count, dimensions)) < share
    step = width * rng.standard_normal((count, dimensions)) * is_perturbed
    return np.clip(base + between * (other - base) + step, 0.0, 1.0)
