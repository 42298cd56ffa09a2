"""Two-way analysis of variance of a metric: gains, turbulence, and their interaction.

Scores of g candidates through the same s scenarios are a two-way table without replication. With row means r_i, column means c_j
and grand mean m the sums of squares are exact and add up:

    sum (y_ij - m)^2 = s sum (r_i - m)^2 + g sum (c_j - m)^2 + sum (y_ij - r_i - c_j + m)^2

Both gains and scenarios are samples, so the table is one of random effects, and the variance components follow from the mean
squares: interaction = MS_e, gains = (MS_g - MS_e) / s, scenario = (MS_s - MS_e) / g, where a negative estimate counts as 0.
S. R. Searle, G. Casella, C. E. McCulloch, "Variance Components", Wiley, 1992, section 4.3. Unlike shares of the sums of squares,
the components do not depend on the number of scenarios. A flight is deterministic, so the interaction holds no noise.
"""

from typing import NamedTuple

import numpy as np

Array = np.ndarray


class VarianceComponents(NamedTuple):
    """Shares of the variance; they add up to 1, or are all 0 where nothing varies."""

    gains: float
    scenario: float
    interaction: float

    @property
    def turbulence(self) -> float:
        """Share of the turbulence: scenario and interaction."""
        return self.scenario + self.interaction


class TwoWayAnova(NamedTuple):
    """Two-way analysis of variance: sums of squares [unit^2], their shares, and shares of the components."""

    sums: tuple[float, float, float]
    of_squares: VarianceComponents
    of_components: VarianceComponents


def two_way_anova(scores: Array) -> TwoWayAnova:
    """Decompose scores (g, s) of g >= 2 candidates in s >= 2 scenarios."""
    g, s = scores.shape
    assert g >= 2 and s >= 2, "a decomposition needs two candidates and two scenarios"
    # From the first score on, so that equal ones leave nothing, not even rounding.
    scores = scores - scores[0, 0]
    rows, columns = scores.mean(axis=1), scores.mean(axis=0)
    grand = rows.mean(axis=0)
    rest = scores - rows[:, None] - columns + grand
    of_gains = s * float(np.sum((rows - grand) ** 2, axis=0))
    of_scenario = g * float(np.sum((columns - grand) ** 2, axis=0))
    of_rest = float(np.sum(rest**2, axis=(0, 1)))
    within = of_rest / ((g - 1) * (s - 1))
    component_g = max(of_gains / (g - 1) - within, 0.0) / s
    component_s = max(of_scenario / (s - 1) - within, 0.0) / g
    return TwoWayAnova(
        (of_gains, of_scenario, of_rest),
        _shares(of_gains, of_scenario, of_rest),
        _shares(component_g, component_s, within),
    )


def _shares(*parts: float) -> VarianceComponents:
    total = sum(parts)
    return VarianceComponents(*(part / total if total > 0.0 else 0.0 for part in parts))
