"""Tables of measured inputs and outputs, checked on reading."""

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import numpy as np

from plant.errors import InputError, shortened
from plant.input_files import given_content
from tuner.extensions.logs.csv_table import LONGEST_LINE, MAX_CSV_BYTES, header, read_columns

Array = np.ndarray
TIME_NAMES = ("time", "t", "time_s", "time [s]", "seconds")
"""Columns that are taken for the time if none is named."""
MIN_SAMPLES, MAX_SAMPLES = 20, 200_000
MAX_COLUMNS = 8
"""Most inputs, and most outputs."""
MAX_VALUE = 1e12
REGULAR = 0.05
"""Largest distance of a time from equal spacing, as a share of the interval, of samples that count as equally spaced."""
MIN_TAIL = 10
"""Fewest samples behind the last change of an input that moves only once."""


@dataclass(frozen=True)
class Experiment:
    """A record of inputs and outputs.

    Attributes:
        file: File that it comes from.
        sha256: Digest of the file.
        time: Times (n,) [s].
        inputs: Inputs (n, inputs), each held up to the next sample.
        outputs: Outputs (n, outputs).
        before: Values of the inputs (inputs,) before the record.
    """

    file: str
    sha256: str
    time: Array
    inputs: Array
    outputs: Array
    before: Array

    @property
    def period(self) -> float:
        """Mean sampling interval [s]."""
        return float((self.time[-1] - self.time[0]) / (len(self.time) - 1))

    @property
    def is_regular(self) -> bool:
        """Whether the samples are equally spaced."""
        ideal = self.time[0] + self.period * np.arange(len(self.time))
        return bool(np.max(np.abs(self.time - ideal)) <= REGULAR * self.period)


@dataclass(frozen=True)
class Columns:
    """Columns of a table; time: "" for the usual names; period: sampling interval [s] of tables without a time."""

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    time: str = ""
    period: float | None = None
    before: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for key, names in (("input", self.inputs), ("output", self.outputs)):
            if not 1 <= len(names) <= MAX_COLUMNS:
                raise InputError(f"given {len(names)} columns; allowed: 1 to {MAX_COLUMNS}", key=key)
        twice = sorted({name for name in self.all if self.all.count(name) > 1})
        if twice:
            raise InputError(f"column '{shortened(twice[0])}' is named twice; name each column once", key="input")
        if self.period is not None and not 1e-9 < self.period < MAX_VALUE:
            raise InputError(f"given {self.period} s; allowed: above 0", key="period")
        if self.before and len(self.before) != len(self.inputs):
            raise InputError(
                f"given {len(self.before)} values for {len(self.inputs)} inputs; give one each", key="before"
            )
        if not all(abs(value) < MAX_VALUE for value in self.before):
            raise InputError(f"given {list(self.before)}; allowed: finite numbers below {MAX_VALUE:g}", key="before")

    @property
    def all(self) -> list[str]:
        """Inputs, outputs and time."""
        return [*self.inputs, *self.outputs, *([self.time] if self.time else [])]


def read_experiment(file: Path, columns: Columns) -> Experiment:
    """Return the record in a CSV table; InputError, a line that names the file, where it is none or identifies nothing."""
    content = given_content(file, "give a CSV table of measured inputs and outputs", MAX_CSV_BYTES)
    first = content[:LONGEST_LINE].decode("utf-8-sig", "replace").split("\n")[0]
    separator = max(",;\t", key=first.count)
    head = header(first + "\n", separator)
    time_name = columns.time or next(
        (name for name in head if name.lower() in TIME_NAMES and name not in columns.all), ""
    )
    if not time_name and columns.period is None:
        shown = ", ".join(shortened(name) for name in head[:12])
        raise InputError(
            f"has no column of time among {shown}; name it with --time, or give the sampling interval with --period",
            file=file,
        )
    wanted = [*columns.inputs, *columns.outputs]
    if columns.period is None:
        wanted.append(time_name)
    table = read_columns(content, str(file), wanted, separator)
    if columns.period is not None:
        table = np.column_stack([table, columns.period * np.arange(len(table))])
    n_inputs = len(columns.inputs)
    _check_cells(table, [*columns.inputs, *columns.outputs, time_name or "time"], file)
    parts = table[:, -1], table[:, :n_inputs], table[:, n_inputs:-1]
    return _checked(str(file), sha256(content).hexdigest(), parts, columns)


def make_experiment(
    time: Array, inputs: Array, outputs: Array, before: Sequence[float] = (), name: str = "data"
) -> Experiment:
    """Return the record of arrays: times (n,) [s], inputs and outputs (n,) or (n, signals); checked as a file's."""
    columns = [np.asarray(each, dtype=float) for each in (inputs, outputs)]
    columns = [each[:, None] if each.ndim == 1 else each for each in columns]
    time = np.asarray(time, dtype=float)
    if time.ndim != 1 or any(each.ndim != 2 or len(each) != len(time) for each in columns):
        shapes = ", ".join(str(each.shape) for each in (time, *columns))
        raise InputError(f"given arrays of the shapes {shapes}; allowed: (n,) and (n, signals) with one n", key="data")
    names = (
        [f"input {i + 1}" for i in range(columns[0].shape[1])],
        [f"output {i + 1}" for i in range(columns[1].shape[1])],
    )
    named = Columns(tuple(names[0]), tuple(names[1]), before=tuple(before))
    _check_cells(np.column_stack([*columns, time]), [*names[0], *names[1], "time"], Path(name))
    return _checked(name, sha256(columns[1].tobytes()).hexdigest(), (time, *columns), named)


def _checked(name: str, digest: str, parts: Sequence[Array], columns: Columns) -> Experiment:
    """Return the record of time, inputs and outputs; InputError where it identifies nothing."""
    time, inputs, outputs = parts
    before = np.array(columns.before) if columns.before else inputs[0].copy()
    experiment = Experiment(name, digest, time, inputs, outputs, before)
    _check_time(experiment, Path(name))
    _check_motion(experiment, columns, Path(name))
    return experiment


def _check_cells(table: Array, names: Sequence[str], file: Path) -> None:
    if not MIN_SAMPLES <= len(table) <= MAX_SAMPLES:
        raise InputError(f"has {len(table):,} rows; allowed: {MIN_SAMPLES} to {MAX_SAMPLES:,}", file=file)
    with np.errstate(invalid="ignore"):
        wrong = np.argwhere(~(np.abs(table) < MAX_VALUE))
    if len(wrong):
        row, column = (int(place) for place in wrong[0])
        raise InputError(
            f"column '{shortened(names[column])}' has no number below {MAX_VALUE:g} in row {row + 1:,} "
            f"({len(wrong):,} such cells); remove these rows",
            file=file,
        )


def _check_time(experiment: Experiment, file: Path) -> None:
    steps = np.diff(experiment.time)
    if np.any(steps <= 0.0):
        row = int(np.argmax(steps <= 0.0)) + 2
        before, at = experiment.time[row - 2], experiment.time[row - 1]
        raise InputError(
            f"its time goes from {before:.12g} to {at:.12g} s at row {row:,}; sort the rows by time and remove repeated ones",
            file=file,
        )
    longest, usual = float(steps.max()), float(np.median(steps))
    if longest > 1000.0 * usual:
        raise InputError(
            f"has a gap of {longest:g} s between samples of {usual:g} s; give its parts as files of their own",
            file=file,
        )


def _check_motion(experiment: Experiment, columns: Columns, file: Path) -> None:
    for name, series, before in zip(columns.inputs, experiment.inputs.T, experiment.before, strict=True):
        moves = np.flatnonzero(np.diff(series, prepend=before))
        if len(moves) == 0:
            raise InputError(
                f"input '{shortened(name)}' is {series[0]:g} throughout, so nothing shows what it does; move it, or give its "
                "value before the first row with --before",
                file=file,
            )
        if len(series) - moves[0] < MIN_TAIL:
            raise InputError(
                f"input '{shortened(name)}' first moves {len(series) - moves[0]} samples before the end; record at least "
                f"{MIN_TAIL} samples behind it",
                file=file,
            )
    for name, series in zip(columns.outputs, experiment.outputs.T, strict=True):
        if np.ptp(series) == 0.0:
            raise InputError(
                f"output '{shortened(name)}' is {series[0]:g} throughout; choose the column that answers the input",
                file=file,
            )
