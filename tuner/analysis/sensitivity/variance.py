"""How much of the variance of a metric is gains, how much is the air, and how much is gains that answer the same air differently.

Scores of g candidates through the same s scenarios are a two-way table without replication. With row means r_i, column means c_j
and grand mean m the sums of squares are exact and add up:

    sum (y_ij - m)^2 = s sum (r_i - m)^2 + g sum (c_j - m)^2 + sum (y_ij - r_i - c_j + m)^2

Both gains and scenarios are samples, so the table is one of random effects, and the variance components follow from the mean
squares: interaction = MS_e, gains = (MS_g - MS_e) / s, scenario = (MS_s - MS_e) / g, where a negative estimate counts as 0.
S. R. Searle, G. Casella, C. E. McCulloch, "Variance Components", Wiley, 1992, section 4.3. Unlike shares of the sums of squares
the components do not depend on how many scenarios were flown; without replication they cannot tell interaction from noise, but a
flight has no noise of its own: gains and scenario decide it.
"""

from typing import NamedTuple

import numpy as np

Array = np.ndarray


class Shares(NamedTuple):
    """Shares of a whole; they add up to 1, or are all 0 where nothing varies."""

    gains: float
    scenario: float
    interaction: float

    @property
    def turbulence(self) -> float:
        """What would not be there in one and the same air: scenario and interaction."""
        return self.scenario + self.interaction


class TwoWay(NamedTuple):
    """Sums of squares in the metric's unit squared, shares of their total, and shares of the variance components."""

    sums: tuple[float, float, float]
    of_squares: Shares
    of_components: Shares


def two_way(scores: Array) -> TwoWay:
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
    return TwoWay(
        (of_gains, of_scenario, of_rest),
        _shares(of_gains, of_scenario, of_rest),
        _shares(component_g, component_s, within),
    )


def _shares(*parts: float) -> Shares:
    whole = sum(parts)
    return Shares(*(part / whole if whole > 0.0 else 0.0 for part in parts))
