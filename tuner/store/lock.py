"""One writer for each results folder: a lock that the system takes back when its holder dies, however that happens."""

import os
from contextlib import suppress
from pathlib import Path

from plant.errors import FolderLockedError, StoreError
from plant.output_files import unlinked

fcntl = None
with suppress(ImportError):
    import fcntl

NAME = ".lock"


class Lock:
    """Holds a folder for this process until it is released or forgotten; StoreError names who holds it already.

    On systems without `fcntl` the folder is not guarded.
    """

    def __init__(self, folder: Path) -> None:
        self._handle: int | None = None
        if fcntl is None:
            return
        try:
            handle = unlinked(str(folder / NAME), os.O_RDWR | os.O_CREAT)
        except OSError as error:
            raise StoreError(f"{folder} cannot be written ({error.strerror}); choose another with --out") from error
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            holder = os.read(handle, 100).decode(errors="replace").strip() or "another process"
            os.close(handle)
            raise FolderLockedError(f"{folder} is locked by {holder}; wait until it finishes, then retry") from None
        self._handle = handle
        os.ftruncate(handle, 0)
        os.write(handle, f"process {os.getpid()}\n".encode())

    def release(self) -> None:
        """Give the folder back."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None

    def __del__(self) -> None:
        """Release the folder at the end of writing."""
        self.release()
