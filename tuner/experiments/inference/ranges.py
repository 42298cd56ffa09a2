"""Certainty of the inferred unknowns: two ranges for each, and the verdict that they allow.

near: the settings whose misfit over all kinds is larger than the least by no more than a stated share. It says what the
fit tolerates, bends included, but is no finer than the settings lie.

low68, high68: what the table can tell at all, being one draw. With J the derivatives of the log ratios by the unknowns u
(in shares of their ranges), S the covariance of ln(ours) over flights at the inferred setting, where all cells of a flight
come from the same air, and before any cell u known to its range only, variance p = 1/12:

    A = (J' J + s/p I)^-1 J',    cov(u) = A S A' + p (I - A J)(I - A J)',    s = mean of the diagonal of S

The first part is the sampling variance of the published flights, the second the unresolved part of the prior, for a model that
is right and nearly linear. A. Tarantola, "Inverse Problem Theory", SIAM, 2005, chapter 3 (linear problem, Gaussian prior).
"""

from dataclasses import dataclass

import numpy as np

from tuner.experiments.inference.misfit import EvaluatedSettings, log_ratio
from tuner.experiments.inference.refine import Jacobian
from tuner.study.inference import Inference, Unknown

# Shares of the searched range (on its scale) up to which a value counts as told, or as told loosely.
MAX_IDENTIFIED, MAX_WEAK = 0.25, 0.5
# Variance of a uniform distribution over the unit interval.
PRIOR_VARIANCE = 1.0 / 12.0


@dataclass(frozen=True)
class Range:
    """The two ranges of an unknown, in its unit; see the module.

    Attributes:
        near_low: Lower end of the near range.
        near_high: Upper end of the near range.
        low68: Lower end of the 68 % range.
        high68: Upper end of the 68 % range.
        share: Share of the searched range (on its scale) that the wider of the two takes.
        at_end: Whether the near range reaches an end of the searched range.
    """

    near_low: float
    near_high: float
    low68: float
    high68: float
    share: float
    at_end: bool

    @property
    def verdict(self) -> str:
        """Say how well the value can be told: "told", "loosely" or "not"."""
        return "told" if self.share <= MAX_IDENTIFIED else "loosely" if self.share <= MAX_WEAK else "not"


def ranges(
    inference: Inference, settings: EvaluatedSettings, chosen: int, jacobian: Jacobian, scores: np.ndarray
) -> list[Range]:
    """Return the ranges of all unknowns; scores (cells, flights): held-out, at the chosen setting."""
    near = near_rows(inference, settings)
    deviation = np.sqrt(np.diag(covariance(jacobian.matrix, scatter(inference, scores))))
    return [
        _range(unknown, settings.values[near, i], float(settings.values[chosen, i]), float(deviation[i]))
        for i, unknown in enumerate(inference.unknowns)
    ]


def near_rows(inference: Inference, settings: EvaluatedSettings) -> np.ndarray:
    """Return a mask (n,) of the settings near the least misfit."""
    misfit = settings.overall(inference)
    return misfit <= (1.0 + inference.near) * misfit.min(axis=0)


def scatter(inference: Inference, scores: np.ndarray) -> np.ndarray:
    """Return the covariance (cells, cells) of ln(ours) over flights, of scores (cells, flights)."""
    return np.atleast_2d(np.cov(log_ratio(scores, inference.published[:, None])))


def covariance(jacobian: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return cov(u) (unknowns, unknowns) for J (cells, unknowns) and S (cells, cells), see the module."""
    count = jacobian.shape[1]
    ridge = np.trace(noise) / len(noise) / PRIOR_VARIANCE + np.finfo(float).tiny
    gain = np.linalg.solve(jacobian.T @ jacobian + ridge * np.eye(count), jacobian.T)
    unresolved = np.eye(count) - gain @ jacobian
    return gain @ noise @ gain.T + PRIOR_VARIANCE * unresolved @ unresolved.T


def _range(unknown: Unknown, near: np.ndarray, inferred: float, deviation: float) -> Range:
    variable = unknown.variable
    ends = float(near.min(axis=0)), float(near.max(axis=0))
    units, middle = [variable.unit(end) for end in ends], variable.unit(inferred)
    posterior = np.clip([middle - deviation, middle + deviation], 0.0, 1.0)
    low, high = variable.value(posterior).tolist()
    share = max(units[1] - units[0], float(posterior[1] - posterior[0]))
    return Range(*ends, low, high, share, units[0] <= 0.0 or units[1] >= 1.0)
