"""The [[margin]] tables of a plant study, and its margins."""

from collections.abc import Iterable, Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.margins.quantities import LIMITABLE
from objectives.margins.requirement import MarginRequirement, requirement_label
from objectives.plant_system import PlantSystem
from objectives.requirements import Screen
from plant.errors import InputError, UnknownNameError
from plant.model.scenario import PlantScenario, varied
from plant.records import paths
from plant.seeds import generator
from tuner.study.margins import MarginValues, check_amplitude, margin_limit
from tuner.study.schema import MarginTable
from tuner.text.input_errors import listed

if TYPE_CHECKING:
    from objectives.margins.describing import Case
    from objectives.margins.plant_margins import PlantMargins


# Most corners of a scenario's spread that margins are judged in: all of six parameters.
MAX_CORNERS = 64


def _margin(table: MarginTable, system: PlantSystem, specs: Sequence[PlantScenario]) -> MarginRequirement:
    if table.quantity not in LIMITABLE:
        raise UnknownNameError("margin", table.quantity, LIMITABLE, key="quantity")
    quantity, names = LIMITABLE[table.quantity], system.plan.names
    if table.axis is not None and table.axis not in names:
        raise UnknownNameError("channel", table.axis, names, key="axis")
    if table.spread and not spread_corners(system.parameters, specs):
        raise InputError("no scenario spreads a parameter; write spread.NAME, or leave spread out", key="spread")
    if "at" in table.model_fields_set:
        raise InputError("trims are those of quadrotors; a plant is judged at rest, so leave at out", key="at")
    check_amplitude(table)
    axes = () if quantity.is_multiloop else names if table.axis is None else (table.axis,)
    label = requirement_label(
        quantity.name, table.axis, hard=table.hard, spread=table.spread, amplitude=table.amplitude
    )
    limit = margin_limit(table, quantity)
    return MarginRequirement(quantity, label, axes, limit, table.hard, table.spread, table.amplitude)


def spread_corners(parameters: Any, specs: Iterable[PlantScenario]) -> list[Any]:
    """Return parameters at the corners of scenarios' spreads; of more than `MAX_CORNERS`, as many drawn ones.

    A corner is an end of each spread parameter and of each joint spread.
    """
    corners = dict.fromkeys(corner for spec in specs for corner in _corners_of(parameters, spec))
    return list(corners)


def _corners_of(parameters: Any, spec: PlantScenario) -> list[Any]:
    names = paths(type(parameters))
    wide = [i for i, name in enumerate(names) if spec.spread.get(name, 0.0) > 0.0]
    n = len(wide) + len(spec.joint_spread)
    if 2**n <= MAX_CORNERS:
        ends = np.array(list(product((-1.0, 1.0), repeat=n))) if n else np.empty((0, 0))
    else:
        ends = np.sign(generator(0, "margins/corners", 0).uniform(-1.0, 1.0, (MAX_CORNERS, n)))
    places = np.zeros((len(ends), len(names)))
    places[:, wide] = ends[:, : len(wide)]
    return [varied(spec, parameters, *corner) for corner in zip(places, ends[:, len(wide) :], strict=True)]


def margins_asked(
    tables: list[MarginTable], path: Path, system: PlantSystem, specs: Sequence[PlantScenario]
) -> tuple[MarginRequirement, ...]:
    """Return the requirements of the [[margin]] tables of a study; errors name path and key."""
    return tuple(listed("margin", path, tables, lambda entry: _margin(entry, system, specs)))


def margin_screen_of(
    required: tuple[MarginRequirement, ...],
    path: Path,
    system: PlantSystem,
    space: DecisionSpace,
    specs: Sequence[PlantScenario],
) -> Screen:
    """Return all requirements on margins as one screen; errors of its analysis name path and the key "margin"."""
    values = margin_values(required, path, system, space, specs).values
    return Screen(tuple(entry.requirement for entry in required), values)


def margin_values(
    required: tuple[MarginRequirement, ...],
    path: Path,
    system: PlantSystem,
    space: DecisionSpace,
    specs: Sequence[PlantScenario],
) -> MarginValues:
    """Return the values of requirements on the margins of a plant's loops; specs: scenarios with spreads."""

    def build(spread: bool, cases: "tuple[Case, ...]") -> "PlantMargins":
        return plant_margins(system, space, cases, spread_corners(system.parameters, specs) if spread else ())

    return MarginValues(required, build, path)


def plant_margins(
    system: PlantSystem, space: DecisionSpace, cases: "Sequence[Case] | None" = None, others: Sequence[Any] = ()
) -> "PlantMargins":
    """Return the margins of a plant's loops.

    Their structure is examined between the corners of the search. others: further parameters, whose worst counts.
    """
    # Here, because a study that asks for no margins needs no CasADi.
    from objectives.margins.describing import DEFAULT_CASES
    from objectives.margins.plant_margins import PlantMargins

    ends = [space.gains(np.full((1, len(space.variables)), end))[0] for end in (0.0, 1.0)]
    return PlantMargins(system, *ends, others=others, cases=DEFAULT_CASES if cases is None else cases)
