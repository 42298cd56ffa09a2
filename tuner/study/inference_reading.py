"""From a contest file with [[unknown]] tables to what runs; errors name the file and the key to change.

An [[unknown]] table says which values of the contest it sets; here their places are found, and the ends between which they move.
"""

from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np

from objectives.decisions import Variable
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.gains import GROUPS
from plant.texts import PlainValue
from tuner.search.names import AUTOMATIC
from tuner.study.contest import Contest
from tuner.study.contest_reading import checked_tables, contest_from_layers, contest_from_table
from tuner.study.contest_schema import INFERENCE_TABLES, InferenceTable, SettingsTable, UnknownTable
from tuner.study.inference import Cell, Inference, Unknown
from tuner.study.layers import Layer
from tuner.study.plant_study import PlantStudy
from tuner.study.search_reading import search_of
from tuner.study.size import ScenarioSize, check_size, flight_steps
from tuner.study.study import SearchSpec, TuningStudy
from tuner.study.unknown_paths import CONTENDER, GAINS, Place, place_of, value_at
from tuner.text.input_errors import located
from tuner.text.toml_text import tables_in


def inference_from_layers(path: Path, layers: tuple[Layer, ...], overrides: Mapping[str, PlainValue]) -> Inference:
    """Check an inference whose files have been read."""
    if any(PlantStudy.kind in layer.table for layer in layers):
        raise InputError("an inference is of quadrotors; leave [[unknown]] out for a contest", file=path, key="unknown")
    complete = contest_from_layers(path, layers, overrides)
    tables = checked_tables(InferenceTable, complete.table, path)
    with located(path, ""):
        contest = _chosen(complete, tables.inference)
        cells = _cells(contest)
        _refuse_searched(contest)
        flown = {cell.contender for cell in cells}
        unknowns = unknowns_of(tables.unknown, complete, contest)
        settings = tables.inference
        with located(None, "search"):
            kinds = len({cell.metric.metric.name for cell in cells})
            search = _search(contest.base, len(unknowns), kinds)
        inference = Inference(
            contest, unknowns, cells, search, settings.flights, settings.held_out, settings.near, complete.table
        )
        with located(None, "search"):
            _check_size(inference)
        for i in range(len(unknowns)):
            check_range(inference, i, flown)
    return inference


def _chosen(contest: Contest, settings: SettingsTable) -> Contest:
    """Return the contest of the chosen contenders, with their published numbers."""
    names = [contender.name for contender in contest.contenders]
    chosen = names if settings.contenders is None else settings.contenders
    for i, name in enumerate(chosen):
        if name not in names:
            raise UnknownNameError("contender", name, names, key=f"inference.contenders[{i}]")
    table = deepcopy(contest.table)
    contenders = zip(tables_in(table.get("contender")), names, strict=True)
    published = zip(tables_in(table.get("published")), contest.published, strict=True)
    individual = {
        "contender": [raw for raw, name in contenders if name in chosen],
        "published": [
            {**raw, "contender": [name for name in cell.contenders if name in chosen]}
            for raw, cell in published
            if any(name in chosen for name in cell.contenders)
        ],
    }
    left = {key: value for key, value in table.items() if key not in ("claim", *INFERENCE_TABLES)}
    return contest_from_table(contest.path, {**left, **individual})


def _search(base: TuningStudy, unknowns: int, kinds: int) -> SearchSpec:
    """Return the search for so many unknowns and kinds of misfit; left open it is nsga2, for no other was measured on misfits."""
    table = base.table.search
    if table.starts:
        raise InputError("an inference starts from no earlier run; leave it out", key="starts")
    if table.reference:
        raise InputError("misfits have no reference point; leave it out", key="reference")
    if table.algorithm == AUTOMATIC:
        table = table.model_copy(update={"algorithm": "nsga2"})
    return search_of(table, unknowns, kinds, 0)


def _check_size(inference: Inference) -> None:
    base, timing = inference.contest.base, inference.contest.base.system.timing
    flown = [
        ScenarioSize(
            flight_steps(entry.spec, timing) * len(inference.contest.contenders), inference.flights, inference.held_out
        )
        for entry in base.scenarios
    ]
    check_size(inference.search.population, inference.search.generations, flown)


def _cells(contest: Contest) -> tuple[Cell, ...]:
    """Return the published numbers, one cell for each contender of a number."""
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


# What decides a flight; an unknown anywhere else would move no cell.
TABLES = (CONTENDER, "controller", GAINS, "limits", "scenario")


def unknowns_of(tables: list[UnknownTable], complete: Contest, chosen: Contest) -> tuple[Unknown, ...]:
    """Return the unknowns; chosen: the contest of the chosen contenders. Raises InputError with the key inside the file."""
    unknowns: list[Unknown] = []
    for i, table in enumerate(tables):
        key = f"unknown[{i}]"
        names = [unknown.variable.name for unknown in unknowns]
        if table.name in names:
            raise InputError(
                f"'{table.name}' is unknown[{names.index(table.name)}] too; change one name", key=f"{key}.name"
            )
        unknowns.append(_unknown(table, complete, chosen, key))
        _refuse_shared_places(unknowns, key)
    return tuple(unknowns)


def check_range(inference: Inference, index: int, flown: set[str]) -> None:
    """Build the contest at either end of an unknown's range.

    The other unknowns are at their defaults.
    Raises InputError where it cannot be built, or where none of the contenders in `flown` differs between the two.
    """
    variable, digests = inference.unknowns[index].variable, []
    for end in ("low", "high"):
        values = np.array(inference.space.base)
        values[index] = getattr(variable, end)
        try:
            studies = inference.studies(values)
        except InputError as error:
            where = f"{error.key}: " if error.key else ""
            message = f"given {values[index]:g}, which the study does not take: {where}{error.message}"
            raise InputError(message, key=f"unknown[{index}].{end}") from None
        digests.append([study.digest() for name, study in studies.items() if name in flown])
    if digests[0] == digests[1]:
        raise InputError(
            f"no contender with a published cell flies differently whatever '{variable.name}' is; set what it uses",
            key=f"unknown[{index}].set",
        )


def _unknown(table: UnknownTable, complete: Contest, chosen: Contest, key: str) -> Unknown:
    variable = _variable(table, key)
    if not table.set:
        raise InputError('given an empty list; write for instance set = ["gains.attitude.k2"]', key=f"{key}.set")
    places, defaults = [], []
    for j, path in enumerate(table.set):
        try:
            places.append(_place(complete, path))
            defaults.append(_default(complete, path, places[-1]))
        except InputError as error:
            raise error.located(key=f"{key}.set[{j}]") from None
        if defaults[j] != defaults[0]:
            raise InputError(
                f"'{path}' stands at {defaults[j]:g} and '{table.set[0]}' at {defaults[0]:g}; one unknown is one number: give "
                "both the same, or make two unknowns of them",
                key=f"{key}.set[{j}]",
            )
        if not variable.low <= defaults[j] <= variable.high:
            raise InputError(
                f"'{path}' stands at {defaults[j]:g} {table.unit}, outside of low = {variable.low:g} to high = "
                f"{variable.high:g}; widen the range, or start from a value inside",
                key=f"{key}.set[{j}]",
            )
    flown = _flown(places, complete, chosen)
    if not flown:
        names = ", ".join(contender.name for contender in chosen.contenders)
        message = f"'{variable.name}' sets only contenders that are left out; chosen are: {names}"
        raise InputError(message, key=f"{key}.set")
    return Unknown(variable, table.unit, tuple(places), flown, defaults[0])


def _flown(places: list[Place], complete: Contest, chosen: Contest) -> tuple[Place, ...]:
    """Return the places in the contest of the chosen contenders; those of contenders that are left out are not among them."""
    names = [contender.name for contender in chosen.contenders]
    flown: list[Place] = []
    for place in places:
        if place[0] != CONTENDER:
            flown.append(place)
            continue
        name = complete.contenders[int(place[1])].name
        if name in names:
            flown.append((CONTENDER, names.index(name), *place[2:]))
    return tuple(flown)


def _variable(table: UnknownTable, key: str) -> Variable:
    if not table.name.strip():
        raise InputError('given an empty name; write for instance name = "k2"', key=f"{key}.name")
    try:
        return Variable(table.name, tuple(table.set), table.low, table.high, table.scale)
    except InputError as error:
        raise InputError(error.message, key=key) from None


def _place(contest: Contest, path: str) -> Place:
    head = path.partition(".")[0]
    if head not in TABLES:
        raise UnknownNameError("table to look for an unknown in", head, TABLES)
    place = place_of(contest.table, path)
    if place[0] == CONTENDER and place[2] == GAINS and GAINS in contest.table:
        entry = tables_in(contest.table[CONTENDER])[int(place[1])]
        if GAINS not in entry:
            line = f"{GAINS}.{place[3]}" if len(place) > 3 else GAINS
            message = f"'{entry['name']}' has no gains of its own and would lose those that all share; write {line}"
            raise InputError(message)
    return place


def _default(contest: Contest, path: str, place: Place) -> float:
    """Return the number at a place: the one given, else the one that it has by default."""
    given = value_at(contest.table, place)
    if given is None:
        given = _resolved(contest, path, place)
    if isinstance(given, bool) or not isinstance(given, int | float):
        raise InputError(f"'{path}' holds {given!r}; an unknown is a number")
    return float(given)


def _resolved(contest: Contest, path: str, place: Place) -> Any:
    """Return the default of a key that is not given."""
    entries = tables_in(contest.table[CONTENDER])
    if place[0] == CONTENDER:
        studies, inner = [contest.contenders[int(place[1])].study], place[2:]
    else:
        takes = [GAINS not in entry if place[0] == GAINS else True for entry in entries]
        studies = [
            contender.study for contender, individual in zip(contest.contenders, takes, strict=True) if individual
        ]
        inner = place
    if inner[:1] == (GAINS,):
        return _resolved_gain(studies, path, str(inner[1]))
    content = value_at(studies[0].table.model_dump(), inner)
    if content is None:
        raise InputError(f"there is no '{path}', and no default of it to start from; give it a number in the study")
    return content


def _resolved_gain(studies: list[TuningStudy], path: str, key: str) -> float:
    """Return the default of a gain, or of a group's gains."""
    if not studies:
        message = f"'{path}' moves nothing: every contender has gains of its own; write contender.NAME.{path}"
        raise InputError(message)
    group, _, name = key.partition(".")
    wanted = {f"{axis}.{name}" for axis in GROUPS.get(group, ())}
    for study in studies:
        gains = study.system.gains
        values = {study.space.base[gain.column] for gain in gains if gain.address in wanted}
        if len(values) == 1:
            return values.pop()
        if values:
            raise InputError(f"'{path}' stands for gains of different values; give it a number in the study")
    names = sorted({gain.address for study in studies for gain in study.system.gains})
    raise UnknownNameError("gain", key, names)


def _refuse_shared_places(unknowns: list[Unknown], key: str) -> None:
    *before, last = unknowns
    taken = {place: unknown.variable.name for unknown in before for place in unknown.places}
    for j, place in enumerate(last.places):
        owner = taken.get(place) or (last.variable.name if place in last.places[:j] else None)
        if owner is not None:
            path = last.variable.addresses[j]
            raise InputError(f"'{path}' is set by '{owner}' already; leave one out", key=f"{key}.set[{j}]")
