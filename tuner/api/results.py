"""Results of runs as objects: tables with units, figures, gains."""

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, TypeVar, cast, overload

from objectives.margins.quantities import QUANTITIES, RECORDED
from plant.errors import InputError, StoreError, UnknownNameError
from tuner.api.frames import estimates, figures, frame, json_text, shown, texts_table
from tuner.api.gains import Gains, gains_in, gains_of, read_gains
from tuner.documents import opening
from tuner.documents.assessment import AssessmentDocument
from tuner.documents.comparison import C, ComparedFolder, ComparisonFolder
from tuner.documents.comparison_document import ComparedDocument, ComparisonDocument
from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.documents.folder import D, OpenedFolder
from tuner.documents.summary import Summary
from tuner.documents.tables import read_frame
from tuner.documents.tuning import TuningFolder
from tuner.experiments import registry
from tuner.extension import objects
from tuner.gains.document import document_at
from tuner.report.views import Views, compared_views, tuning_views
from tuner.store.document import read_text
from tuner.store.tables import table_file, table_files
from tuner.study.kinds import AnyStudy
from tuner.study.study import Study
from tuner.text.markup import join
from tuner.text.tables import Table

if TYPE_CHECKING:
    import pandas as pd

    from tuner.api.figures import Figures
    from tuner.report.charts.paper import Figure

CURVES = ("frequency", "real", "imag")
"""Columns of margins.npz that hold a curve each."""
MARGIN_UNITS = {name: QUANTITIES[name].unit for name in RECORDED}


class Opinion(Protocol):
    """A second opinion on gains."""

    @property
    def document(self) -> AssessmentDocument:
        """Its document."""
        ...


class Results(OpenedFolder[D]):
    """Results of a run: the documents and tables of its folder.

    Attributes:
        folder: The results folder, None for a comparison that wrote none.
        document: The main document of the folder, such as summary.json, typed, in SI units and radians.
        flights_made: Flights made just now by `run` or `resume`, None if they were not counted.
        study: The study that `run` was given, which may be a notebook's; None for an opened folder.

    """

    flights_made: int | None = None
    study: AnyStudy | None = None

    @property
    def title(self) -> str:
        """Title of the study."""
        return str(getattr(self.document, "title", ""))

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
        """Sentences that a comparison's numbers allow."""
        return list(getattr(self.document, "words", []))

    @property
    def json(self) -> str:
        """The main document as in the folder, or as it would be."""
        return json_text(self.document, ascii_only=False) if self.folder is None else read_text(self.folder / self.main)

    @cached_property
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

    @property
    def views(self) -> list[str]:
        """Names of the tables for readers, for `view`."""
        return list(self._views)

    def view(self, name: str = "front") -> Table:
        r"""Return a table for readers, in words and shown units.

        Args:
            name: One of `views`.

        Returns:
            The table: `title`, `head` and `rows` are texts; `latex` and `markdown` hold it for a paper.

        Raises:
            UnknownNameError: There is no table of that name.

        Examples:
            >>> results.views
            ['objectives', 'limits', 'gains', 'front', 'margins']
            >>> results.view("objectives").latex.splitlines()[1]
            '\\begin{tabular}{lrrr}'

        """
        if name not in self._views:
            raise UnknownNameError("table", name, self._views)
        return self._views[name]()

    @property
    def _views(self) -> Views:
        return {}

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

    @property
    def _figures(self) -> "Figures":
        return figures(self.kind, self)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.title!r}, {str(self.folder)!r})"

    def _repr_html_(self) -> str:
        return shown(self.title, [*self.words, *self.warnings], self.summary)


class TuningResults(TuningFolder, Results[Summary]):
    """Results of the tuning of one controller.

    Attributes:
        opinion: Opinion of `judge` against the present gains, None where `run` had no file of these, or of an opened folder.
    """

    opinion: Opinion | None = None

    @property
    def _views(self) -> Views:
        return tuning_views(self)

    @cached_property
    def summary(self) -> "pd.DataFrame":
        """Default against tuned: a row for each objective and limit, with 95 % intervals and a verdict."""
        rows = [
            {
                "quantity": row.label,
                "unit": row.unit,
                "kind": row.kind,
                "limit": row.limit,
                **estimates(row.default, "default"),
                **estimates(row.tuned, "tuned"),
                **estimates(row.difference, "difference"),
                "verdict": row.verdict,
            }
            for row in self.document.table
        ]
        return frame(rows, "quantity")

    @cached_property
    def finalists(self) -> "pd.DataFrame":
        """Every point that was flown on held-out scenarios, the default first; columns as in front.csv, then what is limited."""
        import pandas as pd

        front = self.held_out_front
        columns: dict[str, Any] = {"role": front.roles, "feasible": front.feasible, "on_front": front.non_dominated}
        numeric = [entry for entry in FINALIST_COLUMNS if entry.form != "flag" and entry.name in front.columns]
        columns |= {entry.name: front.columns[entry.name] for entry in numeric}
        units = {}
        for i, entry in enumerate(self.objectives):
            for name, part in (("", "held_out"), (" low", "low"), (" high", "high")):
                columns[entry.label + name] = front.stored[part][:, i]
                units[entry.label + name] = self._unit(entry.label)
        for entry in self.constraints:
            held = [self.limited.get((point, entry.label)) for point in front.points]
            for i, name in enumerate(("", " low", " high")):
                # A quantity may be an objective too, which stands there already.
                columns.setdefault(entry.label + name, [float("nan") if each is None else each[i] for each in held])
                units[entry.label + name] = self._unit(entry.label)
        for i, entry in enumerate(self.requirements):
            columns[entry.label], units[entry.label] = front.requirements[:, i], self._unit(entry.label)
        for i, variable in enumerate(self.variables):
            columns[variable.name], units[variable.name] = front.gains[:, i], variable.unit
        table = pd.DataFrame(columns, index=pd.Index(front.points, name="point"))
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
        """Every candidate that the search tried; columns as in generations/*.npz."""
        import pandas as pd

        parts = [read_frame(file) for file in table_files(self.home / "generations")]
        return pd.concat(parts, ignore_index=True).set_index("candidate")

    @cached_property
    def history(self) -> "pd.DataFrame":
        """Progress of the search, a row for each generation: flights, seconds, feasible share, hypervolume."""
        return read_frame(self.home / "history.csv").set_index("generation")

    @cached_property
    def margins(self) -> "pd.DataFrame":
        """Stability margins at hover by point and channel: factors, rad, s and rad/s; empty where nothing limits one."""
        file = table_file(self.home, "margins")
        if not file.exists():
            raise InputError("no steady flight was found, so there are no margins", file=file)
        table = read_frame(file).drop(columns=list(CURVES)).set_index(["point", "channel"])
        table.attrs["units"] = MARGIN_UNITS
        return table

    @cached_property
    def responses(self) -> "pd.DataFrame":
        """Responses by point, scenario and signal: 5 %, 50 % and 95 % over flights, and the worst flight; times in s."""
        return read_frame(table_file(self.home, "responses"))

    @property
    def recommended(self) -> Gains | None:
        """The recommended gains, a mapping by address; None where no candidate keeps every limit."""
        return self.nearest if self.feasible else None

    @property
    def nearest(self) -> Gains:
        """The recommended gains, or the least infeasible ones where nothing is feasible."""
        return read_gains(self.home / self.document.gains_file).with_study(self.study)

    @property
    def default(self) -> Gains:
        """The default gains of the study."""
        return self.gains("default")

    @property
    def points(self) -> dict[str, Gains]:
        """The gains of the named points: "least-" and a metric for the best in an objective, "knee", "near-default"."""
        return {entry.name: self.gains(entry.point) for entry in self.document.points}

    def gains(self, point: str | None = None) -> Gains:
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
        front = self.held_out_front
        if point not in front.points:
            raise UnknownNameError("point", point, front.points)
        searched = front.gains[front.points.index(point)]
        if not self.has_rotors:
            names = [row.name for row in self.document.variables]
            values = {**self.resolved.gains, **dict(zip(names, searched.tolist(), strict=True))}
            return gains_in(document_at(self.nearest.document, point, values), None, self.home).with_study(self.study)
        # All that a comparison takes is imported with it, 0.1 s that a run which only ends here does not wait for.
        from tuner.experiments.compare.entrants import rows_of, study_of

        # What has rotors is a study of a quadrotor.
        study = cast("Study", study_of(self.home))
        (row,) = rows_of(study, searched[None])
        return gains_of(study.controller(row), {"study": study.origin(point)})

    def _unit(self, label: str) -> str:
        return next(row.unit for row in self.document.table if row.label == label)

    def _repr_html_(self) -> str:
        if not self.feasible:
            return shown(self.title, [*self.document.ending, *self.warnings], self.summary)
        from tuner.report.answer_section import answer

        why = f"{self.shown_as.capitalize()} gains: {self.document.pick.why} ({self.document.tuned})."
        lines = [answer(self), why, *self.document.ending, *self.warnings]
        tables = join(texts_table(self.view(name)) for name in ("objectives", "limits", "gains"))
        return shown(self.title, lines, tables, self.figure("front"))


class ComparedResults(ComparedFolder[C], Results[C]):
    """Results of several controllers on the same flights."""

    @property
    def _views(self) -> Views:
        return compared_views(self)

    @cached_property
    def summary(self) -> "pd.DataFrame":
        """Values with 95 % intervals: a row for each contender, columns for each objective and limit."""
        units = {row.label: row.unit for row in self.document.quantities}
        rows: dict[str, dict[str, float | None]] = {row.name: {} for row in self.document.contenders}
        for entry in self.document.estimates:
            rows[entry.contender] |= estimates(entry, entry.quantity)
        named = [{"contender": name, **values} for name, values in rows.items()]
        every = {f"{name}{end}": unit for name, unit in units.items() for end in ("", " low", " high")}
        return frame(named, "contender", every)

    @cached_property
    def differences(self) -> "pd.DataFrame":
        """Paired differences with 95 % intervals: a row for each two contenders and each quantity."""
        return frame(self.document.differences, ("first", "second", "quantity"))


class ComparisonResults(ComparedResults[ComparisonDocument], ComparisonFolder):
    """Results of a comparison: given controllers on the same flights, each against the first."""


def read_table(file: str | Path) -> "pd.DataFrame":
    """Read a table of a results folder.

    Args:
        file: A .npz or .csv file; a .parquet file of an earlier version needs the package pyarrow.

    Returns:
        Its columns as they stand, in SI units and radians.

    Raises:
        StoreError: The file is missing or damaged.

    Examples:
        >>> sorted(tuner.read_table("results/first/responses.npz")["point"].unique())[0]
        'default'

    """
    return read_frame(Path(file))


R = TypeVar("R")
AnyResults: TypeAlias = TuningResults | ComparedResults[ComparedDocument]
KINDS: tuple[type[Results[Any]], ...] = (ComparisonResults, TuningResults)
"""Kinds of results of the core, each recognised by its main document; those of extensions are in their records."""


@overload
def open_results(folder: str | Path) -> AnyResults: ...
@overload
def open_results(folder: str | Path, *, kind: type[R]) -> R: ...
def open_results(folder: str | Path, *, kind: type[R] | None = None) -> AnyResults | R:
    """Open a finished results folder.

    Args:
        folder: A folder that `run` or `compare` wrote.
        kind: Class that the results must have, such as `TuningResults`, so that type checkers know it; by default any.

    Returns:
        `TuningResults`, `ComparisonResults` or those of an extension, such as `ContestResults`.

    Raises:
        StoreError: The folder is missing, not finished, damaged, or of another kind.

    Examples:
        >>> results = tuner.open_results("results/first")
        >>> results.front.attrs["units"]["mean(travel)"]
        '1/s'
        >>> sorted(results.margins.loc["default"].index)
        ['pitch', 'roll', 'x', 'y', 'yaw', 'z']

    """
    results = opening.open_results(Path(folder), (*KINDS, *objects("results").values()))
    if kind is None or isinstance(results, kind):
        return results
    raise StoreError(
        f"{folder}: holds {type(results).__name__}, and kind = {kind.__name__}; leave kind out, or give that class"
    )
