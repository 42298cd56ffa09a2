"""Random effects: scatter of a vehicle's parameters between flights, and tests of homogeneity.

Each flight is fitted alone; the scatter of a parameter is what its estimates differ by beyond their own errors (DerSimonian and
Laird, Controlled Clinical Trials 7, 1986). A test compares a flight with others: the sum of squared standardized differences,
whose distribution is that of a scaled chi-square variable (Satterthwaite, Biometrics 2, 1946). It needs no inverse of
a covariance that few seconds of flight give roughly.
"""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

Array = NDArray[np.float64]

SIGNIFICANCE = 0.01
"""Probability under homogeneity below which a flight contradicts others."""
QUANTILE = 1.96
"""Quantile of a two-sided interval of 95 %, in standard deviations."""
CAUSES = {
    "battery": ("thrust.30", "thrust.65", "thrust.100", "lag_up", "lag_down"),
    "payload": ("mass", "inertia.x", "inertia.y", "inertia_share", "centre.x", "centre.y", "drag_linear.z"),
    "propellers": (
        "thrust.30",
        "thrust.65",
        "thrust.100",
        "torque_ratio",
        "drag_linear.z",
        "rate_damping",
        "rotor_inertia",
        "lag_up",
        "lag_down",
    ),
    "firmware": ("thrust.30", "thrust.65", "thrust.100", "dead_time", "gyro_delay", "lag_up", "lag_down"),
}
"""Changes between flights, and the parameters that each changes."""


class FlightEstimate(NamedTuple):
    """Parameters from a flight, or pooled from several, given mass and arms.

    Attributes:
        flight: Its name.
        names: Names (k,) of the identified coordinates.
        point: Coordinates (k,).
        covariance: Their covariance (k, k).
    """

    flight: str
    names: tuple[str, ...]
    point: Array
    covariance: Array

    @property
    def std(self) -> Array:
        """Standard deviations (k,)."""
        return np.sqrt(np.diag(self.covariance))

    def without(self, names: Collection[str]) -> "FlightEstimate":
        """Return the estimate of all other coordinates."""
        rest = [k for k, name in enumerate(self.names) if name not in names]
        left = tuple(self.names[k] for k in rest)
        return FlightEstimate(self.flight, left, self.point[rest], self.covariance[np.ix_(rest, rest)])


class HomogeneityTest(NamedTuple):
    """A test of a flight against others.

    Attributes:
        statistic: Chi-square.
        degrees: Its degrees of freedom.
        probability: Probability of a larger statistic in any of the tests where the vehicle is the same.
        differences: Name of a parameter -> difference in standard deviations, those beyond 1.96.
    """

    statistic: float
    degrees: float
    probability: float
    differences: dict[str, float]

    @property
    def is_rejected(self) -> bool:
        """Whether the flights contradict each other."""
        return self.probability < SIGNIFICANCE

    @property
    def causes(self) -> list[str]:
        """Changes that explain the differences, those that explain most first."""
        explained = {cause: len(self.differences.keys() & set(names)) for cause, names in CAUSES.items()}
        return sorted((cause for cause, count in explained.items() if count), key=lambda cause: -explained[cause])


def between_flight_std(estimates: Sequence[FlightEstimate]) -> dict[str, float]:
    """Return the scatter of coordinates that two or more flights identify."""
    return {
        name: _scatter(values, variances)
        for name, (values, variances) in _marginals(estimates).items()
        if len(values) > 1
    }


def predictive_variance(estimates: Sequence[FlightEstimate]) -> dict[str, float]:
    """Return the variance of coordinates of the next flight by scatter.

    That of the flight, and that of the mean of those that identify the coordinate.
    """
    counts = {name: len(values) for name, (values, _) in _marginals(estimates).items()}
    return {name: std**2 * (1.0 + 1.0 / counts[name]) for name, std in between_flight_std(estimates).items()}


def pooled_estimate(estimates: Sequence[FlightEstimate], scatter: Mapping[str, float] | None = None) -> FlightEstimate:
    """Return the inverse-variance weighted mean of flights.

    Args:
        estimates: From each flight alone.
        scatter: Name of a coordinate -> its standard deviation between flights.
    """
    names = tuple(dict.fromkeys(name for entry in estimates for name in entry.names))
    weights = [_weights(entry, names, scatter or {}) for entry in estimates]
    total = np.sum([part.sum(axis=1) for part in weights], axis=0)
    shares = [part / total[:, None] for part in weights]
    point = np.sum([part @ entry.point for part, entry in zip(shares, estimates, strict=True)], axis=0)
    covariance = np.sum(
        [part @ entry.covariance @ part.T for part, entry in zip(shares, estimates, strict=True)], axis=0
    )
    return FlightEstimate(", ".join(entry.flight for entry in estimates), names, point, covariance)


def compare_estimates(
    flight: FlightEstimate, others: FlightEstimate, scatter: Mapping[str, float] | None = None
) -> HomogeneityTest:
    """Test whether a flight is of the same vehicle as others.

    Args:
        flight: The flight.
        others: Others, pooled.
        scatter: Name of a coordinate -> variance that scatter between flights adds to the difference.
    """
    names = [name for name in flight.names if name in others.names]
    if not names:
        return HomogeneityTest(0.0, 1.0, 1.0, {})
    first, second = ([entry.names.index(name) for name in names] for entry in (flight, others))
    difference = flight.point[first] - others.point[second]
    covariance = flight.covariance[np.ix_(first, first)] + others.covariance[np.ix_(second, second)]
    covariance = covariance + np.diag([(scatter or {}).get(name, 0.0) for name in names])
    std = np.sqrt(np.diag(covariance))
    z = difference / std
    correlation = covariance / np.outer(std, std)
    # Mean and variance of the sum of squares are k and twice the squared norm of the correlation matrix.
    k, norm = len(names), float(np.sum(correlation**2))
    degrees, statistic = k * k / norm, float(z @ z) * k / norm
    beyond = {name: value for name, value in zip(names, z.tolist(), strict=True) if abs(value) > QUANTILE}
    return HomogeneityTest(statistic, degrees, float(chdtrc(degrees, statistic)), beyond)


def compare_flights(estimates: Sequence[FlightEstimate]) -> list[HomogeneityTest]:
    """Test each of two or more flights against all others; [] for one."""
    if len(estimates) == 1:
        return []
    tests = [
        compare_estimates(entry, pooled_estimate([*estimates[:i], *estimates[i + 1 :]]))
        for i, entry in enumerate(estimates)
    ]
    # The tests of two flights are one.
    return tests if len(tests) == 2 else adjusted(tests)


def adjusted(tests: Sequence[HomogeneityTest]) -> list[HomogeneityTest]:
    """Return tests with probabilities times their number (Bonferroni)."""
    return [test._replace(probability=min(len(tests) * test.probability, 1.0)) for test in tests]


def _marginals(estimates: Sequence[FlightEstimate]) -> dict[str, tuple[Array, Array]]:
    """Return values and variances of every coordinate over its flights."""
    names = dict.fromkeys(name for entry in estimates for name in entry.names)
    chosen = {name: [(entry, entry.names.index(name)) for entry in estimates if name in entry.names] for name in names}
    return {
        name: (
            np.array([entry.point[k] for entry, k in places]),
            np.array([entry.covariance[k, k] for entry, k in places]),
        )
        for name, places in chosen.items()
    }


def _scatter(values: Array, variances: Array) -> float:
    """Return the standard deviation between flights by the method of moments."""
    weights = 1.0 / variances
    mean = float(weights @ values) / float(weights.sum())
    excess = float(weights @ (values - mean) ** 2) - (len(values) - 1)
    return float(np.sqrt(max(excess, 0.0) / (weights.sum() - float(weights @ weights) / weights.sum())))


def _weights(estimate: FlightEstimate, names: Sequence[str], scatter: Mapping[str, float]) -> Array:
    """Return the weights (names, k) of an estimate in rows of names."""
    weights = np.zeros((len(names), len(estimate.names)))
    for k, name in enumerate(estimate.names):
        weights[names.index(name), k] = 1.0 / (estimate.covariance[k, k] + scatter.get(name, 0.0) ** 2)
    return weights
