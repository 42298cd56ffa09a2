"""The folder of contenders on the same flights, opened: everything but `document` in shown units, angles in degrees."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np

from tuner.documents.comparison_document import (
    BestUnder,
    ComparedDocument,
    ComparisonDocument,
    ContenderRow,
    FrontsPart,
    QuantityRow,
)
from tuner.documents.folder import OpenedFolder
from tuner.documents.parts import ENDS, Estimate, Row, ShareCount, row_in_degrees, scaled
from tuner.documents.tables import Columns, Fan, groups, read_fans
from tuner.store.document import refuse
from tuner.store.tables import table_file
from tuner.text.units import in_degrees

DIFFERENCE = ("difference", "low", "high")
PUBLISHED = ("printed", "mean", "low", "high", "p2_5", "median", "p97_5")


@dataclass(frozen=True)
class ContenderFront:
    """The points of one contender on the flights of the comparison.

    points: names (n,); recommended: mask (n,); values, low, high (n, objectives); gains: of each point by address; lost (n,):
    flights that did not reach their end.
    """

    contender: str
    points: list[str]
    recommended: np.ndarray
    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    gains: list[dict[str, float]]
    lost: np.ndarray


class ContenderScores(NamedTuple):
    """Values of one quantity over the flights of a contender, sorted (flights,)."""

    contender: str
    quantity: str
    values: np.ndarray


class Trace(NamedTuple):
    """One signal of one flight: time [s], value and reference (instants,), NaN where there is no reference."""

    contender: str
    scenario: str
    signal: str
    unit: str
    time: np.ndarray
    value: np.ndarray
    reference: np.ndarray


class Air(NamedTuple):
    """One component of the disturbance of a flight: time [s] and value (instants,)."""

    scenario: str
    signal: str
    unit: str
    time: np.ndarray
    value: np.ndarray


C = TypeVar("C", bound=ComparedDocument)


class ComparedFolder(OpenedFolder[C]):
    """Contenders flown through the same flights; whatever is damaged becomes a StoreError naming it when it is asked for.

    Tables may be missing; what they would hold is left out.
    """

    @cached_property
    def shown(self) -> C:
        """The document with all angles in degrees, and no unit as ""."""
        return document_in_degrees(self.document)

    @property
    def contenders(self) -> list[ContenderRow]:
        """The controllers as they flew."""
        return self.document.contenders

    @cached_property
    def index(self) -> dict[str, int]:
        """Place of each contender by name."""
        return {entry.name: place for place, entry in enumerate(self.contenders)}

    def layer(self, name: str) -> str:
        """Return the layer of a contender's traces in the figures, by which they can be switched off."""
        return f"contender-{self.index[name]}"

    @cached_property
    def quantity(self) -> dict[str, QuantityRow]:
        """Quantities by label."""
        return {entry.label: entry for entry in self.shown.quantities}

    @cached_property
    def estimates(self) -> dict[tuple[str, str], Estimate]:
        """Values by contender and quantity."""
        return {(row.contender, row.quantity): row.estimate for row in self.shown.estimates}

    @cached_property
    def counts(self) -> dict[tuple[str, str], ShareCount]:
        """The counts behind quantities that are 0 or 1, by contender and quantity."""
        return {(row.contender, row.quantity): row.count for row in self.shown.estimates if row.count is not None}

    @cached_property
    def flown(self) -> list[str]:
        """Airframes, or the plant, in the order of the contenders."""
        return list(dict.fromkeys(entry.flown for entry in self.contenders))

    def best(self, label: str) -> set[str]:
        """Return the contenders with the smallest value of a quantity, none where all have the same."""
        estimates = [(name, self.estimates.get((name, label))) for name in self.index]
        values = {name: entry.value for name, entry in estimates if entry is not None and entry.value is not None}
        least = {name for name, value in values.items() if value == min(values.values())}
        return least if len(least) < len(values) or len(values) == 1 else set()

    def words_beside_best(self, label: str) -> dict[str, str]:
        """Return the contenders that a best one is not better than, with the word on their difference."""
        best = self.best(label)
        even = [row for row in self.shown.differences if row.quantity == label and row.lower is None]
        pairs = [(row, {row.first, row.second}) for row in even]
        return {name: row.verdict for row, pair in pairs if pair & best for name in pair - best}

    @cached_property
    def fronts(self) -> FrontsPart | None:
        """The common box of the fronts and their shares of it; None where nothing was tuned, or their points are not there."""
        return self.shown.fronts if (self.home / "fronts.csv").exists() else None

    @cached_property
    def front_points(self) -> list[ContenderFront]:
        """The points of every front; none where `fronts` is None."""
        if self.fronts is None:
            return []
        table, objectives = Columns.read(self.home / "fronts.csv"), self.fronts.objectives
        by_label = factors(self.document)
        scale = np.array([by_label.get(label, 1.0) for label in objectives])
        return [_front(table, name, objectives, scale) for name in dict.fromkeys(table.text("contender"))]

    @cached_property
    def scores(self) -> list[ContenderScores]:
        """Values of every contender in every quantity, over all scenarios that count for it."""
        file, out, by_label = table_file(self.home, "scores"), [], factors(self.document)
        for (contender, label), values in groups(file, ("contender", "quantity"), ("value",)):
            if not np.isfinite(values).all():
                raise refuse(file, "the column 'value' holds something that is no finite number")
            out.append(ContenderScores(contender, label, np.sort(values[:, 0]) * by_label.get(label, 1.0)))
        return out

    @cached_property
    def fans(self) -> list[Fan]:
        """Fans of every contender, scenario and signal."""
        return read_fans(table_file(self.home, "responses"))

    @cached_property
    def traces(self) -> list[Trace]:
        """Every signal of the single flights."""
        out, names, columns = [], ("contender", "scenario", "signal", "unit"), ("time", "value", "reference")
        for (contender, scenario, signal, unit), values in groups(table_file(self.home, "traces"), names, columns):
            shown, factor = in_degrees(unit)
            time, value, reference = values.T
            out.append(Trace(contender, scenario, signal, shown, time, value * factor, reference * factor))
        return out

    @cached_property
    def air(self) -> list[Air]:
        """Components of the air of the single flights."""
        out, names = [], ("scenario", "signal", "unit")
        for (scenario, signal, unit), values in groups(table_file(self.home, "wind"), names, ("time", "value")):
            shown, factor = in_degrees(unit)
            time, value = values.T
            out.append(Air(scenario, signal, shown, time, value * factor))
        return out

    @cached_property
    def scenarios(self) -> list[str]:
        """Scenarios with responses, in the order of the files."""
        return list(dict.fromkeys(entry.scenario for entry in [*self.fans, *self.traces]))


class ComparisonFolder(ComparedFolder[ComparisonDocument]):
    """Results of a comparison."""

    kind, noun, main, model = "comparison", "a comparison", "comparison.json", ComparisonDocument


def factors(document: ComparedDocument) -> dict[str, float]:
    """Return by label of a quantity what turns its numbers in files into shown ones."""
    return {row.label: in_degrees(row.unit).factor for row in document.quantities}


def document_in_degrees(document: C) -> C:
    """Return a document with all angles in degrees, and no unit as ""."""
    by_label = factors(document)

    def by_quantity(rows: list[Row], *names: str) -> list[Row]:
        return [scaled(row, by_label.get(getattr(row, "quantity", ""), 1.0), *names) for row in rows]

    def best(entry: BestUnder) -> BestUnder:
        rows = [scaled(row, by_label.get(entry.objective, 1.0), *ENDS) for row in entry.rows]
        return scaled(entry, by_label.get(entry.subject_to, 1.0), "limit").model_copy(update={"rows": rows})

    box = document.fronts
    reference = box and {label: value * by_label.get(label, 1.0) for label, value in box.reference.items()}
    claims = [row.model_copy(update={"rows": by_quantity(row.rows, *DIFFERENCE)}) for row in document.claims]
    return document.model_copy(
        update={
            "quantities": [row_in_degrees(row, "limit") for row in document.quantities],
            "estimates": by_quantity(document.estimates, *ENDS),
            "differences": by_quantity(document.differences, *DIFFERENCE),
            "claims": claims,
            "fronts": box and box.model_copy(update={"reference": reference}),
            "best_under": [best(entry) for entry in document.best_under],
            "published": [row_in_degrees(row, *PUBLISHED) for row in document.published],
        }
    )


def _front(table: Columns, name: str, objectives: list[str], factors: np.ndarray) -> ContenderFront:
    rows = [i for i, entry in enumerate(table.text("contender")) if entry == name]
    values, low, high = (table.block([f"{kind}:{label}" for label in objectives])[rows] * factors for kind in ENDS)
    gains = {key.removeprefix("gain:"): table.numbers(key)[rows] for key in table.columns if key.startswith("gain:")}
    # The laws of other contenders have other gains: their columns are empty here.
    flown = {address: column for address, column in gains.items() if np.isfinite(column).all()}
    points = [{address: float(column[i]) for address, column in flown.items()} for i in range(len(rows))]
    names = [table.text("point")[i] for i in rows]
    lost = table.numbers("lost")[rows].astype(int)
    return ContenderFront(name, names, table.flags("recommended")[rows], values, low, high, points, lost)
