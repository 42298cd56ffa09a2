"""Optuna's samplers: TPE, NSGA-II, GP. T. Akiba et al., "Optuna", KDD 2019, pages 2623-2631; version 5.

Settings are those of Optuna but for the start, which all contestants share. What breaks a limit is told as a constraint, to the
GP the worst one only: it models every constraint, and a candidate takes 2 s of a processor as it is.
"""

import warnings
from typing import Any

import numpy as np
import optuna

from benchmarks.search.peer import Array, Start

SIZE = {"TPESampler": "n_startup_trials", "NSGAIISampler": "population_size", "GPSampler": "n_startup_trials"}
"""The setting of each sampler that is the number of candidates of the start."""


def begun(start: Start, sampler: str) -> "Sampler":
    """Return a sampler by its class name at its beginning."""
    return Sampler(start, sampler)


class Sampler:
    """An Optuna study that is asked and told."""

    def __init__(self, start: Start, name: str) -> None:
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        warnings.simplefilter("ignore")
        more: dict[str, Any] = {SIZE[name]: len(start.first)}
        if name == "GPSampler":
            more["deterministic_objective"] = True
        limits = limits_of if start.limits else None
        sampler = getattr(optuna.samplers, name)(seed=start.seed, constraints_func=limits, **more)
        self._study = optuna.create_study(directions=["minimize"] * start.objectives, sampler=sampler)
        self._names = [f"x{i:02d}" for i in range(start.first.shape[1])]
        self._space: dict[str, Any] = {name: optuna.distributions.FloatDistribution(0.0, 1.0) for name in self._names}
        for point in start.first:
            self._study.enqueue_trial(dict(zip(self._names, point.tolist(), strict=True)))
        self._next, self._batch = len(start.first), start.batch
        self._worst_only = name == "GPSampler"
        self._trials: list[optuna.Trial] = []

    def ask(self) -> Array:
        """Return the next batch (n, d)."""
        self._trials = [self._study.ask(self._space) for _ in range(self._next)]
        return np.array([[trial.params[name] for name in self._names] for trial in self._trials])

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and violations (n, c) of the batch asked for."""
        for trial, row, broken in zip(self._trials, values, violations, strict=True):
            limits = broken.max(keepdims=True) if self._worst_only and len(broken) else broken
            trial.set_user_attr("limits", limits.tolist())
            self._study.tell(trial, row.tolist())
        self._next = self._batch


def limits_of(trial: optuna.trial.FrozenTrial) -> list[float]:
    """Return the violations that a trial was told, feasible where none is above 0."""
    return trial.user_attrs["limits"]
