"""The table [[disturbance_gain]] as a requirement."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from objectives.requirements import Array, Requirement, Screen
from plant.errors import InputError
from plant.model.scenario import PlantScenario
from tuner.extensions.disturbance_gains.response import DisturbanceResponse
from tuner.study.plant_margins import spread_corners
from tuner.study.requirement_kinds import RequirementKind


def gain_screen(table: Any, system: Any, scenarios: Sequence[PlantScenario], root: int) -> Screen:  # noqa: ARG001
    """Return the requirement of a table: the largest gain of the nominal plant and, if wanted, of those in the spread."""
    plants = [system.parameters, *(_corners(system, scenarios) if table.spread else [])]
    responses = [DisturbanceResponse(system, table.disturbance, table.output, each) for each in plants]
    plant = system.plant
    units = plant.unit(f"Output.{table.output}"), plant.unit(f"Disturbance.{table.disturbance}")
    label = f"disturbance_gain({table.disturbance}, {table.output}{', spread' if table.spread else ''})"
    quantity = f"largest gain over frequency from {table.disturbance} to {table.output}"
    requirement = Requirement(label, quantity, _ratio(*units), table.max, "max", table.hard)

    def analyse(gains: Array) -> Array:
        return np.max([response.peaks(gains) for response in responses], axis=0)[:, None]

    return Screen((requirement,), analyse)


def _corners(system: Any, scenarios: Sequence[PlantScenario]) -> list[Any]:
    corners = spread_corners(system.parameters, scenarios)
    if not corners:
        raise InputError("no scenario spreads a parameter; write spread.NAME, or leave spread out", key="spread")
    return corners


def _ratio(unit: str, by: str) -> str:
    if unit == by:
        return "1"
    return unit if by == "1" else f"{unit}/({by})" if " " in by or "/" in by else f"{unit}/{by}"


KIND = RequirementKind(gain_screen, {})
