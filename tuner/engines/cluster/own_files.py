"""Files of the user's own that flights need: workers are told names and digests, and whoever starts them gives the files."""

from collections.abc import Iterable
from functools import singledispatch
from pathlib import Path
from typing import Any, NamedTuple

from objectives.plant_system import PlantSystem
from objectives.system import System
from plant.errors import InputError
from plant.model.plant_model import PlantModel
from plant.own_code import HAVE_RUN

KEY = "--dask"


class OwnFile(NamedTuple):
    """A file of the user's own: the file here, and the digest of its code."""

    file: Path
    digest: str

    @property
    def missing(self) -> str:
        """The message where it has not been given."""
        return (
            f"{self.file.name} (digest {self.digest}), which is sent to nobody: copy it there and start the worker with "
            f"--preload tuner.engines.cluster.preload --code {self.file.name}, see docs/cluster.md"
        )


def own_files_of(system: Any, specs: Iterable[Any]) -> tuple[OwnFile, ...]:
    """Return the files that the flights of a system through scenarios need; InputError for a plant that no file holds."""
    metrics = [address.metric for address in system.metered]
    entries = [*_entries(system), *metrics, *[type(getattr(spec, "reference", None)) for spec in specs]]
    origins = [getattr(entry, "origin", None) for entry in entries]
    files = [OwnFile(Path(origin.place), origin.digest) for origin in origins if origin and not origin.packaged]
    return tuple(dict.fromkeys([*_plant_files(system), *files]))


@singledispatch
def _entries(system: Any) -> list[Any]:
    raise NotImplementedError(type(system))


@_entries.register
def _(system: System) -> list[Any]:
    return [system.cascade.position, system.cascade.attitude]


@_entries.register
def _(system: PlantSystem) -> list[Any]:
    return [channel.law for channel in system.plan.channels]


def _plant_files(system: Any) -> list[OwnFile]:
    if not isinstance(system, PlantSystem):
        return []
    if not isinstance(system.plant, PlantModel):
        raise InputError("an FMU flies in processes of this machine; leave --dask out", key=KEY)
    plant = system.plant
    found = [code for code in HAVE_RUN.values() if code.names.get("derivative") is plant.derivative]
    if not found:
        raise InputError(
            "no file holds the code of this plant, so no worker can have it; write it to a file, or leave --dask out",
            key=KEY,
        )
    return [OwnFile(found[0].file, found[0].digest)]


def not_here(digests: list[str]) -> list[str]:
    """Return those of some digests whose code has not run in this process; asked of every worker."""
    return [digest for digest in digests if digest not in HAVE_RUN]


def check_here(files: Iterable[OwnFile]) -> None:
    """Raise InputError where this worker has not been given a file."""
    for entry in files:
        if entry.digest not in HAVE_RUN:
            raise InputError(f"a worker that joined later has not been given {entry.missing}", key=KEY)
