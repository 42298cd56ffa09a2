"""Cost of a control step, counted and not timed: operations of the laws, and instructions of the whole step on a processor.

Operations are those of the laws' step functions as CasADi expressions: deterministic, the same on every machine, without the
cascade between the laws, which all contenders share. Instructions, memory and what a compiler makes of it come from the packaged
table of `tuner.exchange.processor_cost`.
"""

from functools import cache, singledispatch
from typing import Any

import casadi as ca

from objectives.plant_system import PlantSystem
from objectives.system import System
from plant.backends.symbolic import symbolic_function
from plant.cascade import ATTITUDE_AXES, POSITION_AXES
from plant.laws import Law
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from tuner.documents.contest_document import ProcessorCount, StepCost
from tuner.study.processor_cost.cost import MEANING as PROCESSOR_MEANING
from tuner.study.processor_cost.cost import ProcessorCost, tabled

MEANING = (
    "scalar operations of one control step: the instructions of the CasADi expressions of the laws of three position and "
    "three attitude axes, inputs, outputs and constants not counted"
)
OF_CHANNELS = (
    "scalar operations of one control step in which every channel is due: the instructions of the CasADi expressions of their "
    "laws, inputs, outputs and constants not counted"
)


@singledispatch
def step_cost(system: Any) -> StepCost:
    """Count the operations of the laws of a system, and look up its instructions where they are packaged."""
    raise TypeError(f"nothing counts the operations of {type(system).__name__}")


@step_cost.register
def _(system: PlantSystem) -> StepCost:
    channels = {channel.name: step_operations(channel.law) for channel in system.plan.channels}
    return StepCost(operations=sum(channels.values()), channels=channels, meaning=OF_CHANNELS)


@step_cost.register
def _(system: System) -> StepCost:
    cascade = system.cascade
    position, attitude = step_operations(cascade.position), step_operations(cascade.attitude)
    known = tabled(cascade.position.name, cascade.attitude.name)
    return StepCost(
        operations=len(POSITION_AXES) * position + len(ATTITUDE_AXES) * attitude,
        position=position,
        attitude=attitude,
        meaning=MEANING,
        processor=None if known is None else processor_count(known, system.timing.control_period),
    )


def processor_count(cost: ProcessorCost, control_period: float) -> ProcessorCount:
    """Return instructions and bytes on a microcontroller, a step and a second."""
    rate = cost.per_second(control_period)
    return ProcessorCount(**vars(cost), instructions_per_second=rate, meaning=PROCESSOR_MEANING)


@cache
def step_operations(law: Law) -> int:
    """Return the operations of one step of one axis."""
    kinds = [law.Memory, law.Constants, Channel, Setpoint, Measured, Applied, float]
    step = symbolic_function("step", law.step, kinds)
    moves = {ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST}
    return sum(step.instruction_id(i) not in moves for i in range(step.n_instructions()))
