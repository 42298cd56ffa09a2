"""The search for a study that asks for none: a model where candidates are few, evolution where they are many."""

from typing import NamedTuple

from tuner.search.names import MAX_CANDIDATES, Sizes

MODEL = "gaussian_process"
# Sizes for which a model was measured to be ahead; beyond, its computing time outgrows that of the flights it saves. Of four
# objectives its front had 0.94 of the best known after 144 candidates of RE41 (nsga3: 0.66), 0.82 of DTLZ7 (0), 0.96 of DTLZ5
# (0.90) and 0.88 of DTLZ2 (0.92), means of three seeds.
MAX_GAINS, MAX_OBJECTIVES = 40, 4


class AlgorithmChoice(NamedTuple):
    """A search by its name, and the reason."""

    algorithm: str
    why: str


def automatic(gains: int, objectives: int, candidates: int) -> AlgorithmChoice:
    """Return the search for so many gains, objectives and candidates."""
    beyond = [
        f"{count:,} {noun} are more than the {most:,} that a model was measured to serve"
        for count, most, noun in (
            (gains, MAX_GAINS, "gains"),
            (objectives, MAX_OBJECTIVES, "objectives"),
            (candidates, MAX_CANDIDATES, "candidates"),
        )
        if count > most
    ]
    if beyond:
        return AlgorithmChoice(_evolution(objectives), beyond[0])
    size = f"{_counted(gains, 'gain')}, {_counted(objectives, 'objective')} and {candidates:,} candidates"
    return AlgorithmChoice(MODEL, f"Bayesian optimization, the most sample-efficient choice for {size}")


def _evolution(objectives: int) -> str:
    """Return the evolutionary search for a number of objectives."""
    if objectives == 1:
        return "cmaes"
    return "nsga2" if objectives <= 3 else "nsga3"


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def candidates_of(usual: Sizes, population: int | None, generations: int | None) -> int:
    """Return the number of candidates of a search; None: its usual number."""
    return (population or usual.population) * (generations or usual.generations)
