"""From a contest file with [[unknown]] tables to what runs; errors name the file and the key to change."""

from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from plant.errors import InputError, UnknownNameError
from tuner.search.names import check_algorithm
from tuner.study.contest import Contest
from tuner.study.contest_reading import contest_from_layers, contest_from_table
from tuner.study.inference import Cell, Inference
from tuner.study.inference_schema import ADDED, InferenceTable, SettingsTable
from tuner.study.layers import Layer, read_layers
from tuner.study.messages import translated
from tuner.study.size import Flown, check_size, flight_steps
from tuner.study.unknowns import check_range, unknowns_of
from tuner.text.input_errors import check_magnitudes, located


def load_inference(path: Path, overrides: Mapping[str, Any] | None = None) -> Inference:
    """Read and check an inference file; overrides: dotted keys, as for a contest.

    Every unknown is tried at its default and at both ends of its range. Raises InputError naming file and key.
    """
    return inference_from_layers(path, read_layers(path), overrides or {})


def inference_from_layers(path: Path, layers: tuple[Layer, ...], overrides: Mapping[str, Any]) -> Inference:
    """Check an inference whose files have been read."""
    whole = contest_from_layers(path, layers, overrides)
    tables = _tables(path, whole.table)
    with located(path, ""):
        contest = _chosen(whole, tables.inference)
        cells = _cells(contest)
        _refuse_searched(contest)
        flown = {cell.contender for cell in cells}
        unknowns = unknowns_of(tables.unknown, whole, contest)
        settings = tables.inference
        inference = Inference(contest, unknowns, cells, settings.flights, settings.held_out, settings.near, whole.table)
        with located(None, "search"):
            check_algorithm(contest.base.search.algorithm, len(inference.kinds))
            _check_size(inference)
        for i in range(len(unknowns)):
            check_range(inference, i, flown)
    return inference


def _tables(path: Path, table: dict[str, Any]) -> InferenceTable:
    if "unknown" not in table:
        raise InputError("nothing is unknown here; give at least one [[unknown]]", file=path, key="unknown")
    try:
        tables = InferenceTable.model_validate({key: table[key] for key in ADDED if key in table})
    except ValidationError as error:
        raise translated(error, path, InferenceTable) from None
    check_magnitudes({key: table[key] for key in ADDED if key in table}, path)
    return tables


def _chosen(contest: Contest, settings: SettingsTable) -> Contest:
    """Return the contest with the chosen contenders and what was published of them."""
    names = [contender.name for contender in contest.contenders]
    chosen = names if settings.contenders is None else settings.contenders
    for i, name in enumerate(chosen):
        if name not in names:
            raise UnknownNameError("contender", name, names, key=f"inference.contenders[{i}]")
    table = deepcopy(contest.table)
    table["contender"] = [entry for entry in table["contender"] if entry["name"] in chosen]
    table["published"] = [
        {**raw, "contender": [name for name in cell.contenders if name in chosen]}
        for raw, cell in zip(table.get("published", []), contest.published, strict=True)
        if any(name in chosen for name in cell.contenders)
    ]
    for key in ("claim", *ADDED):
        table.pop(key, None)
    return contest_from_table(contest.path, table)


def _check_size(inference: Inference) -> None:
    base, timing = inference.contest.base, inference.contest.base.system.timing
    flown = [
        Flown(
            flight_steps(entry.spec, timing) * len(inference.contest.contenders), inference.flights, inference.held_out
        )
        for entry in base.scenarios
    ]
    check_size(base.search.population, base.search.generations, flown)


def _cells(contest: Contest) -> tuple[Cell, ...]:
    """Return the published numbers, one cell for each contender that they are printed of."""
    cells: list[Cell] = []
    for i, entry in enumerate(contest.published):
        if entry.value <= 0.0:
            raise InputError(
                f"given {entry.value:g}; an inference compares by ratio, so give the magnitude, above 0",
                key=f"published[{i}].value",
            )
        for name in entry.contenders:
            cell = Cell(name, entry.metric, entry.scenario, entry.value)
            if cell.label in [other.label for other in cells]:
                raise InputError(f"'{cell.label}' is published twice; leave one out", key=f"published[{i}]")
            cells.append(cell)
    if not cells:
        raise InputError(
            "nothing is published of these contenders; give at least one [[published]] cell to infer from",
            key="published",
        )
    return tuple(cells)


def _refuse_searched(contest: Contest) -> None:
    for i, contender in enumerate(contest.contenders):
        if contender.tuned:
            searched = ", ".join(variable.name for variable in contender.study.space.variables)
            raise InputError(
                f"contender '{contender.name}' searches {searched}; an inference flies gains as given: give a number, and an "
                "[[unknown]] where it is not known",
                key=f"contender[{i}].gains",
            )
