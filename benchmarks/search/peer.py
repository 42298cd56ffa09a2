"""Searches of other packages behind one protocol: ask a batch of points, tell what they were worth.

Imported in the environments of the peers too, so it needs NumPy alone.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, NamedTuple, Protocol

import numpy as np

Array = np.ndarray


class Search(Protocol):
    """A search over the unit cube, a batch at a time."""

    def ask(self) -> Array:
        """Return the next batch (n, d); an empty one where there is nothing left to ask."""
        ...

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and violations (n, c) of the batch asked for.

        Violations are shares of the limits, 0 where kept. What did not fly has the worst values flown so far.
        """
        ...


class Start(NamedTuple):
    """All that a peer is given.

    first: points (n, d) of its first batch, the very first of which is the default; batch: size of the later ones. objectives,
    limits: numbers of columns of values and of violations; objectives are above 0. seed: of all draws. excess: points (n, d) ->
    by how much they exceed what is known without flying (n, h), 0 or less where they keep it.
    """

    first: Array
    batch: int
    objectives: int
    limits: int
    seed: int
    excess: Callable[[Array], Array]


@dataclass(frozen=True)
class Peer:
    """A search of another package.

    module: where `begun(start, **options)` returns a `Search`; only the environment of the peer can import it. environment: its
    name, "" for that of the tool; requires: what is installed there.
    """

    module: str
    options: dict[str, Any] = field(default_factory=dict)
    environment: str = ""
    requires: tuple[str, ...] = ()

    def begun(self, start: Start) -> Search:
        """Return the search at its beginning."""
        return import_module(self.module).begun(start, **self.options)


# HEBO's pins, with the newest releases that they allow: pip alone looks for them for more than 20 minutes.
HEBO = (
    "HEBO==0.3.6", "numpy==1.24.4", "torch==2.13.0", "scipy==1.12.0", "pandas==2.0.3", "pymoo==0.6.0", "GPy==1.13.2",
    "gpytorch==1.14", "catboost==1.2.5", "scikit-learn==1.3.2",
)  # fmt: skip
OPTUNA = ("optuna==5.0.0", "numpy", "scipy", "cmaes", "torch==2.13.0")
BOTORCH = ("botorch==0.18.1", "numpy", "scipy", "torch==2.13.0")

PEERS = {
    "Optuna TPE": Peer("benchmarks.search.optuna_samplers", {"sampler": "TPESampler"}, "search", OPTUNA + BOTORCH),
    "Optuna NSGA-II": Peer(
        "benchmarks.search.optuna_samplers", {"sampler": "NSGAIISampler"}, "search", OPTUNA + BOTORCH
    ),
    "Optuna GP": Peer("benchmarks.search.optuna_samplers", {"sampler": "GPSampler"}, "search", OPTUNA + BOTORCH),
    "pymoo NSGA-II": Peer("benchmarks.search.pymoo_algorithms", {"algorithm": "NSGA2"}),
    "pymoo AGE-MOEA2": Peer("benchmarks.search.pymoo_algorithms", {"algorithm": "AGEMOEA2"}),
    "BoTorch": Peer("benchmarks.search.botorch_batches", {}, "search", OPTUNA + BOTORCH),
}
PUBLISHED_PEERS = {
    "BoTorch": Peer("benchmarks.search.botorch_continuous", {}, "search", OPTUNA + BOTORCH),
    "HEBO": Peer("benchmarks.search.hebo_optimizer", {}, "hebo", HEBO),
    "SMAC": Peer("benchmarks.search.smac_facade", {}, "smac", ("smac==2.4.1", "numpy")),
    "NOMAD": Peer("benchmarks.search.nomad_mads", {}, "nomad", ("PyNomadBBO==4.6.0", "numpy")),
}
"""Peers of the published problems alone, which give signed constraint values and negative objectives."""
"""Peers by name; a further one is an entry here and one in `benchmarks.search.contestants`."""
