"""What a report knows of a results folder. Objectives, limits and responses are in shown units: angles in degrees."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tuner.documents.parts import Estimate, RecommendedGains
from tuner.documents.resolved import Resolved
from tuner.documents.sensitivity import SensitivityDocument
from tuner.documents.summary import Summary
from tuner.store.environment import Environment

DEFAULT, TUNED = "default", "tuned"


@dataclass(frozen=True)
class ComparedQuantity:
    """One objective or constraint, default against tuned; difference: tuned minus default, paired over scenarios.

    automatic: key of the study that moves a limit which it does not write, else empty.
    """

    label: str
    metric: str
    definition: str
    risk: str
    scenario: str | None
    unit: str
    factor: float
    constrained: bool
    limit: float | None
    default: Estimate
    tuned: Estimate
    difference: Estimate
    verdict: str
    automatic: str = ""


@dataclass(frozen=True)
class Required:
    """One requirement that is known without flying; sense: "most" or "least"; values without intervals, None: infinite.

    Numbers are in `unit`. Numbers of files become those by `factor`, or where `decibel` is set as 20 log10.
    """

    label: str
    quantity: str
    unit: str
    factor: float
    limit: float
    sense: str
    default: Estimate
    tuned: Estimate
    difference: Estimate
    verdict: str
    decibel: bool = False


@dataclass(frozen=True)
class SearchedVariable:
    """One searched gain, in its own unit; symbol and meaning may be empty.

    natural_ends: "low", "high", whichever end of the range cannot be moved.
    """

    name: str
    symbol: str
    meaning: str
    unit: str
    low: float
    high: float
    scale: str
    default: float
    tuned: float
    natural_ends: tuple[str, ...] = ()


@dataclass(frozen=True)
class HeldOutFront:
    """The points flown on held-out scenarios.

    points, roles, candidates (n,); non_dominated, feasible: masks (n,); gains (n, variables); search, held_out, low,
    high (n, objectives). probability (n,): of being non-dominated, None where the folder does not hold it. stored: by
    the names of their columns, values (n, objectives) in the units of the file, where the folder holds them: search, held_out,
    low, high, gap and difference with their ends. requirements (n, requirements): likewise, NaN where not known. lost (n,):
    held-out flights that did not reach their end, 0 where the folder does not tell.
    """

    points: list[str]
    roles: list[str]
    candidates: np.ndarray
    non_dominated: np.ndarray
    feasible: np.ndarray
    gains: np.ndarray
    search: np.ndarray
    held_out: np.ndarray
    low: np.ndarray
    high: np.ndarray
    stored: dict[str, np.ndarray]
    requirements: np.ndarray
    lost: np.ndarray
    probability: np.ndarray | None = None

    def of(self, role: str) -> list[int]:
        """Return the rows with a role, one or none."""
        return [i for i, entry in enumerate(self.roles) if entry == role]

    def role(self, point: str) -> str:
        """Return "default", "tuned" or "" for a point by name."""
        return self.roles[self.points.index(point)] if point in self.points else ""


@dataclass(frozen=True)
class Candidates:
    """Everything the search tried: number (n,), gains (n, variables), values (n, objectives), feasible (n,)."""

    number: np.ndarray
    gains: np.ndarray
    values: np.ndarray
    feasible: np.ndarray


@dataclass(frozen=True)
class History:
    """Progress by generation, each (generations,); all but the shares are cumulative.

    flights_saved, flights_raced: not flown because of requirements, and because a race ended early; None in older folders.
    """

    generation: np.ndarray
    flights: np.ndarray
    seconds: np.ndarray
    feasible_share: np.ndarray
    hypervolume: np.ndarray
    flights_saved: np.ndarray | None = None
    flights_raced: np.ndarray | None = None

    def series(self) -> dict[str, np.ndarray]:
        """Return what is known, by name."""
        return {name: values for name, values in vars(self).items() if values is not None}


@dataclass(frozen=True)
class Loop:
    """One loop of a point at hover: margins as stored, None where unlimited; response (f,) at frequency (f,) [rad/s]."""

    point: str
    channel: str
    stable: bool
    values: dict[str, float | None]
    case: str
    frequency: np.ndarray
    response: np.ndarray


@dataclass(frozen=True)
class Fan:
    """One signal of a point in a scenario: time [s], reference, 5 %, 50 % and 95 % over flights, each (instants,).

    worst: the same signal in the flight in which the point did worst, number `flight` of the held-out ones; None where unknown.
    """

    point: str
    scenario: str
    signal: str
    unit: str
    time: np.ndarray
    reference: np.ndarray
    low: np.ndarray
    median: np.ndarray
    high: np.ndarray
    worst: np.ndarray | None = None
    flight: int | None = None


@dataclass(frozen=True)
class Results:
    """A results folder. summary, resolved, environment, gains: the JSON documents; study: study.toml as given.

    gains_text: gains.json as it stands, or infeasible.json. addresses: gains that each variable stands for. limited: (point,
    constraint) -> value, low, high, and difference to the default with its ends, held out and as stored. start: candidate that is
    the design start, or None. sensitivity: a sensitivity analysis that lies in the folder, or None.
    """

    folder: Path
    summary: Summary
    resolved: Resolved
    environment: Environment
    gains: RecommendedGains
    study: str
    quantities: list[ComparedQuantity]
    requirements: list[Required]
    variables: list[SearchedVariable]
    front: HeldOutFront
    candidates: Candidates
    history: History
    fans: list[Fan]
    gains_text: str
    addresses: dict[str, list[str]]
    limited: dict[tuple[str, str], np.ndarray]
    loops: list[Loop]
    start: int | None
    sensitivity: SensitivityDocument | None

    @cached_property
    def objectives(self) -> list[ComparedQuantity]:
        """The objectives, in the order of the columns of values."""
        return [quantity for quantity in self.quantities if not quantity.constrained]

    @cached_property
    def constraints(self) -> list[ComparedQuantity]:
        """What must not exceed a limit."""
        return [quantity for quantity in self.quantities if quantity.constrained]

    @property
    def tuned(self) -> str:
        """Name of the point beside the default: the recommended one, or the nearest where nothing is feasible."""
        return self.summary.shown

    @property
    def feasible(self) -> bool:
        """Whether anything is recommended."""
        return self.summary.recommends

    @property
    def shown_as(self) -> str:
        """What the point beside the default is called at the head of a column: "tuned" or "nearest"."""
        return self.summary.shown_as

    @property
    def called(self) -> str:
        """What that point is called in a sentence."""
        return "recommended" if self.feasible else "nearest to feasible"

    @property
    def gains_name(self) -> str:
        """Name of the file that `gains_text` is of."""
        return self.summary.gains_file

    @cached_property
    def scenarios(self) -> list[str]:
        """Scenarios with responses, in the order of the study."""
        return list(dict.fromkeys(fan.scenario for fan in self.fans))

    @cached_property
    def flown_points(self) -> list[str]:
        """Points with responses: default first, then tuned, then the others as they come."""
        names = dict.fromkeys(fan.point for fan in self.fans)
        return sorted(names, key=lambda name: (DEFAULT, TUNED, "").index(self.front.role(name)))
