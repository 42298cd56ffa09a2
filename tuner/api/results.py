"""Results of runs as objects: tables with units, figures, gains."""

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from objectives.margins.quantities import QUANTITIES, RECORDED
from plant.errors import InputError, StoreError, UnknownNameError
from tuner.api.frames import estimates, figures, frame, json_text, shown
from tuner.api.gains import gains_of, read_gains
from tuner.documents import opening
from tuner.documents.contest import ComparedFolder
from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.documents.opening import kind_in
from tuner.documents.tables import read_frame
from tuner.documents.tuning import TuningFolder
from tuner.experiments import registry
from tuner.store.document import read_text
from tuner.study.study import Study

if TYPE_CHECKING:
    import pandas as pd

    from tuner.api.figures import Figures
    from tuner.report.charts.paper import Figure

Document = Any
CURVES = ("frequency", "real", "imag")
"""Columns of margins.parquet that hold a curve each."""
MARGIN_UNITS = {name: QUANTITIES[name].unit for name in RECORDED}


class Results:
    """Results of a run.

    Attributes:
        folder: The results folder, None for a comparison that wrote none.
        document: The main document of the folder, such as summary.json, typed, in SI units and radians.
        flights_made: Flights made just now by `run` or `resume`, None where nobody counted.

    """

    kind: ClassVar[str]
    main: ClassVar[str]

    def __init__(self, folder: Path | None, document: Document) -> None:
        self.folder = folder
        self.document = document
        self.flights_made: int | None = None

    @property
    def title(self) -> str:
        """Title of the study."""
        return str(self.document.title)

    @property
    def feasible(self) -> bool:
        """Whether some candidate keeps every limit, so that gains are recommended."""
        return bool(getattr(self.document, "feasible", True))

    @property
    def warnings(self) -> list[str]:
        """Sentences that a reader must know before believing the numbers."""
        return list(getattr(self.document, "warnings", []))

    @property
    def words(self) -> list[str]:
        """Sentences that the numbers of a contest, a comparison or an inference allow."""
        return list(getattr(self.document, "words", []))

    @property
    def json(self) -> str:
        """The main document as it stands in the folder, or as it would."""
        return json_text(self.document, ascii_only=False) if self.folder is None else read_text(self.folder / self.main)

    @property
    def home(self) -> Path:
        """The results folder; StoreError where there is none."""
        if self.folder is None:
            raise StoreError("these results were not written to a folder; give one with out")
        return self.folder

    @property
    def summary(self) -> "pd.DataFrame":
        """The main table."""
        raise NotImplementedError

    @property
    def figures(self) -> list[str]:
        """Names of the figures that there is data for."""
        return self._figures.names

    def figure(self, name: str = "front") -> "Figure":
        """Draw a figure.

        Args:
            name: One of `figures`.

        Returns:
            The figure, made without pyplot: save it with `savefig`.

        Raises:
            UnknownNameError: There is no figure of that name.
            InputError: There is no data for it.

        Examples:
            >>> results.figures
            ['front', 'progress', 'responses']
            >>> results.figure("progress").savefig("progress.png")

        """
        return self._figures.draw(name)

    def report(self) -> Path:
        """Write report.html and the figures of the folder again.

        Returns:
            The path of the page.

        Raises:
            StoreError: A file is missing or damaged, or another process is writing the folder.

        Examples:
            >>> results.report().name
            'report.html'

        """
        return registry.draw(self.home)

    @cached_property
    def documents(self) -> Any:
        """Everything that the figures show."""
        return self.document

    @property
    def _figures(self) -> "Figures":
        return figures(self.kind, self.documents)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.title!r}, {str(self.folder)!r})"

    def _repr_html_(self) -> str:
        return shown(self.title, [*self.words, *self.warnings], self.summary)


class TuningResults(Results):
    """Results of the tuning of one controller."""

    kind = "tuning"
    main = "summary.json"

    @cached_property
    def documents(self) -> TuningFolder:
        """Every document of the folder."""
        return TuningFolder(self.home)

    @property
    def feasible(self) -> bool:
        """Whether some candidate keeps every limit, so that gains are recommended."""
        return self.document.recommends

    @cached_property
    def summary(self) -> "pd.DataFrame":
        """Default against tuned: a row for each objective and limit, with 95 % intervals and a verdict."""
        rows = [
            {
                "quantity": row.label, "unit": row.unit, "kind": row.kind, "limit": row.limit,
                **estimates(row.default, "default"), **estimates(row.tuned, "tuned"),
                **estimates(row.difference, "difference"), "verdict": row.verdict,
            }
            for row in self.document.table
        ]  # fmt: skip
        return frame(rows, "quantity")

    @cached_property
    def finalists(self) -> "pd.DataFrame":
        """Every point that was flown on held-out scenarios, the default first; columns as in front.csv, then what is limited."""
        import pandas as pd

        found = self.documents.front
        columns: dict[str, Any] = {"role": found.roles, "feasible": found.feasible, "on_front": found.non_dominated}
        told = [entry for entry in FINALIST_COLUMNS if entry.form != "flag" and entry.name in found.columns]
        columns |= {entry.name: found.columns[entry.name] for entry in told}
        units = {}
        for i, entry in enumerate(self.documents.objectives):
            for name, part in (("", "held_out"), (" low", "low"), (" high", "high")):
                columns[entry.label + name] = found.stored[part][:, i]
                units[entry.label + name] = self._unit(entry.label)
        for entry in self.documents.constraints:
            held = [self.documents.limited.get((point, entry.label)) for point in found.points]
            for i, name in enumerate(("", " low", " high")):
                # A quantity may be an objective too, which stands there already.
                columns.setdefault(entry.label + name, [float("nan") if each is None else each[i] for each in held])
                units[entry.label + name] = self._unit(entry.label)
        for i, entry in enumerate(self.documents.requirements):
            columns[entry.label], units[entry.label] = found.requirements[:, i], self._unit(entry.label)
        for i, variable in enumerate(self.documents.variables):
            columns[variable.name], units[variable.name] = found.gains[:, i], variable.unit
        table = pd.DataFrame(columns, index=pd.Index(found.points, name="point"))
        table.attrs["units"] = units
        return table

    @cached_property
    def front(self) -> "pd.DataFrame":
        """The front on held-out scenarios: a row for each point, objectives and limits with 95 % intervals, and searched gains.

        Units stand in `front.attrs["units"]`. The column role tells the recommended point ("tuned"), probability how likely
        a point belongs on the front.
        """
        every = self.finalists
        return every.query("on_front and feasible and role != 'default'").drop(columns="on_front")

    @cached_property
    def candidates(self) -> "pd.DataFrame":
        """Every candidate that the search tried; columns as in generations/*.parquet."""
        import pandas as pd

        parts = [read_frame(file) for file in sorted((self.home / "generations").glob("*.parquet"))]
        return pd.concat(parts, ignore_index=True).set_index("candidate")

    @cached_property
    def history(self) -> "pd.DataFrame":
        """Progress of the search, a row for each generation: flights, seconds, feasible share, hypervolume."""
        return read_frame(self.home / "history.csv").set_index("generation")

    @cached_property
    def margins(self) -> "pd.DataFrame":
        """Stability margins at hover by point and channel: factors, rad, s and rad/s; empty where nothing limits one."""
        file = self.home / "margins.parquet"
        if not file.exists():
            raise InputError("no steady flight was found, so there are no margins", file=file)
        found = read_frame(file).drop(columns=list(CURVES)).set_index(["point", "channel"])
        found.attrs["units"] = MARGIN_UNITS
        return found

    @cached_property
    def responses(self) -> "pd.DataFrame":
        """Responses by point, scenario and signal: 5 %, 50 % and 95 % over flights, and the worst flight; times in s."""
        return read_frame(self.home / "responses.parquet")

    @property
    def recommended(self) -> Any:
        """The recommended `Gains`; None where no candidate keeps every limit.

        Where no quadrotor was flown, here and below: values by the address of the gain, or by the name of the variable.
        """
        return self.nearest if self.feasible else None

    @property
    def nearest(self) -> Any:
        """The recommended gains, or those of the point that breaks least where nothing is feasible."""
        if self.documents.has_rotors:
            return read_gains(self.home / self.document.gains_file)
        return {name: entry.value for name, entry in self.documents.gains.gains.items()}

    @property
    def default(self) -> Any:
        """The default gains of the study."""
        return self.gains("default")

    def gains(self, point: str | None = None) -> Any:
        """Return the gains of a point.

        Args:
            point: Name of a row of `finalists`; by default the recommended point.

        Returns:
            The gains.

        Raises:
            UnknownNameError: There is no such point.

        Examples:
            >>> results.gains("default").airframe
            'hummingbird'

        """
        if point is None:
            return self.nearest
        front = self.documents.front
        if point not in front.points:
            raise UnknownNameError("point", point, front.points)
        searched = front.gains[front.points.index(point)]
        if not self.documents.has_rotors:
            names = [row.name for row in self.document.variables]
            return {**self.documents.resolved.gains, **dict(zip(names, searched.tolist(), strict=True))}
        # All that a comparison takes is imported with it, 0.1 s that a run which only ends here does not wait for.
        from tuner.experiments.compare.entrants import rows_of, study_of

        study = study_of(self.home)
        assert isinstance(study, Study), "a plant of one's own has no rotors"
        (row,) = rows_of(study, searched[None])
        return gains_of(study.controller(row), {"study": study.origin(point)})

    def _unit(self, label: str) -> str:
        return next(row.unit for row in self.document.table if row.label == label)

    def _repr_html_(self) -> str:
        ending = self.document.ending
        picked = [f"Recommended: {self.document.tuned}: {self.document.pick.why}."] if self.feasible else []
        return shown(self.title, [*ending, *picked, *self.warnings], self.summary)


class ContestResults(Results):
    """Results of a contest: several controllers, each tuned, on the same flights."""

    kind = "contest"
    main = "contest.json"

    @cached_property
    def documents(self) -> ComparedFolder:
        """Every document of the folder."""
        return opening.open_results(self.home)

    @cached_property
    def summary(self) -> "pd.DataFrame":
        """Values with 95 % intervals: a row for each contender, columns for each objective and limit."""
        units = {row.label: row.unit for row in self.document.quantities}
        rows: dict[str, dict[str, Any]] = {row.name: {} for row in self.document.contenders}
        for entry in self.document.estimates:
            rows[entry.contender] |= estimates(entry, entry.quantity)
        named = [{"contender": name, **values} for name, values in rows.items()]
        every = {f"{name}{end}": unit for name, unit in units.items() for end in ("", " low", " high")}
        return frame(named, "contender", every)

    @cached_property
    def differences(self) -> "pd.DataFrame":
        """Paired differences with 95 % intervals: a row for each two contenders and each quantity."""
        return frame(self.document.differences, ("first", "second", "quantity"))


class ComparisonResults(ContestResults):
    """Results of a comparison: given controllers on the same flights, each against the first."""

    kind = "comparison"
    main = "comparison.json"


class InferenceResults(Results):
    """Results of an inference: settings at which published numbers come out."""

    kind = "inference"
    main = "inference.json"

    @cached_property
    def summary(self) -> "pd.DataFrame":
        """The unknowns: inferred value, the span that does nearly as well, and how well each is told."""
        return self.unknowns

    @cached_property
    def unknowns(self) -> "pd.DataFrame":
        """A row for each unknown: unit, default, inferred, near_low, near_high, low68, high68, verdict."""
        return frame(self.document.unknowns, "name")

    @cached_property
    def cells(self) -> "pd.DataFrame":
        """A row for each published number: contender, metric, unit, the number, and our flights beside it."""
        rows = [
            {
                **{key: getattr(row, key) for key in ("contender", "metric", "scenario", "unit", "published")},
                **{key: getattr(row.ours, key) for key in ("median", "low95", "high95", "inside")},
            }
            for row in self.document.cells
        ]  # fmt: skip
        return frame(rows)

    def figure(self, name: str = "inference") -> "Figure":
        """Draw a figure; see `Results.figure`."""
        return super().figure(name)


KINDS: tuple[type[Results], ...] = (ContestResults, InferenceResults, ComparisonResults, TuningResults)
"""Kinds of results, each told by its main document; a contest's folder may hold an inference."""


def open_results(folder: str | Path) -> Any:
    """Open a finished results folder.

    Args:
        folder: A folder that `run` or `compare` wrote.

    Returns:
        `TuningResults`, `ContestResults`, `InferenceResults` or `ComparisonResults`.

    Raises:
        StoreError: The folder is missing, not finished, or damaged.

    Examples:
        >>> results = tuner.open_results("results/first")
        >>> results.front.attrs["units"]["mean(travel)"]
        '1/s'
        >>> sorted(results.margins.loc["default"].index)
        ['pitch', 'roll', 'x', 'y', 'yaw', 'z']

    """
    folder = Path(folder)
    found = kind_in(folder)
    kind = next((entry for entry in KINDS if found is not None and entry.kind == found.kind), None)
    if found is not None and kind is not None:
        return kind(folder, found(folder).document)
    raise StoreError(f"{folder} is no finished results folder: it holds no {TuningResults.main}")
