"""All settings that were flown: medians of cells and of ratios between contenders, and where the published values stand."""

from dataclasses import dataclass

import numpy as np

from tuner.experiments.inference.misfit import is_inside, misfits, overall, percentile
from tuner.search.front import feasible_front
from tuner.study.inference import Inference

LOCAL_REFINEMENT = -1
# Share of a published value that stands for 0 in a ratio.
RATIO_FLOOR = 1e-6


@dataclass(frozen=True)
class EvaluatedSettings:
    """Settings in the order they were flown.

    values (n, unknowns). origin (n,): number of the generation, LOCAL_REFINEMENT for those flown around the best. median,
    percentile (n, cells): of the flights, and where in them the published value stands. ratio, ratio_percentile (n, ratios): the
    same of the ratios between contenders, flight by flight. failures (n, cells): share of flights that failed.
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
        """Whether each published value could be one of the flights (n, cells)."""
        return is_inside(self.percentile)

    @property
    def ratio_inside(self) -> np.ndarray:
        """Whether each published ratio between contenders could be that of one of the flights (n, ratios)."""
        return is_inside(self.ratio_percentile)


def evaluate_settings(
    inference: Inference, values: np.ndarray, origin: int, scores: np.ndarray, failed: np.ndarray
) -> EvaluatedSettings:
    """Return what is kept of the scores and failed (n, cells, flights) of settings (n, unknowns)."""
    ratios = ratio_scores(inference, scores)
    return EvaluatedSettings(
        values, np.full(len(values), origin), np.median(scores, axis=-1), percentile(scores, inference.published),
        np.median(ratios, axis=-1), percentile(ratios, published_ratios(inference)), failed.mean(axis=-1),
    )  # fmt: skip


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
    return int(np.argmin(overall(misfits)))
