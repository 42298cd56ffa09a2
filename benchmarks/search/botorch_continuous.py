"""BoTorch as its tutorials have it: qLogNEHVI with several objectives, qLogEI with one, maximized over the cube by L-BFGS-B.

S. Ament et al., "Unexpected improvements to expected improvement for Bayesian optimization", NeurIPS 2023; version 0.18. Values
and constraints are standardized, the reference point is inferred from the front; `botorch_batches` chooses from a pool in place
of the cube.
"""

import warnings

import numpy as np
import torch
from botorch.acquisition.logei import qLogNoisyExpectedImprovement
from botorch.acquisition.multi_objective.logei import qLogNoisyExpectedHypervolumeImprovement
from botorch.acquisition.multi_objective.objective import GenericMCMultiOutputObjective
from botorch.acquisition.objective import GenericMCObjective
from botorch.fit import fit_gpytorch_mll
from botorch.models import ModelListGP, SingleTaskGP
from botorch.models.transforms.outcome import Standardize
from botorch.optim import optimize_acqf
from botorch.sampling import SobolQMCNormalSampler
from botorch.utils.multi_objective.hypervolume import infer_reference_point
from botorch.utils.multi_objective.pareto import is_non_dominated
from gpytorch.mlls import SumMarginalLogLikelihood

from benchmarks.search.peer import Array, Start

SAMPLES = {1: 64, 2: 64, 3: 16}
RESTARTS, RAW_SAMPLES = 4, 128


def begun(start: Start) -> "ContinuousBatches":
    """Return the search at its beginning."""
    return ContinuousBatches(start)


class ContinuousBatches:
    """Batches that maximize the acquisition one point after the other."""

    def __init__(self, start: Start) -> None:
        torch.set_num_threads(1)
        torch.manual_seed(start.seed)
        warnings.simplefilter("ignore")
        self._start, self._asked = start, start.first
        self._points = np.empty((0, start.first.shape[1]))
        self._outputs = np.empty((0, start.objectives + start.limits))

    def ask(self) -> Array:
        """Return the next batch (n, d)."""
        if len(self._points):
            self._asked = self._select()
        return self._asked

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and constraint values (n, c) of the batch."""
        self._points = np.concatenate([self._points, self._asked])
        self._outputs = np.concatenate([self._outputs, np.concatenate([-values, violations], axis=1)])

    def _select(self) -> Array:
        inputs, outputs = torch.tensor(self._points), torch.tensor(self._outputs)
        models = [SingleTaskGP(inputs, column[:, None], outcome_transform=Standardize(m=1)) for column in outputs.T]
        model = ModelListGP(*models)
        fit_gpytorch_mll(SumMarginalLogLikelihood(model.likelihood, model))
        bounds = torch.tensor([[0.0], [1.0]], dtype=torch.double).repeat(1, inputs.shape[1])
        points, _ = optimize_acqf(
            self._acquisition(model, inputs, outputs),
            bounds,
            q=self._start.batch,
            num_restarts=RESTARTS,
            raw_samples=RAW_SAMPLES,
            sequential=True,
        )
        return points.numpy()

    def _acquisition(self, model: ModelListGP, inputs: torch.Tensor, outputs: torch.Tensor) -> torch.nn.Module:
        """Return the acquisition function; outputs (n, m + c): negative objectives and constraint values."""
        m = self._start.objectives
        sampler = SobolQMCNormalSampler(torch.Size([SAMPLES[m]]), seed=self._start.seed)
        limits = [lambda samples, k=k: samples[..., k] for k in range(m, outputs.shape[1])] or None
        if m == 1:
            return qLogNoisyExpectedImprovement(
                model,
                inputs,
                sampler=sampler,
                objective=GenericMCObjective(lambda samples, X=None: samples[..., 0]),
                constraints=limits,
            )
        feasible = (outputs[:, m:] <= 0.0).all(dim=1)
        values = outputs[feasible if feasible.any() else slice(None), :m]
        return qLogNoisyExpectedHypervolumeImprovement(
            model,
            infer_reference_point(values[is_non_dominated(values)]).tolist(),
            inputs,
            sampler=sampler,
            objective=GenericMCMultiOutputObjective(lambda samples, X=None: samples[..., :m]),
            constraints=limits,
            prune_baseline=True,
        )
