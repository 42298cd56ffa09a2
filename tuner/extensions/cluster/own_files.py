"""User files that flights need: workers get names and digests, and their owner starts them with the files."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from objectives.flown_system import FlownSystem
from plant.errors import InputError
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
            f"{self.file.name} (digest {self.digest}), which is never sent: copy it there and start the worker with "
            f"--preload tuner.extensions.cluster.preload --code {self.file.name}, see docs/cluster.md"
        )


def own_files_of(system: FlownSystem, specs: Iterable[Any]) -> tuple[OwnFile, ...]:
    """Return the files that the flights of a system through scenarios need; InputError for a plant that no file holds."""
    try:
        code = system.own_code
    except InputError as error:
        raise error.located(key=KEY) from None
    metrics = [address.metric for address in system.metered]
    entries = [*system.laws.values(), *metrics, *[type(getattr(spec, "reference", None)) for spec in specs]]
    origins = [getattr(entry, "origin", None) for entry in entries]
    files = [OwnFile(Path(origin.place), origin.digest) for origin in origins if origin and not origin.packaged]
    return tuple(dict.fromkeys([*([OwnFile(code.file, code.digest)] if code else []), *files]))


def not_here(digests: list[str]) -> list[str]:
    """Return the digests whose code has not run in this process; every worker calls it."""
    return [digest for digest in digests if digest not in HAVE_RUN]


def check_here(files: Iterable[OwnFile]) -> None:
    """Raise InputError where this worker has not been given a file."""
    for entry in files:
        if entry.digest not in HAVE_RUN:
            raise InputError(f"a worker that joined later has not been given {entry.missing}", key=KEY)
