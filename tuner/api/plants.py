"""Plants of one's own, from a module or a notebook's cell: their loops as a system that is flown, judged and exported."""

from collections.abc import Mapping, Sequence
from typing import Any

from objectives.plant_system import PlantSystem
from plant.errors import InputError
from plant.laws import LAWS
from plant.loop import Timing
from plant.model.plan import Actuator, Channel, plan_loop
from plant.model.plant_model import plant_from
from tuner.exchange.c99.plant_export import export_plant

__all__ = ["LAWS", "Actuator", "Channel", "PlantSystem", "export_plant", "plant_system"]

# Plant steps in a control period, where nothing else is asked for; a margin of stability for poles near the control rate.
STEPS = 4


def plant_system(
    names: Mapping[str, Any],
    name: str,
    channels: Sequence[Channel],
    actuators: Sequence[Actuator] = (),
    *,
    control_period: float,
    plant_step: float | None = None,
) -> PlantSystem:
    """Close the loops of the plant that names describe.

    Args:
        names: State, Input, Parameters, Output, derivative and output, such as `globals()` of a notebook.
        name: Of the plant.
        channels: Its loops.
        actuators: Limits, rate, delay and lag of its inputs.
        control_period: [s].
        plant_step: [s], by default a quarter of the control period.

    Raises:
        InputError: The plant or its loops do not fit together; the message has the line.

    """
    timing = Timing(control_period, plant_step or control_period / STEPS)
    if not timing.plant_step > 0.0 or abs(timing.steps * timing.plant_step - control_period) > 1e-9 * control_period:
        raise InputError(
            f"given {timing.plant_step:g} s; a whole number of plant steps must make the control period of {control_period:g} s",
            key="plant_step",
        )
    plant = plant_from(names, name, str(names.get("__file__", "")))
    return PlantSystem(plant, plan_loop(plant, channels, actuators), plant.parameters, timing)
