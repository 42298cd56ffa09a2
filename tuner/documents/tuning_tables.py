"""Tables of a tuning run's folder as arrays."""

from dataclasses import dataclass
from math import isnan
from pathlib import Path

import numpy as np

from objectives.margins.quantities import RECORDED, REPORTED
from plant.ties import increasing_order
from tuner.store.tables import TableFile

LOOP_TEXTS, LOOP_LISTS = ("point", "channel", "case"), ("frequency", "real", "imag")
# Margin quantities of each loop that a reader of a report is shown.
LOOP_MARGINS = [name for name in REPORTED if name in RECORDED]


@dataclass(frozen=True)
class HeldOutFront:
    """The points flown on held-out scenarios.

    points, roles, candidates (n,); gains (n, variables); search, held_out, low, high (n, objectives). stored: by the names of
    their columns, values (n, objectives) in the units of the file, where the folder holds them: search, held_out, low, high, gap
    and difference with their ends. requirements (n, requirements): likewise, NaN where not known. columns: those of
    FINALIST_COLUMNS that the folder holds, by name, each (n,).
    """

    points: list[str]
    roles: list[str]
    candidates: np.ndarray
    gains: np.ndarray
    search: np.ndarray
    held_out: np.ndarray
    low: np.ndarray
    high: np.ndarray
    stored: dict[str, np.ndarray]
    requirements: np.ndarray
    columns: dict[str, np.ndarray]

    @property
    def non_dominated(self) -> np.ndarray:
        """Mask of the points that are on the front."""
        return self.columns["non_dominated"]

    @property
    def feasible(self) -> np.ndarray:
        """Mask of the points that keep every limit."""
        return self.columns["feasible"]

    @property
    def lost(self) -> np.ndarray:
        """Held-out flights of each point that did not reach their end; 0 where the folder does not tell."""
        return self.columns["lost"]

    @property
    def shown_rows(self) -> list[int]:
        """Rows of the default, of the point next to it and of the front, by the first objective."""
        shown = np.array([bool(role) for role in self.roles]) | (self.non_dominated & self.feasible)
        return [int(i) for i in increasing_order(self.held_out[:, 0]) if shown[i]]

    def of(self, role: str) -> list[int]:
        """Return the rows with a role, one or none."""
        return [i for i, entry in enumerate(self.roles) if entry == role]

    @property
    def recommended(self) -> int:
        """The row of the recommended point: the default if that is the answer."""
        return [*self.of("tuned"), *self.of("default")][0]

    def role(self, point: str) -> str:
        """Return "default", "tuned" or "" for a point by name."""
        return self.roles[self.points.index(point)] if point in self.points else ""


@dataclass(frozen=True)
class Candidates:
    """Everything the search tried: number (n,), gains (n, variables), values (n, objectives) as shown, feasible (n,).

    requirements (n, requirements): limits that are known without flying, as in files; NaN where a folder does not have them.
    """

    number: np.ndarray
    gains: np.ndarray
    values: np.ndarray
    feasible: np.ndarray
    requirements: np.ndarray


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
        """Return the series that the folder holds, by name."""
        return {name: values for name, values in vars(self).items() if values is not None}


@dataclass(frozen=True)
class Loop:
    """One loop of a point: margins as stored, and its curve.

    The response (f,) is at frequency (f,) [rad/s]. A value is None where unlimited. The state is the steady state that it is
    in, "" for hover or the equilibrium of a plant.
    """

    point: str
    channel: str
    stable: bool
    values: dict[str, float | None]
    case: str
    frequency: np.ndarray
    response: np.ndarray
    state: str = ""


def read_loops(file: Path) -> list[Loop]:
    """Return the margins and curves of a table of margins."""
    table = TableFile(file)
    frequency, real, imag = (table.numbers(name, rows=True) for name in LOOP_LISTS)
    point, channel, case = (table.coded(name).texts() for name in LOOP_TEXTS)
    values = {name: table.numbers(name).tolist() for name in LOOP_MARGINS}
    stable = table.numbers("stable").tolist()
    states = table.coded("state").texts() if "state" in table.names else [""] * len(point)
    return [
        Loop(
            point[k],
            channel[k],
            bool(stable[k]),
            {name: None if isnan(column[k]) else column[k] for name, column in values.items()},
            case[k],
            frequency[k],
            real[k] + 1j * imag[k],
            states[k],
        )
        for k in range(len(point))
    ]
