"""The searches that a study can ask for, by the names of `tuner.search.names`."""

from collections.abc import Callable

from tuner.search.age_moea import AgeMoea
from tuner.search.cmaes import CmaEs
from tuner.search.differential_evolution import DifferentialEvolution
from tuner.search.gaussian_process import GaussianProcess
from tuner.search.loop import Search
from tuner.search.nsga2 import Nsga2
from tuner.search.nsga3 import Nsga3
from tuner.search.sobol import SobolSequence
from tuner.search.uniform import Uniform

SEARCHES: dict[str, Callable[..., Search]] = {
    "nsga2": Nsga2,
    "nsga3": Nsga3,
    "age_moea": AgeMoea,
    "cmaes": CmaEs,
    "differential_evolution": DifferentialEvolution,
    "gaussian_process": GaussianProcess,
    "random": Uniform,
    "sobol": SobolSequence,
}
"""name -> search(first, n_objectives, n_constraints, seed).

first: points (n, d) of the first generation, which the first `ask` returns; n is the size of every generation. What a
search asks follows from these four and from what it was told, bit for bit, so a search is resumed by telling a fresh
one again what was recorded. Searches that screen (`tuner.search.names`) take `excess` too: points (n, d) -> by how much
they exceed what is known without flying (n, h), 0 or less where they keep it.
"""
