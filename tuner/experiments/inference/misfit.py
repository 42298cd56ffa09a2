"""Settings that were flown: misfit to the published cells, medians, and where the published values stand.

The misfit is one number for each kind of cell, 0 where all are met:

    r = ln(ours / published),    misfit of a kind = sqrt(mean over its cells of r^2),    kinds: "peak", "settling", ...

ours is the median over the flights: unlike the mean it is robust against long tails, settling times cut off by the end of the
flight and costs of failed flights. The logarithm makes radians and seconds comparable. Cells are not weighted by their scatter: a
setting under which everything scatters would then fit best. Scatter gives the tolerance of a published cell, which is one draw.
"""

from dataclasses import dataclass

import numpy as np

from plant.ties import first_smallest
from tuner.experiments.contest.judging import is_inside, percentile_of
from tuner.search.front import feasible_front
from tuner.study.inference import LEAST_RATIO, Inference

# Ends of the central 68 % and 95 % of flights.
CENTRAL_68, CENTRAL_95 = (0.16, 0.84), (0.025, 0.975)
LOCAL_REFINEMENT = -1
"""Origin of the settings that were flown around the best one."""
# Share of a published value that stands for 0 in a ratio.
RATIO_FLOOR = 1e-6


def log_ratio(ours: np.ndarray, published: np.ndarray) -> np.ndarray:
    """Return ln(ours / published) (...), where no ratio counts for less than 1/50; published is positive."""
    return np.log(np.maximum(ours / published, LEAST_RATIO))


def misfits(medians: np.ndarray, published: np.ndarray, kinds: np.ndarray) -> np.ndarray:
    """Return the misfit of each kind (n, kinds) of medians (n, cells); kinds (cells,): number of each cell's kind."""
    squares = np.square(log_ratio(medians, published))
    return np.stack([np.sqrt(squares[:, kinds == kind].mean(axis=1)) for kind in range(int(kinds.max()) + 1)], axis=1)


def overall(misfits: np.ndarray) -> np.ndarray:
    """Return the root mean square over the kinds (n,) of misfits (n, kinds): all kinds count alike."""
    return np.sqrt(np.square(misfits).mean(axis=1))


def weights(kinds: np.ndarray) -> np.ndarray:
    """Return the weights (cells,) of squared log ratios in the squared misfit; the sum is 1."""
    counts = np.bincount(kinds)
    return 1.0 / (len(counts) * counts[kinds])


def tolerance(scores: np.ndarray, published: np.ndarray) -> np.ndarray:
    """Return the half-width (cells,) of the central 68 % of ln(ours) over flights; scores (cells, flights)."""
    low, high = np.quantile(log_ratio(scores, published[:, None]), CENTRAL_68, axis=1)
    return 0.5 * (high - low)


@dataclass(frozen=True)
class EvaluatedSettings:
    """Settings in the order they were flown.

    Attributes:
        values: Values (n, unknowns).
        origin: Number of the generation (n,), LOCAL_REFINEMENT for those flown around the best.
        median: Medians of the flights (n, cells).
        percentile: Percentile of the published value among the flights (n, cells).
        ratio: Medians of the ratios between contenders, flight by flight (n, ratios).
        ratio_percentile: Percentile of the published ratio among these (n, ratios).
        failures: Share of flights that failed (n, cells).
    """

    values: np.ndarray
    origin: np.ndarray
    median: np.ndarray
    percentile: np.ndarray
    ratio: np.ndarray
    ratio_percentile: np.ndarray
    failures: np.ndarray

    def misfits(self, inference: Inference) -> np.ndarray:
        """Return the misfit of each kind (n, kinds)."""
        return misfits(self.median, inference.published, inference.kind_of)

    def overall(self, inference: Inference) -> np.ndarray:
        """Return the misfit over all kinds (n,)."""
        return overall(self.misfits(inference))

    @property
    def inside(self) -> np.ndarray:
        """Mask (n, cells) of published values that one of the flights could have."""
        return is_inside(self.percentile)

    @property
    def ratio_inside(self) -> np.ndarray:
        """Mask (n, ratios) of published ratios that one of the flights could have."""
        return is_inside(self.ratio_percentile)


def evaluate_settings(
    inference: Inference, values: np.ndarray, origin: int, scores: np.ndarray, failed: np.ndarray
) -> EvaluatedSettings:
    """Return the statistics of scores and failed (n, cells, flights) of settings (n, unknowns)."""
    ratios = ratio_scores(inference, scores)
    return EvaluatedSettings(
        values,
        np.full(len(values), origin),
        np.median(scores, axis=-1),
        percentile_of(inference.published, scores),
        np.median(ratios, axis=-1),
        percentile_of(published_ratios(inference), ratios),
        failed.mean(axis=-1),
    )


def concatenate(parts: list[EvaluatedSettings]) -> EvaluatedSettings:
    """Return several as one, in their order."""
    fields = EvaluatedSettings.__dataclass_fields__
    return EvaluatedSettings(*[np.concatenate([getattr(part, name) for part in parts], axis=0) for name in fields])


def published_ratios(inference: Inference) -> np.ndarray:
    """Return the published ratios between contenders (ratios,)."""
    return np.array([inference.published[r.second] / inference.published[r.first] for r in inference.ratios])


def ratio_scores(inference: Inference, scores: np.ndarray) -> np.ndarray:
    """Return the ratios between contenders in each flight (n, ratios, flights), of scores (n, cells, flights).

    Where one of two times is 0, their ratio is next to 0 or very large; where both are, it is 1.
    """
    first, second = ([getattr(ratio, name) for ratio in inference.ratios] for name in ("first", "second"))
    least = RATIO_FLOOR * inference.published[first][:, None]
    return np.maximum(scores[:, second], least) / np.maximum(scores[:, first], least)


def front(misfits: np.ndarray) -> np.ndarray:
    """Return the indices of the non-dominated rows of misfits (n, kinds)."""
    return feasible_front(misfits, np.zeros((len(misfits), 0)))


def best_row(misfits: np.ndarray) -> int:
    """Return the row of misfits (n, kinds) that stands for the paper: the least over all kinds.

    It is the point of the front that is closest to zero. The knee of `tuner.search.front` scales each objective by how far
    the front happens to reach in it; misfits are ratios and comparable as they are.
    """
    return first_smallest(overall(misfits))
