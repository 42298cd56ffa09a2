"""Acquisition functions of the Bayesian optimization: Monte Carlo EHVI, and feasibility until a feasible point exists.

The hypervolume of a front is, up to the constant c_m, the mean over directions of its largest hypervolume scalarization
(D. Golovin and Q. Zhang, "Random hypervolume scalarizations for provable multi-objective black box optimization", ICML
2020, lemma 5). Its mean increase over posterior samples is the expected hypervolume improvement (EHVI; M. Emmerich,
K. Giannakoglou and B. Naujoks, IEEE Trans. Evolutionary Computation 10(4):421-439, 2006; for batches, S. Daulton,
M. Balandat and E. Bakshy, NeurIPS 2020). With one objective it is the expected improvement.
"""

from math import pi

import numpy as np

from tuner.search.covariance import compiled
from tuner.search.gaussian_process import Posterior
from tuner.search.sobol import Sobol

Array = np.ndarray
# Distance of the reference point beyond the default, relative to that of the default from the front's best values; and its least
# distance from these.
MARGIN, MIN_EDGE = 0.1, 2.0


def sample_directions(count: int, objectives: int, rng: np.random.Generator) -> Array:
    """Return evenly spread unit vectors (count, m) of the positive orthant: turned at random; one for m = 1."""
    if objectives == 1:
        return np.ones((1, 1))
    if objectives == 2:
        angle = (np.arange(count) + rng.uniform()) / count * (pi / 2.0)
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)
    from scipy.special import ndtri

    # The normal distribution is isotropic; of each number, the half above 0.
    share = Sobol(objectives, rng).random(count)
    normal = np.maximum(ndtri(0.5 + 0.5 * share), 1e-9)
    return normal / np.sqrt(np.square(normal).sum(axis=1, keepdims=True))


def hypervolume_scalarization(points: Array, directions: Array) -> Array:
    """Return min_j(max(y_j, 0) / w_j)^m (..., l) of normalized points (..., m) in directions (l, m)."""
    lengths = np.min(points[..., None, :] / directions, axis=-1)
    return np.maximum(lengths, 0.0) ** directions.shape[1]


@compiled
def mean_improvement(samples: Array, directions: Array, best: Array) -> Array:
    """Return the mean increase (p,) of the scalarizations over samples and directions.

    Args:
        samples: joint posterior samples (s, p, m) of p candidates, normalized.
        directions: unit vectors (l, m) of the scalarizations.
        best: largest scalarizations (s, l) of the front in each sample.
    """
    sums = np.zeros(samples.shape[1])
    inverse = 1.0 / directions
    for s in range(samples.shape[0]):
        for p in range(samples.shape[1]):
            total = 0.0
            for i in range(len(directions)):
                length = samples[s, p, 0] * inverse[i, 0]
                for j in range(1, samples.shape[2]):
                    length = min(length, samples[s, p, j] * inverse[i, j])
                length = max(length, 0.0)
                power = length
                for _ in range(1, samples.shape[2]):
                    power *= length
                total += max(power - best[s, i], 0.0)
            sums[p] += total
    return sums / (samples.shape[0] * len(directions))


class ReferenceBox:
    """Box in which hypervolume is measured: from a front's best values to a reference point.

    The reference is a tenth beyond the default, as in `front.hypervolume`, or beyond the median of the front where that is worse.

    Args:
        front: objectives (k, m) of the non-dominated points.
        default: objectives (m,) of the default; None where it failed.
    """

    def __init__(self, front: Array, default: Array | None) -> None:
        self._low = front.min(axis=0)
        anchor = np.maximum(np.median(front, axis=0), front.max(axis=0) if default is None else default)
        self._edges = np.maximum((1.0 + MARGIN) * (anchor - self._low), MIN_EDGE)

    def normalize(self, values: Array) -> Array:
        """Return objectives (..., m) normalized: 1 at the front's best values, 0 at the reference point."""
        return 1.0 - (values - self._low) / self._edges


class HypervolumeImprovement:
    """Expected hypervolume improvement (EHVI) over a front and pending points, divided by c_m.

    Args:
        samples: joint posterior samples (s, p, m) of p candidates, normalized by a `ReferenceBox`.
        front: normalized objectives (k, m) of the non-dominated points.
        directions: unit vectors (l, m) of the scalarizations.
    """

    def __init__(self, samples: Array, front: Array, directions: Array) -> None:
        self._samples, self._directions = samples, directions
        self._best = np.tile(hypervolume_scalarization(front, directions).max(axis=0), (len(samples), 1))

    def evaluate(self, rows: Array) -> Array:
        """Return the acquisition values (r,) of candidates, given by row."""
        return mean_improvement(np.ascontiguousarray(self._samples[:, rows]), self._directions, self._best)

    def add_pending(self, row: int) -> None:
        """Add a candidate to the pending points, with its sampled objectives."""
        self._best = np.maximum(self._best, hypervolume_scalarization(self._samples[:, row], self._directions))


class FeasibilityAcquisition:
    """Acquisition while no feasible point exists: exp(-total violation) of one posterior sample per candidate.

    Args:
        constraints: posteriors of the scaled constraint values at the candidates, feasible at 0 or below.
        n_candidates: number of candidates.
        rng: source of the samples.
    """

    def __init__(self, constraints: list[Posterior], n_candidates: int, rng: np.random.Generator) -> None:
        self._constraints, self._n_candidates, self._rng = constraints, n_candidates, rng
        self._resample()

    def evaluate(self, rows: Array) -> Array:
        """Return the acquisition values (r,) of candidates, given by row; 1 where the sample violates nothing."""
        return self._values[rows]

    def add_pending(self, _row: int) -> None:
        """Draw new samples for the next choice; the pending point itself has no effect."""
        self._resample()

    def _resample(self) -> None:
        violation = np.zeros(self._n_candidates)
        for posterior in self._constraints:
            violation += np.maximum(posterior.mean + posterior.std * self._rng.standard_normal(self._n_candidates), 0.0)
        self._values = np.exp(-violation)
