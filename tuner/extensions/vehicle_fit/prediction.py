"""Prediction over short windows, which are held out of the fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.vehicle_fit.fit import Problem
from tuner.extensions.vehicle_fit.model import actuator, lagging, predicted
from tuner.extensions.vehicle_fit.samples import LogSegment

Array = NDArray[np.float64]

HORIZON = 0.5
"""Length of a window [s]: at its begin the rates are given, and a constant disturbance over it is not held against the model."""
HELD_OUT, OF = 1, 5
"""Number of held-out parts of `PART` seconds among so many."""
PART = 1.0
SETTLING, MAX_SETTLING_SHARE = 0.5, 0.2
"""Begin of a segment that neither fit nor validation uses [s], and the largest share of it: rotors' speeds there follow from
commands before it.
"""


@dataclass(frozen=True, eq=False)
class PredictionWindows:
    """Windows of prediction: times (w, m) [s], measured and modeled (w, m, 4): rates [rad/s], lift [m/s2], about their means."""

    time: Array
    measured: Array
    modeled: Array

    @property
    def is_empty(self) -> bool:
        """Whether no window lies in the chosen samples: a short flight keeps none from the fit."""
        return not len(self.time)

    @property
    def explained(self) -> Array:
        """Share (4,) of the variance of each output that the model explains; negative where it predicts worse than the mean."""
        residual = np.sum((self.measured - self.modeled) ** 2, axis=(0, 1))
        return 1.0 - residual / np.maximum(np.sum(self.measured**2, axis=(0, 1)), 1e-300)

    @property
    def errors(self) -> Array:
        """RMS errors (4,): of the rates [rad/s] and of the lift [m/s2]."""
        return np.sqrt(np.mean((self.measured - self.modeled) ** 2, axis=(0, 1)))


def settled_masks(samples: Sequence[LogSegment]) -> tuple[Array, ...]:
    """Return masks (m,) of the samples of segments: 0 while rotors settle."""
    return tuple(_is_settled(part).astype(float) for part in samples)


def fit_masks(samples: Sequence[LogSegment]) -> tuple[Array, ...]:
    """Return masks (m,) of the samples of the fit.

    0 on every `OF`-th part of `PART` seconds, and while rotors settle.
    """
    return tuple(
        (_is_settled(part) & ((part.time - part.begin) // PART % OF >= HELD_OUT)).astype(float) for part in samples
    )


def held_out(part: LogSegment, mask: Array) -> NDArray[np.bool_]:
    """Return the samples (m,) that validate a fit of a mask."""
    return (mask == 0.0) & _is_settled(part)


def _is_settled(part: LogSegment) -> NDArray[np.bool_]:
    age = part.time - part.begin
    return age >= min(SETTLING, MAX_SETTLING_SHARE * float(age[-1])) if len(age) else np.zeros(0, bool)


def prediction_windows(problem: Problem, point: Array, is_held_out: bool = True) -> PredictionWindows:
    """Return the windows that lie in held-out samples, or all of them."""
    numbers = problem.space.numbers(point)
    model = [
        predicted(part, lagging(part, [actuator(numbers)])[0], numbers, problem.vehicle) for part in problem.samples
    ]
    inside = 0.0 if is_held_out else None
    measured = [part.measured for part in problem.samples]
    return PredictionWindows(_times(problem, inside), *[cut(problem, series, inside) for series in (measured, model)])


def cut(problem: Problem, series: Sequence[Array], inside: float | None) -> Array:
    """Return the windows (w, m, 4) where masks are `inside`: 0 or 1 throughout; None: all. series: outputs (m, 4).

    Changes of rates are summed up, without a straight line; lift stands without its mean.
    """
    return _concatenate([_window(part[chosen]) for part, chosen in zip(series, _places(problem, inside), strict=True)])


def _times(problem: Problem, inside: float | None) -> Array:
    return _concatenate(
        [part.time[chosen] for part, chosen in zip(problem.samples, _places(problem, inside), strict=True)]
    )


def _concatenate(windows: list[Array]) -> Array:
    # Segments of logs of different rates have windows of different lengths.
    width = min(window.shape[1] for window in windows)
    return np.concatenate([window[:, :width] for window in windows])


def _places(problem: Problem, inside: float | None) -> list[NDArray[np.intp]]:
    """Return for each segment the indices (w, m) of its windows."""
    places = []
    for part, mask in zip(problem.samples, problem.masks, strict=True):
        width = max(int(HORIZON / (part.period * part.share)), 2)
        index = np.arange(len(mask) // width * width).reshape(-1, width)
        chosen = {None: np.ones(len(mask), bool), 1.0: mask == 1.0, 0.0: held_out(part, mask)}[inside]
        places.append(index[np.all(chosen[index], axis=1)])
    return places


def _window(series: Array) -> Array:
    rates = np.cumsum(series[..., :3], axis=1)
    time = np.linspace(-1.0, 1.0, series.shape[1])
    slope = np.einsum("wmk,m->wk", rates, time) / np.sum(time**2)
    rates = rates - rates.mean(axis=1, keepdims=True) - slope[:, None] * time[:, None]
    lift = series[..., 3:] - series[..., 3:].mean(axis=1, keepdims=True)
    return np.concatenate([rates, lift], axis=-1)
