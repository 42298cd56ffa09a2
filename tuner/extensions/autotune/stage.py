"""A stage of an autotune, and the arguments that all stages share."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree
from typing import ClassVar

from plant.errors import InputError
from plant.input_files import read_input
from tuner.exchange.target import FIRMWARE
from tuner.extensions.autopilots.sources import sources
from tuner.extensions.identification.api import LogLike
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.step_records.key_inputs import Input, Inputs, file_input
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder

PRESENT, VEHICLE, FIT, FIT_PAGE = "present.json", "vehicle.toml", "identification.json", "vehicle.html"
STUDY, RUN, EXPORT, OPINION = "study.toml", "run", "export", "opinion"
CONFIRMATION, FIRST_FLIGHTS, PLAN, PLAN_PAGE = "confirmation", "first_flights", "plan", "plan.html"
"""Names in the folder."""
GAINS, EXPORTED = f"{RUN}/gains.json", f"{EXPORT}/export.json"


@dataclass(frozen=True)
class Setup:
    """Arguments of a call, checked.

    Attributes:
        given_logs: Logs as given.
        logs: The same, read.
        vehicle: Parameter file as given.
        out: Path of the folder.
        folder: The folder, locked.
        airframe: Prior as given.
        source: Firmware of the parameter file.
        mapping: Mapping of CSV logs, None without.
        binary: Program or checkout of the firmware, None without.
        threads: Threads, None for one a core.
        watcher: Callbacks.
    """

    given_logs: Sequence[LogLike]
    logs: Sequence[FlightLog]
    vehicle: Path
    out: Path
    folder: Folder
    airframe: str
    source: str
    mapping: str | Path | None
    binary: str | Path | None
    threads: int | None
    watcher: Watcher

    @property
    def present(self) -> str:
        """Name of the copy of the parameter file."""
        return f"present{self.vehicle.suffix}"

    @property
    def export_options(self) -> dict[str, str]:
        """Options of the exports: the firmware's version, where names depend on it."""
        options = sources()[self.source].options(self.out / self.present)
        return {FIRMWARE: options[FIRMWARE]} if FIRMWARE in options else {}


class Stage(ABC):
    """A stage.

    Attributes:
        name: Name of the stage.
        outputs: Files and folders that it writes; the first is written last and marks its end.
        reads: Files of the folder that it reads.
        is_leaf: Whether no later stage reads from it.
    """

    name: ClassVar[str]
    outputs: tuple[str, ...]
    reads: tuple[str, ...] = ()
    is_leaf: ClassVar[bool] = False

    def __init__(self, setup: Setup) -> None:
        self.setup, self.out, self.folder, self.watcher = setup, setup.out, setup.folder, setup.watcher

    @property
    def is_wanted(self) -> bool:
        """True unless the arguments leave the stage out."""
        return True

    def inputs(self) -> Inputs:
        """Return all that it reads, by name."""
        return {name: input_at(self.out / name) for name in self.reads}

    @abstractmethod
    def make(self) -> str | None:
        """Write the outputs; return a sentence if the way ends here."""

    @abstractmethod
    def sentence(self) -> str:
        """Return the result in a sentence."""

    def clear(self, to_go_on: bool) -> None:
        """Remove the outputs; to_go_on: whether they are of the same inputs, so a part may be gone on with."""
        # An export is written under another name, under which a killed process leaves it.
        unfinished = [path for name in self.outputs for path in self.out.glob(f".{name}.part*")]
        for path in (*unfinished, *[self.out / name for name in self.outputs]):
            if path.is_dir():
                rmtree(path)
            else:
                path.unlink(missing_ok=True)


def input_at(file: Path) -> Input:
    """Return a file as an input; InputError where it cannot be read."""
    try:
        return file_input(file.name, read_input(file))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=file) from None
