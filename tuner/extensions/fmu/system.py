"""An FMU under study: a plant's system whose flights and slopes come from worker processes."""

import platform
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.plant_system import PlantSystem
from plant.backends.identity import identity
from plant.errors import InputError, require_package
from plant.loop import Timing
from plant.model.closing import resting
from plant.records import flatten
from tuner.extensions.fmu.archive import unpacked
from tuner.extensions.fmu.flyer import FmuFlyer
from tuner.extensions.fmu.fmu_model import FmuModel
from tuner.extensions.fmu.loop_description import LoopDescription, describe_loop
from tuner.extensions.fmu.messages import Linearize, Refused
from tuner.extensions.fmu.process import FmuProcess, WorkerLostError
from tuner.study.plant_schema import PATIENCE

if TYPE_CHECKING:
    from plant.model.slope import Slope


@dataclass(frozen=True)
class FmuSystem(PlantSystem):
    """An FMU, the plan of its loops, its parameters and its timing. patience: seconds that a flight may take."""

    order = 2
    has_equations = False

    plant: FmuModel
    patience: float = PATIENCE

    @property
    def min_steps(self) -> int:
        """One, for the FMU chooses steps of its own."""
        return 1

    def checked_timing(self, is_given: bool) -> Timing:  # noqa: ARG002
        """Return its periods; InputError for a lag that settles within a step, over which the FMU feels its mean."""
        step, period = self.timing.plant_step, self.timing.control_period
        for actuator in self.plan.actuators:
            if 0.0 < actuator.lag < 0.5 * step:
                raise InputError(
                    f"given {step:g} s; it must be at most twice the lag of {actuator.name}, {actuator.lag:g} s: write "
                    f"plant_step = {period / ceil(0.5 * period / actuator.lag):.12g}, or lag = 0",
                    key="plant_step",
                )
        return self.timing

    @property
    def own_code(self) -> None:
        """Nothing: raises InputError, for no other machine is given an FMU."""
        raise InputError("an FMU flies in processes of this machine; leave --dask out")

    @property
    def arithmetic(self) -> str:
        """Name of its bits: the machine code is the FMU's own for this kind of machine."""
        return f"fmu {platform.system().lower()} {platform.machine().lower()}"

    def flyer(self, threads: int | None = None) -> FmuFlyer:
        """Return its flyer: so many worker processes, by default one for each core."""
        return FmuFlyer(self, self.process, self.patience, threads)

    def ask(self, request: Any) -> Any:
        """Return the answer of a worker of its own to one request; InputError where the FMU refuses it or does not survive it."""
        process = self.process()
        try:
            answer = process.ask(request, self.patience)
        except WorkerLostError as error:
            raise InputError(f"{error}; try it in the tool that made it", file=self.plant.file) from None
        finally:
            process.close()
        if isinstance(answer, Refused):
            raise InputError(answer.why, file=None if answer.key else self.plant.file, key=answer.key)
        return answer

    def slope(self, parameters: Any) -> "Slope":
        """Return the FMU's initial state and its derivative a period later: by body and commands."""
        return self.ask(Linearize(np.array(flatten(resting(self.loop, parameters)[0]), dtype=float)))

    def flown_slope(self, parameters: Any) -> "Slope":
        """Return the slope again: the steps of an FMU are its own."""
        return self.slope(parameters)

    def process(self) -> FmuProcess:
        """Return a worker process that is not started yet; MissingPackageError where FMPy is not installed."""
        require_package("fmpy", "fmu", key="tuner.extensions.fmu")
        return FmuProcess(*self._loop_description, self.plant.file)

    @cached_property
    def _loop_description(self) -> tuple[LoopDescription, str]:
        """The loop's description for its workers, and its identity.

        They must build a loop of that identity.
        """
        interface = self.plant.interface
        folder = unpacked(Path(self.plant.file), interface.digest)
        return describe_loop(interface, folder, self.plan, self.metered, self.timing, self.patience), identity(
            self.loop
        )
