"""The [[cost]] tables of a study: what a control step may take on a microcontroller.

The cost of a controller hangs on its laws and its control period, not on its gains: within one tuning study it is the same for
every candidate, so it is no objective but a limit that is kept or broken as a whole. It earns its place where laws or periods
differ, among contenders and from study to study. Values come from the packaged table only, so that a study finds the same with
and without a toolchain.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite

import numpy as np

from objectives.requirements import Array, Requirement, Screen
from objectives.system import System
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.scenarios import ScenarioSpec
from tuner.extensions.processor_cost.cost import TARGET, ProcessorCost, tabled
from tuner.study.requirement_kinds import RequirementKind
from tuner.study.schema import CostTable


@dataclass(frozen=True)
class CostQuantity:
    """A cost that can be limited. value(cost, control period [s]) -> number in that unit."""

    unit: str
    about: str
    value: Callable[[ProcessorCost, float], float]


QUANTITIES: dict[str, CostQuantity] = {
    "instructions": CostQuantity("1", "mean instructions of a control step", lambda c, h: c.instructions_step),
    "instructions_per_second": CostQuantity("1/s", "mean instructions a second", lambda c, h: c.per_second(h)),
    "text": CostQuantity("byte", "code and constants", lambda c, h: float(c.text_bytes)),
    "state": CostQuantity("byte", "state of the controller", lambda c, h: float(c.state_bytes)),
    "stack": CostQuantity("byte", "stack of a control step", lambda c, h: float(c.stack_bytes)),
}


def cost_screen(table: CostTable, system: System, _scenarios: tuple[ScenarioSpec, ...], _root: int) -> Screen:
    """Return the requirement of a [[cost]] table; raises InputError with the key inside the table."""
    if table.quantity not in QUANTITIES:
        raise UnknownNameError("cost", table.quantity, QUANTITIES, key="quantity")
    if not (isfinite(table.max) and table.max > 0.0):
        raise InputError(f"given {table.max:g}; a limit must be finite and above 0", key="max")
    quantity = QUANTITIES[table.quantity]
    value = quantity.value(_tabled_cost(system), system.timing.control_period)
    if table.hard and value > table.max:
        laws = f"{system.cascade.attitude.name} with {system.cascade.position.name}"
        message = (
            f"given {table.max:g} {quantity.unit}; {laws} takes {value:g} {quantity.unit} whatever its gains are, so no "
            "candidate can keep this: raise it, take laws that take less, or set hard = false"
        )
        raise InputError(message, key="max")
    requirement = Requirement(
        f"cost({table.quantity})", f"{quantity.about} on a {TARGET}", quantity.unit, table.max, "max", table.hard
    )

    def analyse(gains: Array) -> Array:
        return np.full((len(gains), 1), value)

    return Screen((requirement,), analyse)


def _tabled_cost(system: System) -> ProcessorCost:
    position, attitude = system.cascade.position.name, system.cascade.attitude.name
    cost = tabled(position, attitude)
    if cost is None:
        message = (
            f"the cost of {attitude} with {position} is not in the packaged table; count it once by "
            "python -m tuner.extensions.processor_cost.measure --write tuner/extensions/processor_cost/cortex_m4f.json"
        )
        raise InputError(message, key="quantity")
    return cost


KIND = RequirementKind(cost_screen, {})
