"""Sensitivity analysis of any function on the unit cube: sample, evaluate in batches, estimate."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from plant.seeds import generator
from tuner.extensions.sensitivity.design import SobolDesign, sobol_design
from tuner.extensions.sensitivity.indices import RANK, VALUE, Indices, clip_to_completed, ranks, sobol_spans
from tuner.extensions.sensitivity.variance import TwoWayAnova, two_way_anova

Array = np.ndarray
# Points evaluated at once: the meters of 256 candidates in 64 scenarios take some 40 MB.
BATCH = 256


class Sampled(NamedTuple):
    """Results of evaluating n points.

    Attributes:
        values (n, q): Outputs.
        failures (n,): Share of failed flights.
        passes_screening (n,): Mask of candidates that satisfy every hard requirement, so that a search would fly them.
        scores: Scores of the flights (n, flights) for each output.
    """

    values: Array
    failures: Array
    passes_screening: Array
    scores: tuple[Array, ...]


@dataclass(frozen=True)
class Analysis:
    """Result of a sensitivity analysis.

    Attributes:
        values (n, q), failures (n,), passes_screening (n,): At all points of the design.
        indices: Indices by scale, for the outputs and then for the share of failures.
        variance: Variance of each output, gains against scenarios, over the independent candidates without failures; None where
            there are fewer than two of them or fewer than two flights.
        candidates: Their number.
    """

    design: SobolDesign
    values: Array
    failures: Array
    passes_screening: Array
    indices: dict[str, Indices]
    variance: tuple[TwoWayAnova | None, ...]
    candidates: int

    @property
    def failed_share(self) -> float:
        """Share of the samples that lost at least one flight."""
        return float(np.mean(self.failures > 0.0, axis=0))

    @property
    def screened_share(self) -> float:
        """Share of the samples that fail pre-screening by a hard requirement."""
        return float(np.mean(~self.passes_screening, axis=0))


def analyze(base: int, dimensions: int, evaluate: Callable[[Array], Sampled], root: int) -> Analysis:
    """Analyze a function by a design of `base` samples: a power of two; seeds follow from the root."""
    design = sobol_design(base, dimensions, generator(root, "sensitivity/points", 0))
    values, failures, passes_screening, scores = [], [], [], []
    for first in range(0, len(design.points), BATCH):
        part = evaluate(design.points[first : first + BATCH])
        values.append(part.values)
        failures.append(part.failures)
        passes_screening.append(part.passes_screening)
        # Only A and B are a sample of independent candidates.
        inside = max(min(design.independent - first, BATCH), 0)
        scores.append([entry[:inside] for entry in part.scores])
    return estimate(
        design,
        np.concatenate(values),
        np.concatenate(failures),
        np.concatenate(passes_screening),
        [np.concatenate(entry) for entry in zip(*scores, strict=True)],
        root,
    )


def estimate(
    design: SobolDesign, values: Array, failures: Array, passes_screening: Array, scores: list[Array], root: int
) -> Analysis:
    """Return the analysis of values (n, q) at a design; scores: for each output those of the independent points (2 base, s)."""
    scales = {RANK: ranks(values), VALUE: clip_to_completed(values, failures)}
    # One stream for both scales: the same resamples, so that they differ by the scale alone.
    indices = {
        name: sobol_spans(design, np.column_stack([scaled, failures]), generator(root, "sensitivity/bootstrap", 0))
        for name, scaled in scales.items()
    }
    complete = failures[: design.independent] == 0.0
    tables = [entry[complete] for entry in scores]
    variance = tuple(two_way_anova(table) if min(table.shape) >= 2 else None for table in tables)
    return Analysis(design, values, failures, passes_screening, indices, variance, int(complete.sum(axis=0)))
