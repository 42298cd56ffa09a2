"""Gaussian processes of the objectives, each on its likeliest scale.

A value is modelled as log(1 + value / scale), with the scale that has the largest posterior density of the data, their Jacobian
included: small for costs that span decades, large for those that a process follows as they are (a warped Gaussian process:
E. Snelson, C. E. Rasmussen, Z. Ghahramani, NIPS 2003).
"""

from collections.abc import Callable
from math import sqrt
from typing import NamedTuple

import numpy as np

from plant.threads import parallel_map
from tuner.search.acquisition import HypervolumeImprovement, ReferenceBox, sample_directions
from tuner.search.gaussian_process import (
    GaussianProcess,
    Hyperparameters,
    fit_hyperparameters,
    mean_log_density,
)
from tuner.search.scaling import spread

Array = np.ndarray
# Quantile of an objective's values that counts as its range where scales of the logarithm are tried, and the multiple of it on
# which the logarithm is nearly a line.
RANGE_QUANTILE, LINEAR = 0.9, 4.0
# Joint samples of the objectives over the pool, and directions in which a front of two objectives is measured and one of more: in
# space 64 are so far apart that many a point of the front decides nothing (0.939 of the best known held out, with 256 0.964).
N_SAMPLES, N_DIRECTIONS_PLANE, N_DIRECTIONS_SPACE = 64, 64, 256
# Values beyond this many spreads above the smallest are as bad as any; logarithms even out those below.
MAX_SPREADS = 1e4
# Largest number of points that a model is conditioned on: those that are best in the mean of all objectives.
MAX_OBJECTIVE_DATA = 400
# Standard deviations below its mean at which an objective is taken where an end of the front is foreseen: an end that is merely
# possible keeps the box open.
CONFIDENCE_BOUND = 2.0
# Probability of feasibility from which on a candidate may be an end of the front that is foreseen.
MIN_PROBABILITY = 0.5


class OutputScale(NamedTuple):
    """Hyperparameters of a process of log(1 + value / scale)."""

    scale: float
    hyperparameters: Hyperparameters


class ObjectiveSample(NamedTuple):
    """Samples of an objective at points. values (s, p), medians (p,); lower_bounds (p,): on the scale of its process."""

    values: Array
    medians: Array
    lower_bounds: Array


class ObjectiveModel:
    """The model of an objective: a Gaussian process of log(1 + value / scale)."""

    def __init__(self, points: Array, values: Array, fit: OutputScale) -> None:
        self._scale = fit.scale
        self._process = GaussianProcess(points, np.log1p(values / fit.scale), fit.hyperparameters)

    def sample(self, pool: Array, normals: Array, jointly: bool) -> ObjectiveSample:
        """Return samples of the values at points (p, d).

        jointly: as one function made of normals (s, p); else each point by itself, of normals (s, 1).
        """
        posterior = self._process.posterior(pool, jointly)
        logs = posterior.samples(normals) if jointly else posterior.mean + posterior.std * normals
        optimistic = posterior.mean - CONFIDENCE_BOUND * posterior.std
        return ObjectiveSample(self._value(logs), self._value(np.maximum(posterior.mean, 0.0)), optimistic)

    def _value(self, logs: Array) -> Array:
        return self._scale * np.expm1(np.minimum(logs, np.log1p(MAX_SPREADS / self._scale)))


def fit_output_scale(points: Array, values: Array, start: OutputScale | None = None) -> OutputScale:
    """Return the likeliest scale of values, and its hyperparameters.

    values (n,): 0 or more, at points (n, d);
    start: an earlier fit, whose hyperparameters the fits of all scales begin from.
    """
    fits: list[tuple[float, OutputScale]] = []
    reach = max(float(np.quantile(values, RANGE_QUANTILE)), 1.0)
    for scale in (1.0, sqrt(LINEAR * reach), LINEAR * reach):
        targets = np.log1p(values / scale)
        hyperparameters = fit_hyperparameters(points, targets, start.hyperparameters if start else None)
        # The Jacobian of log(1 + value / scale) is 1 / (scale + value).
        density = mean_log_density(points, targets, hyperparameters) - float(np.log(scale + values).mean())
        fits.append((density, OutputScale(scale, hyperparameters)))
    return max(fits, key=lambda fit: fit[0])[1]


class ObjectiveModels:
    """Models of the objectives, and the front to improve.

    Args:
        points: evaluated points (n, d).
        values: their objectives (n, m), scaled by `scale_values`.
        is_valid: mask (n,) of the rows whose values count.
        front: rows (k,) of the non-dominated points.
        fit: fits an objective, given by its index, points and values.
        rng: source of directions and samples.
        reference: reference point (m,), scaled alike; NaN where front and default decide.
    """

    def __init__(
        self,
        points: Array,
        values: Array,
        is_valid: Array,
        front: Array,
        fit: Callable[[int, Array, Array], OutputScale],
        rng: np.random.Generator,
        reference: Array,
    ) -> None:
        rows = np.flatnonzero(is_valid)
        depth = np.log1p(values[rows]).mean(axis=1)
        rows = np.sort(rows[np.argsort(depth, kind="stable")[:MAX_OBJECTIVE_DATA]])
        points, targets = points[rows], values[rows]
        self._models = parallel_map(
            lambda j: ObjectiveModel(points, targets[:, j], fit(j, points, targets[:, j])), range(values.shape[1])
        )
        self._front, self._worst = values[front], targets.max(axis=0)
        self._box = _reference_box(values, front, reference)
        count = N_DIRECTIONS_PLANE if len(self._models) <= 2 else N_DIRECTIONS_SPACE
        self._directions = sample_directions(count, len(self._models), rng)
        self._rng = rng

    def marginal_improvement(self, pool: Array, probability: Array) -> HypervolumeImprovement:
        """Return the acquisition of single candidates (p, d); the box is extended to the ends of the front foreseen in them.

        probability (p,): of their feasibility.
        """
        samples = self._sample(pool, jointly=False)
        rows = np.flatnonzero(probability > MIN_PROBABILITY)
        if len(rows):
            ends = rows[[sample.lower_bounds[rows].argmin() for sample in samples]]
            self._box.extend(np.stack([sample.medians[ends] for sample in samples], axis=1), self._worst)
        return self._improvement(samples)

    def joint_improvement(self, pool: Array) -> HypervolumeImprovement:
        """Return the acquisition of candidates (p, d) for a whole batch."""
        return self._improvement(self._sample(pool, jointly=True))

    def _improvement(self, samples: list[ObjectiveSample]) -> HypervolumeImprovement:
        values = np.stack([sample.values for sample in samples], axis=2)
        return HypervolumeImprovement(self._box.normalize(values), self._box.normalize(self._front), self._directions)

    def _sample(self, pool: Array, jointly: bool) -> list[ObjectiveSample]:
        """Return samples of each objective of candidates (p, d)."""
        normals = [self._rng.standard_normal((N_SAMPLES, len(pool) if jointly else 1)) for _ in self._models]
        pairs = list(zip(self._models, normals, strict=True))
        return parallel_map(lambda pair: pair[0].sample(pool, pair[1], jointly), pairs)


def _reference_box(values: Array, front: Array, reference: Array) -> ReferenceBox:
    default = None if np.any(values[0] >= 0.99 * MAX_SPREADS) else values[0]
    return ReferenceBox(values[front], default, reference)


def reference_point(values: Array, is_valid: Array, front: Array, given: Array) -> Array:
    """Return the objectives (m,) up to which the hypervolume counts in full.

    Args:
        values: objectives (n, m), those of the default first.
        is_valid: mask (n,) of the rows whose values count.
        front: rows (k,) of the non-dominated points.
        given: reference point (m,) that is given; NaN where there is none.
    """
    scaled, reference = scale_values(values, is_valid, given[None])
    low, unit = _scales(values, is_valid)
    return low + unit * _reference_box(scaled, front, reference[0]).near_point


def scale_values(values: Array, is_valid: Array, *others: Array) -> tuple[Array, ...]:
    """Return values (n, m) in spreads above the smallest valid one.

    They reach from 0 to `MAX_SPREADS`; others (k, m) are scaled alike.
    """
    low, unit = _scales(values, is_valid)
    most = low + np.minimum(MAX_SPREADS * unit, 1e300)
    return tuple((np.clip(entry, low, most) - low) / unit for entry in (values, *others))


def _scales(values: Array, is_valid: Array) -> tuple[Array, Array]:
    """Return the smallest valid values (m,) and the spreads (m,); 0 and 1 where nothing is valid."""
    low, unit = np.zeros(values.shape[1]), np.ones(values.shape[1])
    if np.any(is_valid):
        ordered = np.sort(values[is_valid], axis=0)
        low, unit = ordered[0], np.array([spread(column) for column in ordered.T])
    return low, unit
