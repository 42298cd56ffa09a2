"""Cost of a control step, counted and not timed: operations of the laws, and instructions of the whole step on a processor.

Operations are those of the laws' step functions as CasADi expressions: deterministic, the same on every machine, without the
cascade between the laws, which all contenders share. Instructions, memory and what a compiler makes of it come from the packaged
table of `tuner.exchange.processor_cost`.
"""

from dataclasses import dataclass
from functools import cache

from plant.cascade import ATTITUDE_AXES, POSITION_AXES, Cascade
from plant.laws import Law
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from tuner.study.processor_cost.cost import Cost as Processor
from tuner.study.processor_cost.cost import tabled

MEANING = (
    "scalar operations of one control step: the instructions of the CasADi expressions of the laws of three position and "
    "three attitude axes, inputs, outputs and constants not counted"
)


@dataclass(frozen=True)
class Cost:
    """Operations of one axis of each loop, and of a control step.

    processor: instructions and bytes on a microcontroller; None for laws younger than the packaged table.
    """

    position: int
    attitude: int
    processor: Processor | None = None

    @property
    def operations(self) -> int:
        """Operations of the three position and three attitude axes."""
        return len(POSITION_AXES) * self.position + len(ATTITUDE_AXES) * self.attitude


def cost_of(cascade: Cascade) -> Cost:
    """Count the operations of a cascade's laws and look up its instructions."""
    known = tabled(cascade.position.name, cascade.attitude.name)
    return Cost(step_operations(cascade.position), step_operations(cascade.attitude), known)


@cache
def step_operations(law: Law) -> int:
    """Return the operations of one step of one axis."""
    import casadi as ca

    from plant.backends.symbolic import symbolic_function

    kinds = [law.Memory, law.Constants, Channel, Setpoint, Measured, Applied, float]
    step = symbolic_function("step", law.step, kinds)
    moves = {ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST}
    return sum(step.instruction_id(i) not in moves for i in range(step.n_instructions()))
