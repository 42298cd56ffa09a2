"""How well a point predicts what was measured, over short windows, and which windows are kept from the fit for it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tuner.analysis.identification.fit import Problem
from tuner.analysis.identification.model import actuator, lagging, predicted
from tuner.analysis.identification.samples import Samples

Array = NDArray[np.float64]

HORIZON = 0.5
"""Length of a window [s]: at its begin the rates are given, and a constant disturbance over it is not held against the model."""
KEPT_FROM_FIT, OF = 1, 5
"""Of so many parts of `PART` seconds, those that are kept from the fit."""
PART = 1.0


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of prediction: times (w, m) [s], measured and modelled (w, m, 4): rates [rad/s], lift [m/s2], about their means."""

    time: Array
    measured: Array
    modelled: Array

    @property
    def explained(self) -> Array:
        """Share (4,) of the variance of each output that the model explains; below 0 where it is worse than nothing."""
        left = np.sum((self.measured - self.modelled) ** 2, axis=(0, 1))
        whole = np.sum(self.measured**2, axis=(0, 1))
        return 1.0 - left / np.maximum(whole, 1e-300)

    @property
    def errors(self) -> Array:
        """RMS errors (4,): of the rates [rad/s] and of the lift [m/s2]."""
        return np.sqrt(np.mean((self.measured - self.modelled) ** 2, axis=(0, 1)))


def fit_masks(samples: Sequence[Samples]) -> tuple[Array, ...]:
    """Return masks (m,) of what the fit may use: 0 on every `OF`-th part of `PART` seconds."""
    return tuple(((part.time - part.begin) // PART % OF >= KEPT_FROM_FIT).astype(float) for part in samples)


def windowed(problem: Problem, point: Array, held_out: bool = True) -> Windows:
    """Return the windows that lie whole in what the masks leave out, or all of them."""
    numbers = problem.space.numbers(point)
    model = [
        predicted(part, lagging(part, [actuator(numbers)])[0], numbers, problem.vehicle) for part in problem.samples
    ]
    inside = 0.0 if held_out else None
    measured = [part.measured for part in problem.samples]
    return Windows(_times(problem, inside), *[cut(problem, series, inside) for series in (measured, model)])


def cut(problem: Problem, series: Sequence[Array], inside: float | None) -> Array:
    """Return the windows (w, m, 4) of what is compared (m, 4) where the masks are whole `inside`, 0 or 1; None: all of them.

    Changes of rates are summed up, without a straight line; lift stands without its mean.
    """
    found = [_window(part[chosen]) for part, chosen in zip(series, _places(problem, inside), strict=True)]
    # Stretches of logs of different rates have windows of different lengths.
    least = min(entry.shape[1] for entry in found)
    return np.concatenate([entry[:, :least] for entry in found])


def _times(problem: Problem, inside: float | None) -> Array:
    found = [part.time[chosen] for part, chosen in zip(problem.samples, _places(problem, inside), strict=True)]
    least = min(entry.shape[1] for entry in found)
    return np.concatenate([entry[:, :least] for entry in found])


def _places(problem: Problem, inside: float | None) -> list[NDArray[np.intp]]:
    """Return for each stretch the indices (w, m) of its windows."""
    found = []
    for part, mask in zip(problem.samples, problem.masks, strict=True):
        width = max(int(HORIZON / (part.period * part.share)), 2)
        index = np.arange(len(mask) // width * width).reshape(-1, width)
        found.append(index if inside is None else index[np.all(mask[index] == inside, axis=1)])
    return found


def _window(series: Array) -> Array:
    rates = np.cumsum(series[..., :3], axis=1)
    time = np.linspace(-1.0, 1.0, series.shape[1])
    slope = np.einsum("wmk,m->wk", rates, time) / np.sum(time**2)
    rates = rates - rates.mean(axis=1, keepdims=True) - slope[:, None] * time[:, None]
    lift = series[..., 3:] - series[..., 3:].mean(axis=1, keepdims=True)
    return np.concatenate([rates, lift], axis=-1)
