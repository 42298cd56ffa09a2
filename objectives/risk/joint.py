"""Joint resamples of the scenarios, for all candidates and quantities.

Candidates fly through the same scenarios, so their risks rise and fall together: resampled jointly, the differences between
candidates, and which of them dominates which, are as sure as the flights allow. Scenarios of each name are resampled among
themselves, because how many there are of each was fixed and not drawn (a stratified bootstrap: A. C. Davison, D. V.
Hinkley, "Bootstrap Methods and their Application", Cambridge University Press, 1997, section 3.2).
"""

import numpy as np

from objectives.risk.bootstrap import Indices


def resampled_scenarios(rng: np.random.Generator, replicates: int, origin: np.ndarray) -> Indices:
    """Return flight indices (replicates, flights), resampled within scenarios; origin (flights,)."""
    drawn = np.empty((replicates, len(origin)), dtype=np.intp)
    for name in np.unique(origin):
        places = np.flatnonzero(origin == name)
        drawn[:, places] = places[rng.integers(len(places), size=(replicates, len(places)))]
    return drawn


def within(drawn: Indices, origin: np.ndarray, scenario: str | None) -> Indices:
    """Return a scenario's part of a resample (replicates, flights), indexed within it; all for None."""
    if scenario is None:
        return drawn
    places = np.flatnonzero(origin == scenario)
    if len(places) == len(origin):
        return drawn
    index = np.zeros(len(origin), dtype=np.intp)
    index[places] = np.arange(len(places))
    return index[drawn[:, places]]
