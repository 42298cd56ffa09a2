"""A study that searches for gains of a flown system."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NotRequired, Self, TypedDict

import numpy as np

from objectives.flown_system import FlownSystem
from objectives.problem import Constraint
from objectives.requirements import Requirement, Screen, requirements_of
from plant.quadrotor.gains import MAX_BANDWIDTH_PERIODS
from plant.texts import PlainTable
from tuner.gains.document import seed_entry
from tuner.study.searched import Followed, SearchedStudy, VariableWords
from tuner.text.markup import element, table

if TYPE_CHECKING:
    from objectives.margins.loop_margins import LoopMargins


class Origin(TypedDict):
    """Origin of gains, as gains.json holds it.

    seed: a text where a double does not hold it; feasible: only where it is False.
    """

    name: str
    title: str
    seed: int | str
    digest: str
    point: str
    feasible: NotRequired[bool]


@dataclass(frozen=True, kw_only=True)
class TuningStudy(SearchedStudy):
    """A study that searches for gains of a system.

    Args:
        system: Flies it.
        screens: Requirements that are known without flying.
        si: Whether limits known without flying stand in files in SI units, see `in_units_of_limits`.
    """

    kind: ClassVar[str] = "tuning"
    period_key: ClassVar[str] = "controller.control_period"
    """Key of gains.json that holds the control period."""
    flies: ClassVar[str] = "a quadrotor"
    """Noun of its plant, with its article."""
    limit_tables: ClassVar[str] = "a [[guarantee]] or a [[margin]]"
    """Tables of limits that are known without flying."""
    is_reread: ClassVar[bool] = True
    """Whether another process may read it again to compile its margins."""
    system: FlownSystem
    screens: tuple[Screen, ...]
    si: bool = True

    @property
    def automatic_limits(self) -> tuple[Constraint, ...]:
        """Limits that the study does not write, see `objectives.mission`."""
        return tuple(entry for entry in self.constraints if entry.floor)

    @property
    def variable_words(self) -> list[VariableWords]:
        """Symbol, meaning and unit of each searched gain; of tied ones that of the first."""
        gains = self.system.gains
        first = [gains[columns[0]] for columns in self.space.columns]
        return [VariableWords(gain.info.symbol, gain.info.meaning, gain.unit) for gain in first]

    @property
    def requirements(self) -> tuple[Requirement, ...]:
        """Requirements on the gains that are known without flying."""
        return requirements_of(self.screens)

    def resolved(self) -> PlainTable:
        """Return every value of the study as JSON-able data.

        Defaults, airframe numbers and measured limits are included.
        """
        rows = [
            {
                "label": entry.label,
                "quantity": entry.quantity,
                **entry.units(),
                "limit": entry.in_file(entry.limit),
                "sense": entry.sense,
                "hard": entry.hard,
            }
            for entry in self.requirements
        ]
        values = super().resolved()
        digest = values.pop("digest")
        return {**values, "requirements": rows, "digest": digest}

    def in_units_of_limits(self) -> Self:
        """Return the study with requirements in the units of limits, not SI.

        Numbers then stand in files as in the study, as folders once held them.
        """
        plain = tuple(
            replace(screen, requirements=tuple(replace(entry, scale=None) for entry in screen.requirements))
            for screen in self.screens
        )
        return replace(self, screens=plain, si=False)

    def origin(self, point: str) -> Origin:
        """Return the origin of a point's gains, as gains.json holds it."""
        return {
            "name": self.path.name,
            "title": self.title,
            "seed": seed_entry(self.seed),
            "digest": self.digest(),
            "point": point,
        }

    @property
    def about(self) -> tuple[tuple[str, str], ...]:
        """The plant and its laws, in a few words each."""
        raise NotImplementedError

    @property
    def followed(self) -> list[Followed]:
        """Channels that follow references, alike in all contenders of a contest; none of a quadrotor, whose axes are fixed."""
        return []

    @property
    def law_text(self) -> str:
        """The law of each loop, in words."""
        return ", ".join(f"{law.name} ({name})" for name, law in self.system.laws.items())

    @property
    def flown(self) -> str:
        """Name of the airframe or of the plant."""
        raise NotImplementedError

    @property
    def notes(self) -> list[str]:
        """Sentences on its vehicle that a person reads before a run."""
        return []

    @property
    def is_resumable(self) -> bool:
        """True if all flown parts come from files, for extension of runs."""
        return True

    def is_natural_end(self, variable: int, bound: float) -> bool:
        """Return True if an end of a variable's range is fixed.

        The gain is meaningless beyond it, or the observer would outrun the control period.
        """
        info, period = self.system.gains[self.space.columns[variable][0]].info, self.system.timing.control_period
        return bound <= info.least or (info.observer and bound * period >= MAX_BANDWIDTH_PERIODS * (1.0 - 1e-9))

    def censored_times(self) -> list[list[float]]:
        """Return by objective and scenario the time [s] of a missed event.

        The time represents an event that a flight did not come to.
        """
        times = []
        for objective in self.objectives:
            metric = objective.metric.metric
            seen = [entry.spec for entry in self.scenarios if objective.scenario in (None, entry.spec.name)]
            windows = [
                min(
                    getattr(getattr(targets, axis), metric.window) if metric.window else 0.0
                    for axis in objective.metric.axes or targets._fields
                )
                for spec, targets in ((spec, self.system.targets(spec)) for spec in seen)
            ]
            left = [spec.duration - begin for spec, begin in zip(seen, windows, strict=True)]
            times.append(left if metric.censored is not None else [])
        return times

    def margin_model(self, state: str | None = None) -> "LoopMargins":
        """Return the margins of its loop; InputError where there is no steady flight.

        state: name of a steady state in which its margins are judged, by default hover.
        """
        raise NotImplementedError

    def read_row(self, file: Path) -> np.ndarray:
        """Return the gains row (gains,) of a file of its controller; InputError names all that differs."""
        raise NotImplementedError

    def gains_document(self, row: np.ndarray, parts: PlainTable) -> PlainTable:
        """Return the content of gains.json for a gains row (gains,) with its parts: study, objectives, margins."""
        raise NotImplementedError

    def controller(self, gains: Iterable[float]) -> Any:
        """Return its controller with a gains row."""
        raise NotImplementedError

    def row_of(self, controller: Any, file: Path) -> np.ndarray:
        """Return the gains row (gains,) of a controller of its kind; file: gives it."""
        raise NotImplementedError

    def under(self, controller: Any, file: Path) -> Self:
        """Return the study under another controller; InputError, naming its file, where that does not fit."""
        raise NotImplementedError

    def _repr_html_(self) -> str:
        rows = (
            *self.about,
            ("searched", ", ".join(variable.name for variable in self.space.variables)),
            ("scenarios", ", ".join(entry.spec.name for entry in self.scenarios)),
            ("objectives", ", ".join(entry.label for entry in self.objectives)),
            (
                "limits",
                ", ".join([entry.objective.label for entry in self.constraints] + [e.label for e in self.requirements]),
            ),
            ("search", f"{self.search.algorithm}, {self.search.size}"),
        )
        return element("div", element("strong", self.title), table(("", f"seed {self.seed}"), rows))
