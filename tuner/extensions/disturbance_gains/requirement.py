"""The table [[disturbance_gain]] as a requirement."""

from typing import Any

from objectives.requirements import Array, Requirement, Screen
from tuner.extensions.disturbance_gains.response import DisturbanceResponse
from tuner.study.requirement_kinds import RequirementKind


def gain_screen(table: Any, system: Any, scenarios: object, root: int) -> Screen:  # noqa: ARG001
    """Return the requirement of a table."""
    response = DisturbanceResponse(system, table.disturbance, table.output)
    plant = system.plant
    units = plant.unit(f"Output.{table.output}"), plant.unit(f"Disturbance.{table.disturbance}")
    label = f"disturbance_gain({table.disturbance}, {table.output})"
    quantity = f"largest gain over frequency from {table.disturbance} to {table.output}"
    requirement = Requirement(label, quantity, _ratio(*units), table.max, "max", table.hard)

    def analyse(gains: Array) -> Array:
        return response.peaks(gains)[:, None]

    return Screen((requirement,), analyse)


def _ratio(unit: str, by: str) -> str:
    if unit == by:
        return "1"
    return unit if by == "1" else f"{unit}/({by})" if " " in by or "/" in by else f"{unit}/{by}"


KIND = RequirementKind(gain_screen, {})
