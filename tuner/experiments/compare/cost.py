"""Cost of a control step, counted and not timed: operations of the laws, and instructions of the whole step on a processor.

Operations are those of the laws' step functions as CasADi expressions: deterministic, the same on every machine, without the
cascade between the laws, which all contenders share. Instructions and memory come from the table of an extension.
"""

from functools import cache

import casadi as ca

from objectives.flown_system import FlownSystem
from plant.backends.symbolic import symbolic_function
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Law
from tuner.documents.comparison_document import ProcessorCount, StepCost
from tuner.study.step_costs import first_count

MEANING = (
    "scalar operations of one control step: the instructions of the CasADi expressions of the laws of three position and "
    "three attitude axes, inputs, outputs and constants not counted"
)
OF_CHANNELS = (
    "scalar operations of one control step in which every channel is due: the instructions of the CasADi expressions of their "
    "laws, inputs, outputs and constants not counted"
)


def step_cost(system: FlownSystem) -> StepCost:
    """Count the operations of a system's laws, and look up counted instructions."""
    counts = {name: step_operations(law) for name, law in system.laws.items()}
    operations = sum(len(system.axes.groups[name]) * count for name, count in counts.items())
    if not system.has_shared_laws:
        return StepCost(operations=operations, channels=counts, meaning=OF_CHANNELS)
    position, attitude = (law.name for law in system.laws.values())
    counted = first_count(position, attitude, system.timing.control_period)
    return StepCost(
        operations=operations,
        position=counts["position"],
        attitude=counts["attitude"],
        meaning=MEANING,
        processor=None if counted is None else ProcessorCount(**counted),
    )


@cache
def step_operations(law: Law) -> int:
    """Return the operations of one step of one axis."""
    kinds = [law.Memory, law.Constants, Channel, Setpoint, Measured, Applied, float]
    step = symbolic_function("step", law.step, kinds)
    moves = {ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST}
    return sum(step.instruction_id(i) not in moves for i in range(step.n_instructions()))
