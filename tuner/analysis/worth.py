"""Worth of knowing the numbers of a vehicle better: the value of information over the points at hand.

Points fly the same flights, each with a vehicle of its own, drawn from what is not known. The mean of an objective, given a
number, is a regression on it; choosing the best point for what the number turns out to be, instead of the best one on average, is
worth the difference (expected value of partial perfect information; M. Strong, J. E. Oakley, A. Brennan, Medical Decision Making
34(3):311-326, 2014). Choosing by a fit to chance flatters, by as much as it does where flights and vehicles are paired anew; that
is taken away. The share of the variance that a regression explains is the correlation ratio (M. D. McKay, LA-12915, 1995).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SHUFFLES, LEVEL = 100, 0.95
"""Pairings by chance, and the share of them that a worth must exceed to count."""
FLIGHTS_A_TERM = 8
"""Flights for each term of a regression on all numbers, below which it has no squares."""
FEWEST = 32
"""Flights below which nothing is said."""


@dataclass(frozen=True)
class Worth:
    """A number, or all of them.

    value: by how much the mean of the objective falls where it is known, chance taken away, 0 where it is no more than chance;
    told: whether it is more. share: of the variance of the objective at the point shown that it explains, shows: whether that is
    more than chance.
    """

    value: float
    told: bool
    share: float
    shows: bool


def worths(samples: Array, numbers: Array, shown: int, draw: np.random.Generator) -> tuple[Worth, list[Worth]]:
    """Return what all numbers together are worth, and each of them.

    samples (points, flights): an objective, the smaller the better. numbers (flights, n): what was drawn, of unit size.
    shown: row of the point whose variance is explained. draw: of the pairings by chance.
    """
    shuffles = [draw.permutation(samples.shape[1]) for _ in range(SHUFFLES)]
    each = [_worth(samples, terms(column[:, None], True), shown, shuffles) for column in numbers.T]
    squared = samples.shape[1] >= FLIGHTS_A_TERM * (1 + 2 * numbers.shape[1])
    return _worth(samples, terms(numbers, squared), shown, shuffles), each


def terms(numbers: Array, squared: bool) -> Array:
    """Return an orthonormal basis (flights, terms) of a constant, the numbers (flights, n) and, if asked for, their squares."""
    columns = [np.ones((len(numbers), 1)), numbers, *([numbers**2] if squared else [])]
    return np.linalg.qr(np.concatenate(columns, axis=1))[0]


def _worth(samples: Array, basis: Array, shown: int, shuffles: list[NDArray[np.intp]]) -> Worth:
    value, share = gain(samples, basis), explained(samples[shown], basis)
    chance = np.array([(gain(samples, basis[order]), explained(samples[shown], basis[order])) for order in shuffles])
    told, shows = np.array([value, share]) > np.quantile(chance, LEVEL, axis=0)
    return Worth(max(value - float(chance[:, 0].mean()), 0.0) if told else 0.0, bool(told), share, bool(shows))


def gain(samples: Array, basis: Array) -> float:
    """Return by how much the best of the fitted points, flight by flight, is better than the best one on average."""
    fitted = (samples @ basis) @ basis.T
    return float(np.min(np.mean(samples, axis=1)) - np.mean(np.min(fitted, axis=0)))


def explained(sample: Array, basis: Array) -> float:
    """Return the share of the variance of a sample (flights,) that a basis explains, for as many terms as it has."""
    n, p = basis.shape
    left = sample - basis @ (basis.T @ sample)
    whole = float(np.var(sample, ddof=1))
    return max(1.0 - float(left @ left) / (n - p) / whole, 0.0) if whole > 0.0 else 0.0
