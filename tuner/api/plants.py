"""Plants of one's own, from a module or a notebook's cell: their loops as a system that is flown, judged and exported."""

from collections.abc import Mapping, Sequence
from functools import partial

from objectives.plant_system import PlantSystem
from plant.law_registry import LAWS
from plant.model.linear import linear_plant, numbers_of
from plant.model.plan import Actuator, Channel, plan_loop
from plant.model.plant_model import plant_from
from tuner.exchange.c99.export import export_plant
from tuner.study.plant_study import with_timing

__all__ = ["LAWS", "Actuator", "Channel", "PlantSystem", "export_plant", "plant_system"]


def plant_system(
    names: Mapping[str, object] | object,
    name: str,
    channels: Sequence[Channel],
    actuators: Sequence[Actuator] = (),
    *,
    control_period: float,
    plant_step: float | None = None,
) -> PlantSystem:
    """Close the loops of a plant, as a study would.

    `make_study` makes a study of tables next to them.

    Args:
        names: State, Input, Parameters, Output, derivative and output, such as `globals()` of a notebook; or a
            linear system of python-control or scipy.signal.
        name: Name of the plant.
        channels: Its loops.
        actuators: Limits, rate, delay and lag of its inputs.
        control_period: [s].
        plant_step: [s], by default the longest that is accurate at rest.

    Raises:
        InputError: The plant or its loops do not fit together; the message has the line.

    """
    if isinstance(names, Mapping):
        plant = plant_from(names, name, str(names.get("__file__", "")))
    else:
        plant = linear_plant(name, numbers_of(names))
    plan = plan_loop(plant, channels, actuators)
    made = partial(PlantSystem, plant, plan, plant.parameters)
    return with_timing(made, plan.actuators, control_period, plant_step)
