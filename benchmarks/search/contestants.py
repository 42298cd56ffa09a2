"""The contestants: the tool's searches as a study asks for them, and the peers; what each knows, and how long it may take."""

from dataclasses import dataclass, field
from typing import Any, Literal

from benchmarks.search.peer import PEERS, Peer

CHEAP, COSTLY = 3000, 1000
AUTO = "auto"
# Earlier revisions whose default is raced in clones of them, and the one that the default is compared with.
REVISIONS = ("f52a461d", "1657a4b6")
BEFORE = f"{AUTO} at {REVISIONS[0]}"
TOLD = "margins: told once it asked, for no flight; reference point: none"
ASKS = "margins: asks before it proposes; reference point: from the default, its first candidate"
BLIND = "margins: told for no flight, and uses nothing that it is told"


@dataclass(frozen=True)
class Contestant:
    """A search, its budget and what it knows.

    overrides: of the study; peer: the search, where it is of another package. first: candidates of the common start that are the
    first batch of a peer; batch: later ones. A search of the tool takes the generations of its study. most_flights, most_seconds:
    after which it is stopped, the latter of a processor. objectives: fewest and most that it takes. family: of its line in the
    figure; "reference" is a long run, which only serves to find the best known. is_of_clone: whether a clone of an earlier
    revision races it, see `--before`.
    """

    knows: str
    family: Literal["tool", "peer", "baseline", "reference"]
    overrides: dict[str, Any] = field(default_factory=dict)
    peer: Peer | None = None
    first: int = 32
    batch: int = 32
    most_flights: int = CHEAP
    most_seconds: float = 30.0
    objectives: tuple[int, int] = (1, 9)
    is_of_clone: bool = False

    def takes(self, objectives: int) -> bool:
        """Return whether it searches for so many objectives."""
        return not self.is_of_clone and self.objectives[0] <= objectives <= self.objectives[1]


def own(algorithm: str, population: int, scenarios: int, knows: str, family: Any = "tool", **more: Any) -> Contestant:
    """Return a search of the tool without races."""
    search = {"algorithm": algorithm, "population": population, "generations": 1000, "racing": False}
    return Contestant(knows, family, {"search": search, "scenario.0.search": scenarios}, **more)


def other(name: str, knows: str = TOLD, **more: Any) -> Contestant:
    """Return a peer, 4 flights a candidate."""
    return Contestant(knows, "peer", {"scenario.0.search": 4}, PEERS[name], **more)


# The search of a study whose [search] is empty.
DEFAULT = {"search": {"algorithm": "auto"}}
CONTESTANTS = {
    AUTO: Contestant(ASKS, "tool", DEFAULT, most_flights=30_000, most_seconds=120.0),
    **{f"{AUTO} at {revision}": Contestant(ASKS, "tool", DEFAULT, is_of_clone=True) for revision in REVISIONS},
    "nsga2": own("nsga2", 32, 4, TOLD),
    "cmaes": own("cmaes", 12, 4, TOLD, objectives=(1, 1)),
    "Optuna TPE": other("Optuna TPE", first=8, batch=1, most_seconds=40.0),
    "Optuna NSGA-II": other("Optuna NSGA-II"),
    "Optuna GP": other("Optuna GP", first=8, batch=1, most_flights=COSTLY, most_seconds=40.0),
    "pymoo NSGA-II": other("pymoo NSGA-II"),
    "pymoo AGE-MOEA2": other("pymoo AGE-MOEA2", objectives=(2, 9)),
    "BoTorch qLogNEHVI, qLogEI": other(
        "BoTorch", "margins: asks before it proposes; reference point: given", first=8, batch=8, most_flights=500,
        most_seconds=200.0,
    ),
    "random": own("random", 32, 4, BLIND, "baseline", most_seconds=8.0),
    "sobol": own("sobol", 32, 4, BLIND, "baseline", most_seconds=8.0),
    "long gaussian_process": own(
        "gaussian_process", 32, 8, ASKS, "reference", most_flights=6000
    ),
    "long nsga2": own("nsga2", 64, 8, TOLD, "reference", most_flights=30_000),
    "long age_moea": own("age_moea", 64, 8, TOLD, "reference", most_flights=32_000, most_seconds=120.0, objectives=(2, 9)),
}  # fmt: skip
