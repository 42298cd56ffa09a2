"""The [[margin]] tables of a plant study, and its margins."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.margins.quantities import LIMITABLE
from objectives.margins.requirement import MarginRequirement, requirement_label
from objectives.plant_system import PlantSystem
from objectives.requirements import Screen
from plant.errors import InputError, UnknownNameError
from tuner.study.margins import MarginValues, check_amplitude, margin_limit
from tuner.study.schema import MarginTable
from tuner.text.input_errors import listed

if TYPE_CHECKING:
    from objectives.margins.describing import Case
    from objectives.margins.plant_margins import PlantMargins


def _margin(table: MarginTable, system: PlantSystem) -> MarginRequirement:
    if table.quantity not in LIMITABLE:
        raise UnknownNameError("margin", table.quantity, LIMITABLE, key="quantity")
    quantity, names = LIMITABLE[table.quantity], system.plan.names
    if table.axis is not None and table.axis not in names:
        raise UnknownNameError("channel", table.axis, names, key="axis")
    if table.spread:
        raise InputError("margins over a spread are those of quadrotors; leave spread out", key="spread")
    if "at" in table.model_fields_set:
        raise InputError("trims are those of quadrotors; a plant is judged at rest, so leave at out", key="at")
    check_amplitude(table)
    axes = () if quantity.is_multiloop else names if table.axis is None else (table.axis,)
    label = requirement_label(quantity.name, table.axis, hard=table.hard, amplitude=table.amplitude)
    limit = margin_limit(table, quantity)
    return MarginRequirement(quantity, label, axes, limit, table.hard, amplitude=table.amplitude)


def margins_asked(tables: list[MarginTable], path: Path, system: PlantSystem) -> tuple[MarginRequirement, ...]:
    """Return the requirements of the [[margin]] tables of a study; errors name path and key."""
    return tuple(listed("margin", path, tables, lambda entry: _margin(entry, system)))


def margin_screen_of(
    required: tuple[MarginRequirement, ...], path: Path, system: PlantSystem, space: DecisionSpace
) -> Screen:
    """Return all requirements on margins as one screen; errors of its analysis name path and the key "margin"."""
    return Screen(tuple(entry.requirement for entry in required), margin_values(required, path, system, space).values)


def margin_values(
    required: tuple[MarginRequirement, ...], path: Path, system: PlantSystem, space: DecisionSpace
) -> MarginValues:
    """Return the values of requirements on the margins of a plant's loops."""
    return MarginValues(required, lambda _, cases: plant_margins(system, space, cases), path)


def plant_margins(system: PlantSystem, space: DecisionSpace, cases: "Sequence[Case] | None" = None) -> "PlantMargins":
    """Return the margins of a plant's loops.

    Their structure is examined between the corners of the search.
    """
    # Here, because a study that asks for no margins needs no CasADi.
    from objectives.margins.describing import DEFAULT_CASES
    from objectives.margins.plant_margins import PlantMargins

    ends = [space.gains(np.full((1, len(space.variables)), end))[0] for end in (0.0, 1.0)]
    return PlantMargins(system, *ends, cases=DEFAULT_CASES if cases is None else cases)
