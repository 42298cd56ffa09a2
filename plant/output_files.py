"""The one door for files that are written: never through a link, and never for other users to write.

A results folder may be a stranger's. A link in it where a file is to be written would lead the writer out of it, and so would a
second name (a hard link) of a file that is written in place.
"""

import errno
import io
import os
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from plant.errors import StoreError
from plant.results_folder import results_folder_of

FILE_MODE, FOLDER_MODE = 0o644, 0o755
"""Permissions of what is made, less those that the user's umask takes away."""
ASIDE = ".aside"
"""Ending of the name under which a file is written before it gets its own."""
# Systems that lack these flags have no such links or pipes either.
_UNLINKED = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)


def open_in_place(file: Path, mode: str) -> IO[bytes]:
    """Open a file to be written where it stands; StoreError where it is a link, has a second name or is no regular file.

    mode: "ab" or "xb", as for `open`. Raises OSError too, as `open` does.
    """
    return io.open(file, mode, opener=unlinked)  # noqa: SIM115, UP020  (tests count the writes of `io.open`)


def unlinked(file: str, flags: int) -> int:
    """Open a regular file that has one name and is no link: an opener of `open`."""
    if os.path.islink(file):
        raise _link(file)
    handle = os.open(file, flags & ~os.O_TRUNC | _UNLINKED, FILE_MODE)
    state = os.fstat(handle)
    if not stat.S_ISREG(state.st_mode) or state.st_nlink > 1:
        os.close(handle)
        what = "has a second name (a hard link)" if stat.S_ISREG(state.st_mode) else "is no regular file"
        raise StoreError(f"{file} {what}, so it is not written; remove it")
    if flags & os.O_TRUNC:
        os.ftruncate(handle, 0)
    return handle


def write_new_file(file: Path, content: bytes) -> None:
    """Write a new file whole or not at all; FileExistsError for one that exists, a link included."""
    if os.path.lexists(file):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(file))
    # Two processes that make one file at the same time have a name each.
    aside = file.with_name(f".{file.name}.{os.getpid()}{ASIDE}")
    with _written_aside(aside, content):
        _name_new(aside, file)


@contextmanager
def _written_aside(aside: Path, content: bytes) -> Iterator[None]:
    """Write a file under another name, which the body renames."""
    try:
        # Whatever stands there is left of a killed process, or a trap.
        aside.unlink(missing_ok=True)
        with io.open(aside, "xb", opener=unlinked) as out:  # noqa: UP020
            out.write(content)
        yield
    except BaseException:
        with suppress(OSError):
            aside.unlink(missing_ok=True)
        raise


def _name_new(aside: Path, file: Path) -> None:
    """Give a file its name; FileExistsError if another process used the name meanwhile."""
    try:
        os.link(aside, file)
    except FileExistsError:
        raise
    except (OSError, AttributeError):
        # No second names on this disk or system: a rename, which is as whole.
        os.replace(aside, file)
    else:
        aside.unlink()


def replace_file(file: Path, content: bytes, settle: Callable[[Path], None] = lambda path: None) -> None:
    """Write a file whole or not at all; raises OSError, and StoreError for a link. settle: has the disk take a file or folder."""
    if file.is_symlink():
        raise _link(file)
    aside = file.with_name(f".{file.name}{ASIDE}")
    with _written_aside(aside, content):
        settle(aside)
        aside.replace(file)
    settle(file.parent)


def make_folders(folder: Path) -> None:
    """Make a folder and its parents, not writable by others; raises OSError."""
    for part in [*reversed(folder.parents), folder]:
        if not part.is_dir():
            part.mkdir(mode=FOLDER_MODE, exist_ok=True)


def refuse_links(folder: Path, name: str) -> None:
    """Raise StoreError where a path below a folder contains a link."""
    place = folder
    for step in Path(name).parts:
        place = place / step
        if place.is_symlink():
            raise _link(place)


def refuse_links_in(folder: Path) -> None:
    """Raise StoreError where a folder holds a link, however deep."""
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            if os.path.islink(os.path.join(place, name)):
                raise _link(os.path.join(place, name))


def refuse_links_to(out: Path) -> None:
    """Raise StoreError where a new path in a results folder contains a link."""
    home = results_folder_of(out)
    if home is not None:
        refuse_links(home, os.path.relpath(out.absolute(), home))


def _link(place: str | Path) -> StoreError:
    return StoreError(f"{place} is a link, and nothing is written through links; put what it leads to in its place")
