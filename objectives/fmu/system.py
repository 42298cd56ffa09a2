"""An FMU under study: a plant's system whose flights and slopes come from worker processes."""

import platform
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from objectives.fmu.brief import Brief, brief_of
from objectives.fmu.flyer import FmuFlyer
from objectives.fmu.messages import Refused
from objectives.fmu.process import FmuProcess, WorkerLostError
from objectives.plant_system import PlantSystem
from plant.backends.identity import identity
from plant.errors import InputError, require_package
from plant.fmu.archive import unpacked
from plant.fmu.fmu_model import FmuModel

PATIENCE = 60.0
"""Seconds of the clock on the wall that a flight of an FMU may take, unless a study gives others."""


@dataclass(frozen=True)
class FmuSystem(PlantSystem):
    """An FMU, the plan of its loops, its parameters and its timing. patience: seconds that a flight may take."""

    plant: FmuModel
    patience: float = PATIENCE

    @property
    def arithmetic(self) -> str:
        """Name of its bits: the machine code is the FMU's own for this kind of machine."""
        return f"fmu {platform.system().lower()} {platform.machine().lower()}"

    def flyer(self, threads: int | None = None) -> FmuFlyer:
        """Return what flies it: so many worker processes, by default one for each core."""
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

    def process(self) -> FmuProcess:
        """Return a worker process that is not started yet; MissingPackageError where FMPy is not installed."""
        require_package("fmpy", "fmu", key="plant.fmu")
        return FmuProcess(*self._told, self.plant.file)

    @cached_property
    def _told(self) -> tuple[Brief, str]:
        """The brief of its workers, and the identity of the loop that they must build."""
        interface = self.plant.interface
        folder = unpacked(Path(self.plant.file), interface.digest)
        return brief_of(interface, folder, self.plan, self.metered, self.timing, self.patience), identity(self.loop)
