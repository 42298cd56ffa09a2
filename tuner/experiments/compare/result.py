"""All that a comparison found."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np

from tuner.documents.comparison_document import BoundRow, StepCost
from tuner.experiments.compare.cost import step_cost
from tuner.experiments.compare.flying import ComparedPoint, Flown, PreparedContender
from tuner.experiments.compare.fronts import Best, Front, Volumes, best_under, front_of, volumes_of
from tuner.experiments.compare.statistics import Comparison, compare_all
from tuner.experiments.tuning.bounds import on_bounds
from tuner.study.comparison import ComparisonStudy


@dataclass(frozen=True)
class Result:
    """A comparison with its contenders' gains, flights and results; lists run over the contenders.

    Attributes:
        flown: The points compared.
        flights: Number of flights of all searches and of the comparison.
        fronts: Fronts, empty where no contender was tuned.
        volumes: Hypervolumes, None where no contender was tuned.
        best_under: Best points under levels, empty where no contender was tuned.
    """

    study: ComparisonStudy
    prepared: list[PreparedContender]
    flown: Flown
    flights: int
    comparison: Comparison
    fronts: list[Front]
    volumes: Volumes | None
    best_under: list[Best]
    costs: list[StepCost]
    bounds: list[list[BoundRow]]
    seconds: float

    @cached_property
    def names(self) -> list[str]:
        """Names of the contenders."""
        return [contender.name for contender in self.study.contenders]

    @property
    def entries(self) -> list[ComparedPoint]:
        """The points compared."""
        return [entrant.entry for entrant in self.prepared]

    @classmethod
    def of(
        cls, study: Any, prepared: list[PreparedContender], groups: Sequence[Flown], seconds: float, **further: Any
    ) -> Self:
        """Return everything that follows from the flights of `groups_of`; further: fields of a subclass."""
        flown, *behind = groups
        objectives, relevant = study.base.objectives, study.base.table.relevant
        has_fronts = any(entrant.offered is not None for entrant in prepared)
        fronts = _fronts(study, prepared, flown, behind) if has_fronts else []
        return cls(
            study=study,
            prepared=prepared,
            flown=flown,
            flights=sum(entrant.flights for entrant in prepared) + sum(group.failed.size for group in groups),
            comparison=compare_all(flown, study.quantities, study.seed, relevant),
            fronts=fronts,
            volumes=volumes_of(fronts, objectives, flown.origin, study.seed, relevant) if fronts else None,
            best_under=best_under(fronts, len(objectives)) if fronts else [],
            costs=[step_cost(contender.study.system) for contender in study.contenders],
            bounds=[
                on_bounds(
                    entrant.contender.study, entrant.entry.row, np.array([entry.row for entry in entrant.offered])
                )
                if entrant.offered is not None
                else []
                for entrant in prepared
            ],
            seconds=seconds,
            **further,
        )


def groups_of(prepared: Sequence[PreparedContender]) -> list[list[ComparedPoint]]:
    """Return the points to fly: those compared, then the front of each contender."""
    return [[entrant.entry for entrant in prepared], *[entrant.offered or [] for entrant in prepared]]


def _fronts(
    study: ComparisonStudy, prepared: list[PreparedContender], flown: Flown, behind: list[Flown]
) -> list[Front]:
    """Return the fronts of all; who has none of its own is one point among those of the others."""
    alone = [Flown(flown.scores[[k]], flown.failed[[k]], flown.origin) for k in range(len(prepared))]
    return [
        front_of(study, [entrant.entry], single) if entrant.offered is None else front_of(study, entrant.offered, group)
        for entrant, single, group in zip(prepared, alone, behind, strict=True)
    ]
