"""The searches that play the suite: the tool's, and peers as they come, each with its batch and its limit of processor time."""

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.search.peer import PEERS, PUBLISHED_PEERS, Array, Peer, Search, Start
from benchmarks.search.process import PeerProcess
from benchmarks.search.published.play import STEP, SearchFactory
from tuner.search.bayesian_optimization import BayesianOptimization
from tuner.search.sobol import SobolSequence

# Name of the tool's search on the command line; a document names its revision too.
OURS = "ours"


class ClippedViolations:
    """The tool's search as runs used it until f52a461d: without the slack of constraints that are satisfied."""

    def __init__(self, first: Array, n_objectives: int, n_constraints: int, seed: int) -> None:
        self._search = BayesianOptimization(first, n_objectives, n_constraints, seed)

    def ask(self) -> Array:
        """Return the next batch (n, d)."""
        return self._search.ask()

    def tell(self, values: Array, violations: Array) -> None:
        """Tell objectives (n, m) and constraint values (n, c) of the batch."""
        self._search.tell(values, np.maximum(violations, 0.0))


@dataclass(frozen=True)
class PublishedContestant:
    """A search.

    Attributes:
        search: The tool's search or a peer.
        batch: Evaluations of later batches.
        max_seconds: Processor seconds after which a run is stopped.
        objectives: Least and largest number of objectives.
        constrained: Whether it takes constraints.
    """

    search: SearchFactory | Peer
    batch: int = STEP
    max_seconds: float = 60.0
    objectives: tuple[int, int] = (1, 9)
    constrained: bool = True

    def is_suited(self, n_objectives: int, n_constraints: int) -> bool:
        """Return True if it takes so many objectives and constraints."""
        least, most = self.objectives
        return least <= n_objectives <= most and (self.constrained or not n_constraints)

    def start(
        self, stack: ExitStack, envs: Path, first: Array, n_objectives: int, n_constraints: int, seed: int
    ) -> Search:
        """Return the search at its beginning; a peer of another environment has a process, which the stack ends."""
        if not isinstance(self.search, Peer):
            return self.search(first, n_objectives, n_constraints, seed)
        start = Start(first, self.batch, n_objectives, n_constraints, seed, lambda points: np.empty((len(points), 0)))
        if not self.search.environment:
            return self.search.begun(start)
        return stack.enter_context(PeerProcess(self.search, start, envs))


CONTESTANTS = {
    OURS: PublishedContestant(BayesianOptimization),
    f"{OURS} without slack": PublishedContestant(ClippedViolations),
    "Sobol": PublishedContestant(SobolSequence),
    "pymoo NSGA-II": PublishedContestant(PEERS["pymoo NSGA-II"]),
    "pymoo AGE-MOEA2": PublishedContestant(PEERS["pymoo AGE-MOEA2"], objectives=(2, 9)),
    "Optuna TPE": PublishedContestant(PEERS["Optuna TPE"], batch=1),
    "Optuna GP": PublishedContestant(PEERS["Optuna GP"], batch=1),
    "NOMAD": PublishedContestant(PUBLISHED_PEERS["NOMAD"], batch=1, objectives=(1, 2)),
    "SMAC": PublishedContestant(PUBLISHED_PEERS["SMAC"], batch=1, constrained=False),
    "HEBO": PublishedContestant(PUBLISHED_PEERS["HEBO"]),
    "BoTorch": PublishedContestant(PUBLISHED_PEERS["BoTorch"], batch=4, max_seconds=120.0),
}
