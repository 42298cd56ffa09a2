"""Interface of a target that can fly an experiment."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from tuner.analysis.flight_plan.choosing import TargetCapabilities
from tuner.analysis.flight_plan.excitation import Excitation
from tuner.analysis.flight_plan.flying import SimulatedVehicle


@dataclass(frozen=True)
class ExcitationTarget:
    """A target.

    ability: what it can excite. files(excitations, craft): relative name -> content. notes: a sentence each, on how to fly it and
    what differs from the simulated flight.
    """

    name: str
    capabilities: TargetCapabilities
    files: Callable[[Sequence[Excitation], SimulatedVehicle], Mapping[str, bytes]]
    notes: tuple[str, ...]
