"""The searches that a study can ask for, by the names of `tuner.search.names`.

A search is imported when it is made: pymoo alone takes 0.5 s, and a run needs one of them.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any

from tuner.search.loop import Search


def _made_by(module: str, name: str) -> Callable[..., Search]:
    """Return what imports a search of a module of this package by its name, and makes it."""

    def made(*told: Any, **known: Any) -> Search:
        return getattr(import_module(f"tuner.search.{module}"), name)(*told, **known)

    return made


SEARCHES: dict[str, Callable[..., Search]] = {
    "nsga2": _made_by("nsga2", "Nsga2"),
    "nsga3": _made_by("nsga3", "Nsga3"),
    "age_moea": _made_by("age_moea", "AgeMoea"),
    "cmaes": _made_by("cmaes", "CmaEs"),
    "differential_evolution": _made_by("differential_evolution", "DifferentialEvolution"),
    "gaussian_process": _made_by("gaussian_process", "GaussianProcess"),
    "random": _made_by("uniform", "Uniform"),
    "sobol": _made_by("sobol", "SobolSequence"),
}
"""name -> search(first, n_objectives, n_constraints, seed).

first: points (n, d) of the first generation, which the first `ask` returns; n is the size of every generation. What a
search asks follows from these four and from what it was told, bit for bit, so a search is resumed by telling a fresh
one again what was recorded. Searches that screen (`tuner.search.names`) take `excesses` too, the longest last:
points (n, d) -> by how much they exceed what is known without flying (n, h), 0 or less where they keep it.
"""
