"""A sensitivity analysis of anything that can be evaluated at points of the unit cube: sample, evaluate in batches, judge."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from plant.seeds import generator
from tuner.analysis.sensitivity.design import SobolDesign, sobol_design
from tuner.analysis.sensitivity.indices import RANK, VALUE, Indices, held_to_completed, ranks, sobol_spans
from tuner.analysis.sensitivity.variance import TwoWay, two_way

Array = np.ndarray
# Points evaluated at once: the meters of 256 candidates in 64 scenarios take some 40 MB.
BATCH = 256


class Sampled(NamedTuple):
    """Results of evaluating n points.

    values (n, q): outputs; failures (n,): share of flights lost; kept (n,): whether a search would fly the candidate, for it
    keeps every hard requirement; scores: for each output (n, flights) what it was made of.
    """

    values: Array
    failures: Array
    kept: Array
    scores: tuple[Array, ...]


@dataclass(frozen=True)
class Analysis:
    """Result of a sensitivity analysis.

    values (n, q), failures (n,), kept (n,): at all points of the design. indices: by scale, of the outputs and then of the share
    of failures. variance: for each output gains against scenarios, over the independent candidates without failures; None where
    there are fewer than two of them or fewer than two flights. candidates: how many those are.
    """

    design: SobolDesign
    values: Array
    failures: Array
    kept: Array
    indices: dict[str, Indices]
    variance: tuple[TwoWay | None, ...]
    candidates: int

    @property
    def failed_share(self) -> float:
        """Share of the samples that lost at least one flight."""
        return float(np.mean(self.failures > 0.0, axis=0))

    @property
    def screened_share(self) -> float:
        """Share of the samples that a search would not fly, for they break a hard requirement."""
        return float(np.mean(~self.kept, axis=0))


def analyse(base: int, dimensions: int, evaluate: Callable[[Array], Sampled], root: int) -> Analysis:
    """Evaluate a design of `base` samples, a power of two, and judge it; every draw follows from the root seed."""
    design = sobol_design(base, dimensions, generator(root, "sensitivity/points", 0))
    values, failures, kept, scores = [], [], [], []
    for first in range(0, len(design.points), BATCH):
        part = evaluate(design.points[first : first + BATCH])
        values.append(part.values)
        failures.append(part.failures)
        kept.append(part.kept)
        # Only A and B are a sample of independent candidates.
        inside = max(min(design.independent - first, BATCH), 0)
        scores.append([entry[:inside] for entry in part.scores])
    return judged(
        design, np.concatenate(values), np.concatenate(failures), np.concatenate(kept),
        [np.concatenate(entry) for entry in zip(*scores, strict=True)], root,
    )  # fmt: skip


def judged(
    design: SobolDesign, values: Array, failures: Array, kept: Array, scores: list[Array], root: int
) -> Analysis:
    """Return the analysis of values (n, q) at a design; scores: for each output those of the independent points (2 base, s)."""
    scales = {RANK: ranks(values), VALUE: held_to_completed(values, failures)}
    # One stream for both scales: the same resamples, so that they differ by the scale alone.
    indices = {
        name: sobol_spans(
            design, np.column_stack([scaled, failures]), generator(root, "sensitivity/bootstrap", 0)
        )
        for name, scaled in scales.items()
    }  # fmt: skip
    complete = failures[: design.independent] == 0.0
    variance = tuple(_decomposed(entry[complete]) for entry in scores)
    return Analysis(design, values, failures, kept, indices, variance, int(complete.sum(axis=0)))


def _decomposed(scores: Array) -> TwoWay | None:
    return two_way(scores) if min(scores.shape) >= 2 else None
