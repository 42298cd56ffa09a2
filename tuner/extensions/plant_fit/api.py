"""A plant out of measured inputs and outputs."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from plant.errors import InputError, check_name
from tuner.extensions.plant_fit.building import fit_document
from tuner.extensions.plant_fit.channels import LAWS
from tuner.extensions.plant_fit.estimate import Problem
from tuner.extensions.plant_fit.intervals import FittedPlant
from tuner.extensions.plant_fit.noise import noise_parts
from tuner.extensions.plant_fit.page import fit_page
from tuner.extensions.plant_fit.reading import TIME_NAMES, Columns, Experiment, make_experiment, read_experiment
from tuner.extensions.plant_fit.result import PlantFit
from tuner.extensions.plant_fit.selection import choose
from tuner.extensions.plant_fit.structures import STRUCTURES, Structure
from tuner.extensions.plant_fit.study_file import Signals
from tuner.report.page import put_page
from tuner.store.document import taken
from tuner.store.folder import put

if TYPE_CHECKING:
    import pandas as pd

MAX_EXPERIMENTS = 32


def fit(
    data: "str | Path | Sequence[str | Path] | pd.DataFrame",
    *,
    input: str | Sequence[str],
    output: str | Sequence[str],
    time: str = "",
    period: float | None = None,
    before: float | Sequence[float] | None = None,
    structure: str | Sequence[str] = "",
    max_dead_time: float | None = None,
    drift: bool = False,
    units: Mapping[str, str] | None = None,
    out: str | Path | None = None,
    law: str = "pid",
    report: str | Path | None = None,
) -> PlantFit:
    """Fit a plant to measured inputs and outputs.

    Its numbers have intervals. Closed loops are fitted as open ones: plant and noise are estimated together.

    Args:
        data: CSV tables of one plant, one for each experiment, or a frame of pandas.
        input: Names of the columns of inputs, each held up to the next sample.
        output: Names of the columns of outputs.
        time: Name of the column of time [s]; by default one called time or t.
        period: Sampling interval [s] of tables without a time.
        before: Values of the inputs before the first row; by default those of the first row.
        structure: Names of the structures that compete; by default all.
        max_dead_time: Largest dead time [s]; by default a fifth of the longest record.
        drift: Whether a straight drift of the outputs is estimated.
        units: Unit by the name of a column.
        out: Study (TOML) to write, with plant, spread and noise; it must not be there yet.
        law: Law of the study's loops: pi, pid, adrc or ladrc.
        report: Page (HTML) to write; it must not be there yet.

    Returns:
        Transfer functions with intervals, rivals, noise, and what the data do not show.

    Raises:
        InputError: A table cannot be read or does not identify a plant, or the file to write is there already.

    Examples:
        >>> found = tuner.fit("step.csv", input="heater", output="temperature", out="heater.toml")  # doctest: +SKIP
        >>> found.table  # doctest: +SKIP
    """
    check_name("law", law, LAWS, key="law")
    columns = Columns(_names(input), _names(output), time, period, _numbers(before))
    targets = [None if each is None else Path(each) for each in (out, report)]
    _check_targets(*targets)
    structures = _structures(structure)
    if max_dead_time is not None and not 0.0 <= max_dead_time < 1e9:
        raise InputError(f"given {max_dead_time} s; allowed: 0 and above", key="max_dead_time")
    experiments = _experiments(data, columns)
    plants = [
        FittedPlant.of(choose(Problem.of(experiments, i, max_dead_time, drift), structures))
        for i in range(len(columns.outputs))
    ]
    signals = _signals(experiments, columns, plants, units or {})
    document = fit_document(experiments, plants, signals, None if out is None else str(out))
    result = PlantFit(document, experiments, plants, signals)
    if targets[0] is not None:
        put(targets[0].parent, targets[0].name, result.study(law).encode())
    if targets[1] is not None:
        put_page(targets[1].parent, fit_page(result), targets[1].name)
    return result


def _names(given: str | Sequence[str]) -> tuple[str, ...]:
    return tuple(name.strip() for name in (given.split(",") if isinstance(given, str) else given))


def _numbers(given: float | Sequence[float] | None) -> tuple[float, ...]:
    if given is None:
        return ()
    return (float(given),) if isinstance(given, int | float) else tuple(float(each) for each in given)


def _structures(given: str | Sequence[str]) -> list[Structure]:
    names = [name for name in _names(given) if name] if given else []
    for name in names:
        check_name("structure", name, STRUCTURES, key="structure")
    # Each starts from the simpler ones before it.
    return [each for name, each in STRUCTURES.items() if name in names or not names]


def _check_targets(out: Path | None, report: Path | None) -> None:
    for path, ending in ((out, (".toml",)), (report, (".html", ".htm"))):
        if path is None:
            continue
        if path.suffix not in ending:
            raise InputError(f"give a name that ends in {ending[0]}", file=path)
        if path.exists():
            raise taken(path)


def _experiments(data: "str | Path | Sequence[str | Path] | pd.DataFrame", columns: Columns) -> list[Experiment]:
    if hasattr(data, "columns"):
        return [_of_frame(cast("pd.DataFrame", data), columns)]
    files = [data] if isinstance(data, str | Path) else list(data)  # pyright: ignore[reportArgumentType]
    if not 1 <= len(files) <= MAX_EXPERIMENTS:
        raise InputError(f"given {len(files)} files; allowed: 1 to {MAX_EXPERIMENTS}", key="data")
    return [read_experiment(Path(file), columns) for file in files]


def _of_frame(data: "pd.DataFrame", columns: Columns) -> Experiment:
    names = [str(name) for name in data.columns]
    for name in columns.all:
        check_name("column", name, names, key="data")
    time_name = columns.time or next((name for name in names if name.lower() in TIME_NAMES), "")
    if columns.period is not None:
        time = columns.period * np.arange(len(data))
    elif time_name:
        time = np.asarray(data[time_name], dtype=float)
    else:
        raise InputError("has no column of time; name it, or give the period", key="data")
    parts = [np.asarray(data[list(each)], dtype=float) for each in (columns.inputs, columns.outputs)]
    return make_experiment(time, *parts, before=columns.before)


def _signals(
    experiments: list[Experiment], columns: Columns, plants: list[FittedPlant], units: Mapping[str, str]
) -> Signals:
    for name in units:
        check_name("column", name, columns.all, key="units")
    inputs, outputs = (
        np.vstack([each.inputs for each in experiments]),
        np.vstack([each.outputs for each in experiments]),
    )
    middle = 0.5 * (inputs.min(axis=0) + inputs.max(axis=0))
    named = _identifiers([*columns.inputs, *columns.outputs])
    by_name = {new: units.get(old, "1") for new, old in zip(named, [*columns.inputs, *columns.outputs], strict=True)}
    n = len(columns.inputs)
    return Signals(
        tuple(named[:n]),
        tuple(named[n:]),
        by_name,
        np.column_stack([inputs.min(axis=0) - middle, inputs.max(axis=0) - middle]),
        np.ptp(outputs, axis=0),
        tuple(noise_parts(list(each.solution.residuals), experiments[0].period) for each in plants),
    )


def _identifiers(names: Sequence[str]) -> list[str]:
    """Return names that a plant's signals can have, each once."""
    unique: list[str] = []
    for name in names:
        plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_").lower() or "signal"
        plain = f"x_{plain}" if plain[0].isdigit() else plain
        count = 1
        while (plain if count == 1 else f"{plain}_{count}") in unique:
            count += 1
        unique.append(plain if count == 1 else f"{plain}_{count}")
    return unique
