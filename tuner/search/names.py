"""Names, purposes and sizes of the searches; without the searches themselves, because importing those is slow."""

from dataclasses import dataclass
from typing import NamedTuple

from plant.errors import InputError, UnknownNameError
from tuner.search.convergence import MIN_GENERATIONS

STARTS = ("default", "design")
AUTOMATIC = "auto"
"""Name of the search that `tuner.search.automatic` chooses."""
# Ends of a search: after so many generations, or before, where its front has come to rest.
GENERATIONS, CONVERGED = "generations", "converged"
STOPS = (GENERATIONS, CONVERGED)


# Flights that the tail of an objective needs at least, for a search fits itself to a single one. On seed 2028 of the figure eight
# the best by the worst of 4 flights had 0.6 of the held-out hypervolume that the best by the worst two of 8 had.
IN_TAIL = 1.5


# A search that grows takes its generations once for each so many gains, twice at least; it ends before, where it has converged.
# Of 6 problems with 6 seeds each, 136 candidates in batches of 8 ended at 0.55 to 0.97 of the best known, these at 0.82 to 1.
GAINS_PER_GROWTH, MIN_GROWTH = 4, 2.0
# Largest number of candidates for which a model was measured to serve.
MAX_CANDIDATES = 1000


class Sizes(NamedTuple):
    """Sizes of a search where a study gives none. first: flights of each scenario that every candidate makes, None for all."""

    population: int
    generations: int
    first: int | None = None

    def grown(self, gains: int) -> "Sizes":
        """Return the sizes for so many gains: at most so many generations, where the search may end before."""
        growth = max(gains / GAINS_PER_GROWTH, MIN_GROWTH)
        most = max(MAX_CANDIDATES // self.population, self.generations)
        return self._replace(generations=min(round(self.generations * growth), most))


@dataclass(frozen=True)
class Algorithm:
    """A search algorithm.

    Attributes:
        about: When to use it, one line.
        min_objectives: Smallest number of objectives that it supports.
        max_objectives: Largest number of objectives that it supports, None without an upper end.
        screens: Whether it checks limits computed without flying before it proposes points.
        grows: Whether its generations grow with the number of gains.
        least_generations: Number of generations from which on it may end where it has converged: after 16 the five seeds of 18
            gains had 0.86 to 0.99 of the best known, after 20 they had 0.88 to 1.
        usual: Its sizes.
        first_of_tail: First flights where the usual ones would leave fewer than `IN_TAIL` of them in the tail of an objective.
    """

    about: str
    min_objectives: int = 1
    max_objectives: int | None = None
    screens: bool = False
    grows: bool = False
    least_generations: int = MIN_GENERATIONS
    usual: Sizes = Sizes(48, 15)
    first_of_tail: int | None = None

    def sizes(self, tail: float, gains: int) -> Sizes:
        """Return its sizes for so many gains; tail: see `tuner.study.search_reading.least_tail`."""
        few = self.usual.first is not None and self.usual.first * tail < IN_TAIL
        sizes = self.usual._replace(first=self.first_of_tail) if self.first_of_tail and few else self.usual
        return sizes.grown(gains) if self.grows else sizes

    @property
    def objectives(self) -> str:
        """The numbers of objectives in words."""
        return f"{self.min_objectives} or more" if self.max_objectives is None else str(self.max_objectives)

    def supports(self, objectives: int) -> bool:
        """Return true where it supports so many objectives."""
        return self.min_objectives <= objectives and (self.max_objectives is None or objectives <= self.max_objectives)


ALGORITHMS = {
    "nsga2": Algorithm("two or three objectives and many candidates"),
    "nsga3": Algorithm("four objectives or more: spreads the front along reference directions", min_objectives=2),
    "age_moea": Algorithm("fronts of unknown curvature: estimates their shape as it goes", min_objectives=2),
    "cmaes": Algorithm("one smooth objective, also with gains that interact", max_objectives=1),
    "differential_evolution": Algorithm("one rugged objective, or several basins", max_objectives=1),
    "gaussian_process": Algorithm(
        "some hundreds of candidates, up to some forty gains: a model picks them",
        screens=True,
        grows=True,
        least_generations=20,
        usual=Sizes(16, 13, first=4),
        first_of_tail=8,
    ),
    "random": Algorithm("the baseline that every other search has to beat"),
    "sobol": Algorithm("a look at the whole space, more evenly filled than at random"),
}


def check_algorithm(name: str, objectives: int) -> None:
    """Raise InputError (key "algorithm") for an unknown search or unsupported number of objectives."""
    if name not in ALGORITHMS:
        raise UnknownNameError("algorithm", name, (AUTOMATIC, *ALGORITHMS), key="algorithm")
    if not ALGORITHMS[name].supports(objectives):
        allowed = ", ".join(sorted(other for other, search in ALGORITHMS.items() if search.supports(objectives)))
        plural = "" if ALGORITHMS[name].max_objectives == 1 else "s"
        raise InputError(
            f"'{name}' supports {ALGORITHMS[name].objectives} objective{plural}, this study has {objectives}; use one of "
            f"{allowed}",
            key="algorithm",
        )
