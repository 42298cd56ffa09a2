"""BoTorch: qLogNEHVI with several objectives, qLogEI with one, over a pool of points that keep what is known without flying.

S. Ament et al., "Unexpected improvements to expected improvement for Bayesian optimization", NeurIPS 2023; version 0.18. Models
are its `SingleTaskGP` as it comes, told that values have no noise, of the logarithm of each objective and of each limit that was
ever broken. The pool is made as the tool's is, a part over the cube and the rest around the front, so that what is compared is
the models and the choice.
"""

import warnings

import numpy as np
import torch
from botorch.acquisition.logei import qLogExpectedImprovement
from botorch.acquisition.multi_objective.logei import qLogNoisyExpectedHypervolumeImprovement
from botorch.acquisition.multi_objective.objective import GenericMCMultiOutputObjective
from botorch.acquisition.objective import GenericMCObjective
from botorch.fit import fit_gpytorch_mll
from botorch.models import ModelListGP, SingleTaskGP
from botorch.models.transforms.outcome import Standardize
from botorch.optim import optimize_acqf_discrete
from botorch.sampling import SobolQMCNormalSampler
from botorch.utils.multi_objective.pareto import is_non_dominated
from gpytorch.mlls import ExactMarginalLogLikelihood
from scipy.stats.qmc import Sobol

from benchmarks.search.peer import Array, Start

# Points of a pool that are screened, and that are enough; how many of them fill the cube.
POOL, ENOUGH, GLOBAL = 512, 192, 128
# Samples of the models by the number of objectives: the front of each sample is cut into boxes for every point chosen, which with
# three objectives and 64 samples takes 1.7 s a candidate.
SAMPLES = {1: 64, 2: 64, 3: 16}
# The reference point of the hypervolume in values of the default, and the largest value that tells anything.
REFERENCE, WORST = 1.1, 10.0
# A limit whose slack nobody told counts as kept below this share of it.
KEPT = 0.1


def begun(start: Start) -> "Batches":
    """Return the search at its beginning."""
    return Batches(start)


class Batches:
    """Batches that maximise the acquisition one point after the other, over a new pool each time."""

    def __init__(self, start: Start) -> None:
        torch.set_num_threads(1)
        torch.manual_seed(start.seed)
        warnings.simplefilter("ignore")
        self._start, self._draw = start, np.random.default_rng(start.seed)
        self._sobol = Sobol(start.first.shape[1], scramble=True, rng=np.random.default_rng(start.seed))
        self._points = np.empty((0, start.first.shape[1]))
        self._values, self._violations = np.empty((0, start.objectives)), np.empty((0, start.limits))
        self._asked = start.first

    def ask(self) -> Array:
        """Return the next batch (n, d)."""
        if len(self._points):
            self._asked = self._chosen()
        return self._asked

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and violations (n, c) of the batch asked for; what did not fly tells the models nothing."""
        flown = np.all(self._start.excess(self._asked) <= 0.0, axis=1)
        flown[0] |= not len(self._points)
        self._points = np.concatenate([self._points, self._asked[flown]])
        self._values = np.concatenate([self._values, values[flown]])
        self._violations = np.concatenate([self._violations, violations[flown]])

    def _chosen(self) -> Array:
        """Return the batch that promises most."""
        scaled = np.clip(self._values / self._values[0], 1e-9, WORST)
        feasible = np.all(self._violations <= 0.0, axis=1)
        pool = self._pool(scaled, feasible)
        columns = [*-np.log(scaled).T, *np.clip(self._violations, 0.0, 1.0).T[self._broken()]]
        inputs = torch.tensor(self._points)
        model = ModelListGP(*[fitted(inputs, torch.tensor(column)[:, None]) for column in columns])
        limits = [kept(k) for k in range(self._start.objectives, len(columns))] or None
        gain = self._gain(model, scaled[feasible], inputs, limits)
        chosen, _ = optimize_acqf_discrete(gain, self._start.batch, torch.tensor(pool), max_batch_size=64)
        return chosen.numpy()

    def _broken(self) -> Array:
        """Return which limits were ever broken by a point that was flown, the default aside: what is known needs no model."""
        return np.flatnonzero(self._violations[1:].max(axis=0, initial=0.0) > 0.0)

    def _gain(self, model: ModelListGP, best: Array, inputs: torch.Tensor, limits: list | None) -> torch.nn.Module:
        """Return the acquisition function; best (k, m): values of the feasible points in values of the default."""
        m = self._start.objectives
        sampler = SobolQMCNormalSampler(torch.Size([SAMPLES[m]]), seed=self._start.seed)
        if m == 1:
            return qLogExpectedImprovement(
                model,
                best_f=-float(best.min(initial=WORST)),
                sampler=sampler,
                objective=GenericMCObjective(lambda samples, X=None: -torch.exp(-samples[..., 0])),
                constraints=limits,
            )
        return qLogNoisyExpectedHypervolumeImprovement(
            model,
            [-REFERENCE] * m,
            inputs,
            sampler=sampler,
            objective=GenericMCMultiOutputObjective(lambda samples, X=None: -torch.exp(-samples[..., :m])),
            constraints=limits,
            prune_baseline=True,
        )

    def _pool(self, scaled: Array, feasible: Array) -> Array:
        """Return points that keep what is known, or all where none does."""
        parents = self._points[feasible]
        if len(parents):
            parents = parents[is_non_dominated(torch.tensor(-scaled[feasible])).numpy()]
        else:
            parents = self._points
        pool = np.concatenate([self._sobol.random(GLOBAL), self._children(parents, POOL - GLOBAL)])
        self._draw.shuffle(pool)
        found: list[Array] = []
        for part in np.split(pool, 8):
            if sum(map(len, found)) < ENOUGH:
                found.append(part[np.all(self._start.excess(part) <= 0.0, axis=1)])
        some = np.concatenate(found)
        return some if len(some) >= self._start.batch else pool

    def _children(self, parents: Array, count: int) -> Array:
        """Return points (count, d) around and between parents (k, d)."""
        base, other = (parents[self._draw.integers(len(parents), size=count)] for _ in range(2))
        blend = np.where(self._draw.uniform(size=(count, 1)) < 0.5, self._draw.uniform(-0.5, 1.5, (count, 1)), 0.0)
        width = np.exp(self._draw.uniform(np.log(0.003), np.log(0.3), size=(count, 1)))
        return np.clip(base + blend * (other - base) + width * self._draw.standard_normal(base.shape), 0.0, 1.0)


def fitted(inputs: torch.Tensor, targets: torch.Tensor) -> SingleTaskGP:
    """Return the model of targets (n, 1) at inputs (n, d)."""
    model = SingleTaskGP(inputs, targets, torch.full_like(targets, 1e-6), outcome_transform=Standardize(1))
    fit_gpytorch_mll(ExactMarginalLogLikelihood(model.likelihood, model))
    return model


def kept(column: int):  # noqa: ANN201
    """Return a constraint on samples of the models, kept below 0."""
    return lambda samples: samples[..., column] - KEPT
