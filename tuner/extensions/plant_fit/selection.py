"""The structure of a plant, chosen by errors on held-out blocks.

The parts are blocks all over the record, so that a single step is in most of them. All rivals are judged under one noise model:
one of its own would explain what a poor plant leaves over.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from tuner.extensions.plant_fit.estimate import (
    REDUCED,
    Problem,
    Projection,
    Search,
    Solution,
    share,
    starts_of,
    usual_dead_times,
)
from tuner.extensions.plant_fit.noise import fit_noise, outliers_in, quantum_of
from tuner.extensions.plant_fit.restricted import RestrictedLikelihood
from tuner.extensions.plant_fit.slopes import slopes_of
from tuner.extensions.plant_fit.structures import FIRST, SECOND, STRUCTURES, Structure, extended

Array = np.ndarray
N_FOLDS, N_BLOCKS, FOLD_EVALUATIONS = 4, 20, 3
ROUNDS = 3
"""Fits of plant and noise in turn before they are fitted together."""
SAMPLES_EACH = 8
"""Fewest samples for each parameter."""
HOPELESS_RATIO = 4.0
"""Sum of squared residuals over the best's from which a structure is not refined."""
FAST_POLE = 0.2
"""Time constant of a pole that is added to a simpler fit, in samples."""
REFIT_EVALUATIONS = 10
"""Steps of a refinement."""
MAX_LOSS = 0.05
"""Fit that plant and noise together may lose against the plant under the rivals' noise model."""
MIN_ADVANTAGE = 2.0
"""Standard errors by which a richer structure has to be better."""
MIN_GAIN = 0.02
"""Share of the mean square by which it has to be better."""
MAX_HELD_OUT_LOSS = 0.1
"""Fit to held-out blocks by which a simpler structure may be below the best."""
START_P = 12.0
"""Gain in the logarithm of the likelihood from which an initial state is estimated; 1 in 100,000 records at rest reaches it."""


@dataclass(frozen=True)
class Rival:
    """A structure among its rivals.

    Attributes:
        solution: Fit to all of the record.
        held_out: Fit to held-out blocks [1]: 1 - |y - model| / |y - mean|.
        score: Mean square of the prediction errors on held-out blocks over that of the best that simulates them.
        error: Standard error of the difference to the best's score.
    """

    solution: Solution
    held_out: float
    score: float
    error: float

    @property
    def structure(self) -> Structure:
        """Its structure."""
        return self.solution.structure


@dataclass(frozen=True)
class Chosen:
    """The chosen structure, fitted together with the noise, and its rivals."""

    problem: Problem
    solution: Solution
    rivals: tuple[Rival, ...]

    @property
    def projection(self) -> Projection:
        """Projection of the chosen structure."""
        return Projection(self.problem, self.solution.structure)


def choose(problem: Problem, structures: list[Structure]) -> Chosen:
    """Return the simplest structure that predicts held-out blocks well."""
    structures = [each for each in structures if each.n_free * SAMPLES_EACH <= problem.n_samples] or structures[:1]
    first = list(_first_fits(problem, structures).values())
    best = min(first, key=lambda each: each.cost)
    quantum = quantum_of(np.concatenate(problem.outputs))
    outliers = tuple(outliers_in(each, quantum) for each in best.residuals)
    problem = replace(problem, outliers=outliers)
    best = _refit(problem, best, fit_noise(list(best.residuals)))
    problem, best = _with_start(problem, best)
    noise = fit_noise(list(best.residuals))
    limit = HOPELESS_RATIO * min(each.cost for each in first)
    rivals = _judged(problem, [_refit(problem, each, noise, each.cost > limit) for each in first])
    start = _simplest(rivals).solution
    together = fit_together(problem, start)
    shares = [share(Projection(problem, start.structure), each) for each in (start, together)]
    # Where no linear plant fits, a noise model of its own would take over what the plant should explain.
    return Chosen(problem, start if shares[1] < shares[0] - MAX_LOSS else together, tuple(rivals))


def fit_together(problem: Problem, start: Solution) -> Solution:
    """Return the minimum in plant and noise together."""
    projection = Projection(problem, start.structure)
    search, solution = Search(projection), start
    for _ in range(ROUNDS):
        noise = fit_noise(list(solution.residuals))
        solution = search.polish(projection.solve(solution.shape, solution.dead_times, noise))
    for _ in range(ROUNDS):
        # The noise model comes with a linear step of the plant, without which both would approach each other slowly.
        likelihood = RestrictedLikelihood.of(slopes_of(projection, solution), solution.residuals, len(solution.noise))
        noise = likelihood.best(solution.noise)
        solution = search.polish(projection.solve(solution.shape, solution.dead_times, noise))
    return solution


def _first_fits(problem: Problem, structures: list[Structure]) -> dict[str, Solution]:
    """Return fits without a noise model by the name of the structure."""
    coarse = problem.thinned(ceil(max(len(each) for each in problem.outputs) / REDUCED))
    fits: dict[str, Solution] = {}
    for structure in _with_simpler(structures):
        coarse_fit = _searched(coarse, structure, _earlier(structure, fits))
        projection = Projection(problem, structure)
        start = projection.solve(coarse_fit.shape, coarse_fit.dead_times, coarse_fit.noise)
        fit = Search(projection).polish(start, evaluations=REFIT_EVALUATIONS)
        fits[structure.name] = min((fit, *_better(projection, fit, fits)), key=lambda each: each.cost)
    return {each.name: fits[each.name] for each in structures}


def _with_simpler(structures: list[Structure]) -> list[Structure]:
    """Return structures behind the simpler ones from which their searches start.

    Searches of one or two shape parameters need none.
    """
    richest = max(each.n_shape for each in structures)
    return [
        each
        for each in STRUCTURES.values()
        if each in structures or (each.pairs and SECOND.n_shape < richest >= each.n_shape)
    ]


def _better(projection: Projection, fit: Solution, fits: dict[str, Solution]) -> Iterator[Solution]:
    """Yield a fit from the best simpler one, if any is better.

    A thinned record may hide a fast pole, and a search from there ends in another minimum.
    """
    fast = FAST_POLE * projection.problem.period
    simpler = [
        (each, shapes)
        for each in fits.values()
        if each.cost < fit.cost and (shapes := extended(each.shape, each.structure, fit.structure, fast)) is not None
    ]
    if simpler:
        best, shapes = min(simpler, key=lambda pair: pair[0].cost)
        # A fast pole delays by its time constant.
        further = fast * (fit.structure.order - best.structure.order)
        start = projection.solve(shapes, np.maximum(best.dead_times - further, 0.0), best.noise)
        yield Search(projection).polish(start, evaluations=REFIT_EVALUATIONS)


def _earlier(structure: Structure, fits: dict[str, Solution]) -> Solution | None:
    """Return the fit of the richest simpler structure."""
    simpler = [each for each in fits.values() if each.structure.n_shape <= structure.n_shape and each.structure.pairs]
    return simpler[-1] if simpler else fits.get(FIRST.name)


def _searched(problem: Problem, structure: Structure, earlier: Solution | None) -> Solution:
    search = Search(Projection(problem, structure))
    late = usual_dead_times(problem)
    if earlier is not None and structure.n_shape > 1:
        late = float(np.median(earlier.dead_times)) * np.array([0.0, 0.5, 1.0])
    shapes = starts_of(structure, problem, earlier)
    if earlier is not None and earlier.shape.shape[1] == structure.n_shape:
        shapes.append(np.median(earlier.shape, axis=0))
    return search.from_grid(np.zeros(0), shapes, late)


def _refit(problem: Problem, start: Solution, noise: Array, is_hopeless: bool = False) -> Solution:
    """Return a fit under a noise model; is_hopeless: with the shape that it has."""
    projection = Projection(problem, start.structure)
    solution = projection.solve(start.shape, start.dead_times, noise)
    return solution if is_hopeless else Search(projection).polish(solution, evaluations=REFIT_EVALUATIONS)


def _with_start(problem: Problem, best: Solution) -> tuple[Problem, Solution]:
    """Return problem and fit, with initial states if the records need them."""
    free = replace(problem, has_start=(True,) * len(problem.outputs))
    moved = _refit(free, best, best.noise)
    # A noise model of the records at rest would take the motion of their beginning for noise.
    noise = fit_noise(list(moved.residuals))
    moved, rested = _refit(free, moved, noise), _refit(problem, best, noise)
    n = len(rested.errors)
    gain = 0.5 * n * float(np.log(rested.cost / max(moved.cost, 1e-300)))
    needed = START_P + 0.5 * np.log(n) * best.structure.order * len(problem.outputs)
    return (free, moved) if gain > needed else (problem, best)


def _judged(problem: Problem, solutions: list[Solution]) -> list[Rival]:
    """Return rivals with their errors on held-out blocks."""
    folds = _folds(problem)
    noise = solutions[0].noise
    squares, measured = [], []
    limit = HOPELESS_RATIO * min(each.cost for each in solutions)
    for solution in solutions:
        steps = 0 if solution.cost > limit else FOLD_EVALUATIONS
        errors, residuals = zip(*(_held_out(problem, solution, fold, noise, steps) for fold in folds), strict=True)
        squares.append(np.concatenate(errors))
        measured.append(float(np.sqrt(sum(each @ each for each in residuals))))
    spread = np.sqrt(sum(float(np.sum((each - each.mean()) ** 2)) for each in problem.outputs))
    shares = [1.0 - each / spread for each in measured]
    means = np.array([each.mean() for each in squares])
    best = min(_simulating(shares), key=lambda i: means[i])
    rivals = []
    for i, solution in enumerate(solutions):
        difference = squares[i] - squares[best]
        error = float(difference.std(ddof=1) / np.sqrt(len(difference))) if len(difference) > 1 else 0.0
        rivals.append(Rival(solution, shares[i], float(means[i] / means[best]), error / float(means[best])))
    return rivals


def _simulating(held_out: list[float]) -> list[int]:
    """Return the places of rivals that simulate held-out blocks.

    These do so better than the mean of the blocks; if none does, all are returned. The others predict by measured outputs,
    through the noise model, and no simulation has these.
    """
    return [i for i, each in enumerate(held_out) if each > 0.0] or list(range(len(held_out)))


def _folds(problem: Problem) -> list[list[Array]]:
    """Return a mask of held-out samples (samples,) by fold and experiment."""
    folds = []
    for fold in range(N_FOLDS):
        held = []
        for output in problem.outputs:
            block = (np.arange(len(output)) * N_BLOCKS) // len(output)
            # The first block shows offset and initial state, without which no other can be predicted.
            held.append((block % N_FOLDS == fold) & (block > 0))
        folds.append(held)
    return folds


def _held_out(problem: Problem, start: Solution, held: list[Array], noise: Array, steps: int) -> tuple[Array, Array]:
    """Return mean squared errors of held-out blocks (blocks,), and the residuals there."""
    counted = replace(problem, rows=tuple(~each for each in held))
    projection = Projection(counted, start.structure)
    solution = projection.solve(start.shape, start.dead_times, noise)
    if steps:
        solution = Search(projection).polish(solution, evaluations=steps)
    place, means, residuals = 0, [], []
    for output, rows, residual in zip(problem.outputs, held, solution.residuals, strict=True):
        n = len(output) - len(noise)
        errors = solution.errors[place : place + n]
        place += n
        block = (np.arange(len(output)) * N_BLOCKS) // len(output)
        inside = rows[len(noise) :]
        for each in np.unique(block[rows]):
            chosen = inside & (block[len(noise) :] == each)
            if np.any(chosen):
                means.append(float(np.mean(errors[chosen] ** 2)))
        residuals.append(residual[rows])
    return np.array(means), np.concatenate(residuals)


def _simplest(rivals: list[Rival]) -> Rival:
    """Return the simplest rival within standard errors of the best."""
    rivals = [rivals[i] for i in _simulating([each.held_out for each in rivals])]
    best = min(rivals, key=lambda each: each.score)
    able = [
        each
        for each in rivals
        if each.score - 1.0 <= max(MIN_ADVANTAGE * each.error, MIN_GAIN)
        # Errors that are all in a few blocks have a large standard error.
        and each.held_out >= best.held_out - MAX_HELD_OUT_LOSS
    ]
    return min(able, key=lambda each: (each.structure.n_free, each.score))
