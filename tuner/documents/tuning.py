"""A tuning run's folder, opened. Objectives, limits and responses are in shown units, angles in degrees; documents are in SI."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from plant.quadrotor.gains import GROUPS
from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.documents.folder import OpenedFolder
from tuner.documents.parts import Estimate, RecommendedGains, on_page, row_in_degrees
from tuner.documents.resolved import Resolved
from tuner.documents.summary import ComparedRow, RequiredRow, Summary, TableRow, VariableRow
from tuner.documents.tables import Columns, Fan, PointSpectrum, read_fans, read_spectra
from tuner.documents.tuning_tables import Candidates, HeldOutFront, History, Loop, read_loops
from tuner.documents.verdicts import UNKNOWN, verdict_on_difference, verdict_on_limit
from tuner.store.document import read_text, refuse
from tuner.store.start import Start
from tuner.store.tables import TableFile, table_file, table_files
from tuner.text.units import in_degrees

DEFAULT, TUNED = "default", "tuned"
SHOWN = ("limit", "default", "tuned", "difference")
# Columns of fans, of the history and of the front that folders of earlier versions lack.
WORST = ("worst", "worst_flight")
SAVED = ("flights_saved", "flights_raced")
INTERVAL = ("held_out", "low", "high")
JUDGED = ("search", *INTERVAL)
COMPARED = ("gap", "gap_low", "gap_high", "difference", "difference_low", "difference_high")
LIMITED = ("value", "low", "high", "difference", "difference_low", "difference_high")


NOTHING = Estimate(None, None, None)


class TuningFolder(OpenedFolder[Summary]):
    """Results of a tuning run; whatever is missing or damaged becomes a StoreError naming it when it is asked for."""

    kind, noun, main, model = "tuning", "a tuning run", "summary.json", Summary

    @cached_property
    def resolved(self) -> Resolved:
        """Every value of the study."""
        return Resolved.read(self.home / "resolved.json")

    @property
    def has_rotors(self) -> bool:
        """Whether a quadrotor was flown, and neither a plant of the user's own nor by another program."""
        return self.resolved.plant is None and not self.is_external

    @property
    def is_external(self) -> bool:
        """Whether another program made the trials, so that nothing is known of a vehicle, its loops and its responses."""
        return self.resolved.trials is not None

    @property
    def sample_noun(self) -> str:
        """Plural noun of what is counted: flights of a vehicle, simulations of a plant, trials of another program."""
        return "trials" if self.is_external else "flights" if self.has_rotors else "simulations"

    @cached_property
    def gains_document(self) -> RecommendedGains:
        """The gains of the point that stands next to the default."""
        return RecommendedGains.read(self.home / self.document.gains_file)

    @cached_property
    def gains_text(self) -> str:
        """gains.json as it stands, or infeasible.json."""
        return read_text(self.home / self.document.gains_file)

    @cached_property
    def quantities(self) -> list[ComparedRow]:
        """Objectives and constraints, as shown."""
        return [row_in_degrees(row, *SHOWN) for row in self.document.compared]

    @property
    def objectives(self) -> list[ComparedRow]:
        """The objectives, in the order of the columns of values."""
        return [row for row in self.quantities if row.kind == "objective"]

    @property
    def constraints(self) -> list[ComparedRow]:
        """Metrics that must not exceed a limit."""
        return [row for row in self.quantities if row.kind == "constraint"]

    @cached_property
    def requirements(self) -> list[RequiredRow]:
        """Requirements that are known without flying, as shown: angles in degrees, levels in dB."""
        return [on_page(row, *SHOWN) for row in self.document.required]

    @property
    def variables(self) -> list[VariableRow]:
        """The searched gains."""
        return self.document.variables

    @property
    def tuned(self) -> str:
        """Name of the point next to the default: the recommended one, or the nearest where nothing is feasible."""
        return self.document.shown

    @property
    def feasible(self) -> bool:
        """Whether anything is recommended."""
        return self.document.recommends

    @property
    def shown_as(self) -> str:
        """Heading of the column of that point: "tuned" or "nearest"."""
        return self.document.shown_as

    @property
    def called(self) -> str:
        """Name of that point in a sentence."""
        return "recommended" if self.feasible else "nearest to feasible"

    @property
    def gains_noun(self) -> str:
        """Plural noun of the numbers of a point."""
        return "values" if self.is_external else "gains"

    @property
    def shown_name(self) -> str:
        """Words for that point with its name behind: "tuned gains (p0122)"."""
        return (
            f"default {self.gains_noun}"
            if self.tuned == DEFAULT
            else f"{self.shown_as} {self.gains_noun} ({self.tuned})"
        )

    @cached_property
    def factors(self) -> np.ndarray:
        """Factors (objectives,) from numbers of files to shown ones."""
        rows = [row for row in self.document.compared if row.kind == "objective"]
        return np.array([in_degrees(row.unit).factor for row in rows])

    @cached_property
    def addresses(self) -> dict[str, list[str]]:
        """Gains that each variable represents, as resolved.json says, or as the names of groups do."""
        resolved = {entry.name: entry.addresses for entry in self.resolved.variables}
        out = {}
        for name in [variable.name for variable in self.variables]:
            group, _, gain = name.partition(".")
            named = resolved.get(name) or [f"{axis}.{gain}" for axis in GROUPS.get(group, (group,))]
            out[name] = [address for address in named if address in self.gains_document.gains]
        return out

    @cached_property
    def held_out_front(self) -> HeldOutFront:
        """The points flown on held-out scenarios."""
        table, labels = Columns.read(self.home / "front.csv"), [entry.label for entry in self.objectives]
        stored = {
            prefix: table.block([f"{prefix}:{label}" for label in labels])
            for prefix in (*JUDGED, *COMPARED)
            if prefix in JUDGED or f"{prefix}:{labels[0]}" in table.columns
        }
        search, held_out, low, high = (stored[prefix] * self.factors for prefix in JUDGED)
        required = [f"requirement:{entry.label}" for entry in self.requirements]
        by_name = {entry.name: entry.read(table) for entry in FINALIST_COLUMNS}
        return HeldOutFront(
            points=table.text("point"),
            roles=[TUNED if role == "nearest" else role for role in table.text("role")],
            candidates=table.numbers("candidate"),
            gains=table.block([f"gain:{variable.name}" for variable in self.variables]),
            search=search,
            held_out=held_out,
            low=low,
            high=high,
            stored=stored,
            requirements=table.block(required, optional=True),
            columns={name: values for name, values in by_name.items() if values is not None},
        )

    def rows_of(self, point: int) -> list[TableRow]:
        """Return the table with held-out values of a finalist for the tuned ones, in SI units; point: its row of the front."""
        return self._tables[point]

    @cached_property
    def _tables(self) -> list[list[TableRow]]:
        # A page needs each of them four times.
        points = range(len(self.held_out_front.points))
        return [[self._row_of(row, point) for row in self.document.table] for point in points]

    def _row_of(self, row: TableRow, point: int) -> TableRow:
        first = self.held_out_front.of(DEFAULT)
        tuned = self._value_of(row, point)
        default = self._value_of(row, first[0]) if first else NOTHING
        difference = self._difference_of(row, point)
        if row.kind == "requirement":
            verdict = verdict_on_limit(tuned.value, row.limit, row.sense)
            if default.value is not None and tuned.value is not None:
                difference = Estimate(tuned.value - default.value, None, None)
        elif row.limit is None:
            verdict = verdict_on_difference(default.value, difference, self.resolved.relevant)
        else:
            verdict = UNKNOWN if tuned.value is None else verdict_on_limit(tuned.value, row.limit)
        return row.model_copy(update={"default": default, "tuned": tuned, "difference": difference, "verdict": verdict})

    def _value_of(self, row: TableRow, point: int) -> Estimate:
        front = self.held_out_front
        if row.kind == "requirement":
            value = front.requirements[point, [entry.label for entry in self.document.required].index(row.label)]
            return Estimate(finite_or_none(value), None, None)
        if row.kind == "constraint":
            numbers = self.limited.get((front.points[point], row.label))
            return NOTHING if numbers is None else Estimate(*map(finite_or_none, numbers[:3]))
        return self._stored(row, point, INTERVAL)

    def _difference_of(self, row: TableRow, point: int) -> Estimate:
        if row.kind == "objective":
            return self._stored(row, point, COMPARED[3:])
        numbers = self.limited.get((self.held_out_front.points[point], row.label))
        return NOTHING if numbers is None else Estimate(*map(finite_or_none, numbers[3:]))

    def _stored(self, row: TableRow, point: int, columns: Sequence[str]) -> Estimate:
        stored = self.held_out_front.stored
        i = [entry.label for entry in self.objectives].index(row.label)
        return Estimate(*[finite_or_none(stored[name][point, i]) if name in stored else None for name in columns])

    @cached_property
    def evaluated(self) -> Candidates:
        """Everything that the search tried."""
        folder = self.home / "generations"
        gains = [f"gain:{variable.name}" for variable in self.variables]
        columns = ["candidate", "feasible", *gains, *[f"objective:{entry.label}" for entry in self.objectives]]
        files = table_files(folder)
        if not files:
            raise refuse(folder, "there is no generation in it")
        tables = [TableFile(file) for file in files]
        rows = np.concatenate([table.block(columns) for table in tables], axis=0)
        required = [f"requirement:{entry.label}" for entry in self.requirements]
        limits = np.concatenate([table.block(["candidate", *required], optional=True)[:, 1:] for table in tables])
        split = 2 + len(gains)
        objectives = rows[:, split:] * self.factors
        return Candidates(rows[:, 0].astype(int), rows[:, 2:split], objectives, rows[:, 1] > 0.5, limits)

    @cached_property
    def progress(self) -> History:
        """Progress of the search."""
        table = Columns.read(self.home / "history.csv")
        names = ("generation", "flights", "seconds", "feasible_share", "hypervolume")
        saved = {name: table.numbers(name) for name in SAVED if name in table.columns}
        return History(*[table.numbers(name) for name in names], **saved)

    @cached_property
    def fans(self) -> list[Fan]:
        """Responses of points over flights, none where the folder holds none."""
        return read_fans(table_file(self.home, "responses"), WORST, by_name=True)

    @cached_property
    def spectra(self) -> list[PointSpectrum]:
        """Spectra of the commands of default and tuned gains, none where the study does not judge by noise."""
        return read_spectra(table_file(self.home, "spectra"))

    @cached_property
    def scenarios(self) -> list[str]:
        """Scenarios with responses, in the order of the study."""
        return list(dict.fromkeys(fan.scenario for fan in self.fans))

    @cached_property
    def flown_points(self) -> list[str]:
        """Points with responses: default first, then tuned, then the others as they come."""
        names = dict.fromkeys(fan.point for fan in self.fans)
        return sorted(names, key=lambda name: (DEFAULT, TUNED, "").index(self.held_out_front.role(name)))

    @cached_property
    def limited(self) -> dict[tuple[str, str], np.ndarray]:
        """Numbers of `LIMITED` by point and constraint, held out and as stored; nothing where the folder holds no such table."""
        file = self.home / "constraints.csv"
        if not file.exists() or len(read_text(file).splitlines()) < 2:
            return {}
        table = Columns.read(file)
        return dict(zip(zip(table.text("point"), table.text("label"), strict=True), table.block(LIMITED), strict=True))

    @cached_property
    def loops(self) -> list[Loop]:
        """Margins and curves of every point and channel; none where there are none in the folder."""
        file = table_file(self.home, "margins")
        return read_loops(file) if file.exists() else []

    @cached_property
    def worst_loops(self) -> list[Loop]:
        """Loops of default and shown gains in their worst states."""
        file = table_file(self.home, "worst_states")
        return read_loops(file) if file.exists() else []

    @cached_property
    def start(self) -> int | None:
        """The candidate that the search started from as designed: the second of the first generation, behind the default."""
        file = self.home / "start.json"
        if "design" not in (self.resolved.search.initial or []) or not file.exists():
            return None
        return None if any('"design"' in warning for warning in Start.read(file).warnings) else 1


def finite_or_none(value: float) -> float | None:
    """Return a number, None where it is infinite or not known."""
    return float(value) if np.isfinite(value) else None
