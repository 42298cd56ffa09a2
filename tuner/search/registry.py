"""Searches that a study can name, by the names of `tuner.search.names`.

A search is imported when it is made: pymoo alone takes 0.5 s, and a run needs one of them.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from tuner.search.loop import Search


def _made_by(module: str, name: str) -> Callable[..., Search]:
    """Return a constructor that imports a search of this package when called."""

    def construct(*args: Any, **kwargs: Any) -> Search:
        return getattr(import_module(f"tuner.search.{module}"), name)(*args, **kwargs)

    return construct


SEARCHES: dict[str, Callable[..., Search]] = {
    "nsga2": _made_by("nsga2", "Nsga2"),
    "nsga3": _made_by("nsga3", "Nsga3"),
    "age_moea": _made_by("age_moea", "AgeMoea"),
    "cmaes": _made_by("cmaes", "CmaEs"),
    "differential_evolution": _made_by("differential_evolution", "DifferentialEvolution"),
    "gaussian_process": _made_by("bayesian_optimization", "BayesianOptimization"),
    "random": _made_by("uniform", "Uniform"),
    "sobol": _made_by("sobol", "SobolSequence"),
}
"""name -> search(first, n_objectives, n_constraints, seed).

first: points (n, d) of the first generation, which the first `ask` returns; n is the size of every generation. The points of a
search follow from these four and from the recorded results, bit for bit, so a search is resumed by replaying these. Searches that
screen (`tuner.search.names`) take `excesses` too, the longest last: points (n, d) -> excess (n, h) over the limits computed
without flying, 0 or less where they hold; and `reference` (m,): objectives up to which the front is searched, NaN where front and
default decide.
"""
