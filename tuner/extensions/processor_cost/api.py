"""`tuner.cost`: the cost of a control step on a processor, from the packaged table or counted now."""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from plant.law_registry import LAWS
from tuner.api import POSITION_LAW
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import GainsLike, as_gains, default_gains
from tuner.documents.parts import NumberWithUnit
from tuner.extensions.processor_cost.cost import MEANING, tabled
from tuner.extensions.processor_cost.measure import measure_cost
from tuner.gains import Controller
from tuner.store.document import DocumentPart

if TYPE_CHECKING:
    import pandas as pd


class CostRow(DocumentPart):
    """Cost of a controller; measured: counted just now, not from the packaged table; counts as in `StepCost`."""

    position: str
    attitude: str
    control_period: NumberWithUnit
    instructions_per_second: float
    measured: bool
    target: str
    instructions_attitude: float
    most_attitude: int
    instructions_step: float
    most_step: int
    text_bytes: int
    state_bytes: int
    stack_bytes: int
    compiler: str
    emulator: str
    flags: str


class CostDocument(DocumentPart):
    """Cost of control steps; meaning: of the counts."""

    meaning: str
    costs: list[CostRow]


@dataclass(frozen=True)
class Cost(Documented):
    """Cost of control steps on a Cortex-M4F; document: as `tuner cost --json` prints it."""

    document: CostDocument

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each controller: instructions of a step, bytes of code, state and stack."""
        return frame(self.document.costs, ("position", "attitude"))

    def _repr_html_(self) -> str:
        return shown("Cost of a control step", [f"Counted: {MEANING}."], self.table.reset_index())


def cost(gains: GainsLike | None = None, *, position: str = POSITION_LAW, measure: bool = False) -> Cost:
    """Tell what a control step costs on a Cortex-M4F.

    Args:
        gains: Gains, or a gains.json; by default every attitude law with its default gains.
        position: Position law of the latter.
        measure: Whether to count now, with arm-none-eabi-gcc and qemu-system-arm, instead of reading the packaged table.

    Returns:
        Instructions and bytes, a row for each controller.

    Raises:
        InputError: The gains are wrong, or compiler or emulator are missing.

    Examples:
        >>> tuner.cost(gains).document.costs[0].target
        'Cortex-M4F'

    """
    if gains is None:
        controllers = [default_gains(law, position).controller for law in LAWS]
    else:
        controllers = [
            as_gains(gains).quadrotor(
                "holds gains of a plant of one's own, and steps are counted of a quadrotor's laws; export it to c99, whose "
                "Makefile builds the code for a Cortex-M4F (`make arm`)"
            )
        ]
    return Cost(CostDocument(meaning=MEANING, costs=[cost_row(controller, measure) for controller in controllers]))


def cost_row(controller: Controller, measure: bool) -> CostRow:
    """Return the cost of a controller with its laws and its period; measured where asked for, or where the table has none."""
    position, attitude = controller.cascade.position.name, controller.cascade.attitude.name
    packaged = None if measure else tabled(position, attitude)
    if packaged is None:
        cost = measure_cost(controller)
    else:
        cost = packaged
    return CostRow(
        position=position,
        attitude=attitude,
        control_period=NumberWithUnit(value=controller.control_period, unit="s"),
        instructions_per_second=cost.per_second(controller.control_period),
        measured=packaged is None,
        **vars(cost),
    )
