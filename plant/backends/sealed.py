"""Files of compiled kernels, sealed: each opens with a digest of its name and content, checked before anything is unpickled.

The digest protects from damage (a flipped bit, a cut file, a full disk), not from an attacker: write access to the folder is
write access to the digest. The folder protects from others: it is made with mode 0700, and one that somebody else owns or can
write is not used. A kernel is compiled by one process; others wait for it at a lock of the operating system.
"""

import os
import pickle
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from hashlib import blake2b
from pathlib import Path
from typing import Any

from plant.input_files import opened_at_once

# A mark of the form of these files, which a new name of the project does not change.
SEAL, DIGEST = b"holdfast kernel 1\n", 32
ENDING = ".kernel"
# Locks that this process holds, by file; it asks for none of them again.
_held: dict[Path, int] = {}


@cache
def say(line: str) -> None:
    """Print a line on standard error, each once in a process."""
    print(line, file=sys.stderr, flush=True)


def private_folder(path: Path) -> Path | None:
    """Return a folder, made if missing, that only this user or root can write; None with a notice otherwise."""
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        why = _open_to_others(path.stat())
    except OSError as error:
        why = f"cannot be used ({error.strerror or error})"
    if why is None:
        return path
    say(f"{path} {why}: compiled kernels are not kept, so each process compiles its own; see TUNER_CACHE_DIR")
    return None


def _open_to_others(status: os.stat_result) -> str | None:
    """Say why others could have put something there, or return None; systems without user ids are trusted."""
    if not hasattr(os, "getuid"):
        return None
    if status.st_uid not in (os.getuid(), 0):
        return "belongs to another user"
    return "can be written by other users (remove it, or chmod 700)" if status.st_mode & 0o022 else None


def sealed(name: str, content: bytes) -> bytes:
    """Return the bytes of a sealed file of a name."""
    return SEAL + blake2b(name.encode() + b"\0" + content, digest_size=DIGEST).digest() + content


def unsealed(file: Path) -> bytes | None:
    """Return the content of a sealed file; None where there is none, or where it is damaged: then it is removed, with a line."""
    try:
        with open(file, "rb", opener=opened_at_once) as opened:
            status = os.fstat(opened.fileno())
            why = None if stat.S_ISREG(status.st_mode) else "is no regular file"
            why = why or _open_to_others(status)
            stored = b"" if why else opened.read()
    except FileNotFoundError:
        return None
    except OSError as error:
        say(f"{file} cannot be read ({error.strerror or error}); the kernel is compiled again.")
        return None
    content = stored[len(SEAL) + DIGEST :]
    if why is None and stored == sealed(file.name, content):
        return content
    say(f"{file} {why or 'is damaged'}; the kernel is compiled again.")
    with suppress(OSError):
        file.unlink()
    return None


def _write(file: Path, content: bytes) -> None:
    """Write a sealed file aside and rename it; a line reports a failure."""
    aside = file.with_name(f"{file.name}.{os.getpid()}.tmp")
    try:
        handle = os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        with os.fdopen(handle, "wb") as opened:
            opened.write(sealed(file.name, content))
        aside.replace(file)
    except OSError as error:
        with suppress(OSError):
            aside.unlink()
        say(f"{file} cannot be written ({error.strerror or error}); the next process compiles this kernel again.")


def _lock(file: Path) -> None:
    """Wait for other processes that compile a file's content, and lock it until `_unlock`.

    Without `fcntl`, or where no lock can be made, two processes may compile at once, which costs time only.
    """
    try:
        import fcntl
    except ImportError:
        return
    if file in _held:
        return
    try:
        handle = os.open(file.with_suffix(".lock"), os.O_RDWR | os.O_CREAT, 0o600)
    except OSError:
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        say("Another process is compiling this kernel; waiting for it.")
        try:
            fcntl.flock(handle, fcntl.LOCK_EX)
        except OSError:
            os.close(handle)
            return
        except BaseException:
            os.close(handle)
            raise
    _held[file] = handle


def _unlock(file: Path) -> None:
    handle = _held.pop(file, None)
    if handle is not None:
        os.close(handle)


class SealedFiles:
    """Store of one function's compiled versions, in place of numba's IndexDataCacheFile.

    folder(): where the files lie, None for nowhere. stem(): how the names of the files begin. alone: whether other processes
    wait while this one compiles.
    """

    def __init__(self, folder: Callable[[], Path | None], stem: Callable[[], str], alone: bool = True) -> None:
        self._folder, self._stem, self._alone = folder, stem, alone

    def _file(self, key: Any) -> Path | None:
        folder = self._folder()
        digest = blake2b(repr(key).encode(), digest_size=6).hexdigest()
        return None if folder is None else folder / f"{self._stem()}-{digest}{ENDING}"

    def load(self, key: Any) -> Any:
        """Return the content saved under a key; None where the caller is to compile it, with other processes waiting."""
        file = self._file(key)
        if file is None:
            return None
        content = unsealed(file)
        if content is None and self._alone:
            _lock(file)
            content = unsealed(file)
        if content is None:
            return None
        _unlock(file)
        return pickle.loads(content)

    def save(self, key: Any, data: Any) -> None:
        """Save the compiled code of a key and release its lock."""
        from numba.core.serialize import dumps

        file = self._file(key)
        if file is None:
            return
        try:
            _write(file, dumps(data))
        finally:
            _unlock(file)

    def entries(self) -> Iterator[Path]:
        """Yield the undamaged files there are."""
        folder = self._folder()
        if folder is not None:
            yield from (file for file in folder.glob(f"{self._stem()}-*{ENDING}") if unsealed(file) is not None)
