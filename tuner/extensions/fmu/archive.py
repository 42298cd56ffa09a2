"""The archive of an FMU: looked at before anything of it is unpacked, for its names and sizes are whatever its maker wrote."""

import atexit
import os
import platform
import shutil
import sys
import tempfile
import zipfile
import zlib
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path, PurePosixPath

from plant.errors import InputError, one_line, shortened
from plant.input_files import MAX_TEXT_BYTES, read_input
from plant.own_code import MAX_BINARY_BYTES, digest_of_bytes, named_binary

fcntl = None
with suppress(ImportError):
    import fcntl

DESCRIPTION = "modelDescription.xml"
# Largest content of an archive [bytes], and most files in it.
MAX_CONTENT_BYTES, MAX_FILES = 2**32, 20_000
# Systems as FMI 2 and FMI 3 call them, and the ending of their libraries.
SYSTEMS = {
    "linux": ("linux", "linux", ".so"),
    "darwin": ("darwin", "darwin", ".dylib"),
    "win32": ("win", "windows", ".dll"),
}
BROKEN = (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, OSError, ValueError)
REGULAR, FOLDER, UNSAID = 0o100000, 0o040000, 0
PREFIX, LOCK = "gainproof-fmu-", ".lock"
_held: list[int | None] = []
# Folders into which FMUs were unpacked, by digest; they go when this process ends.
_unpacked: dict[str, Path] = {}


@dataclass(frozen=True)
class Archive:
    """An FMU as a file. digest: of its bytes; names: of the files in it."""

    file: Path
    digest: str
    names: tuple[str, ...]

    @property
    def description(self) -> bytes:
        """Content of modelDescription.xml; InputError where it is too large or damaged."""
        with _opened(self.file, self.digest) as archive:
            size = archive.getinfo(DESCRIPTION).file_size
            if size > MAX_TEXT_BYTES:
                raise self._wrong(f"has {size / 2**20:,.0f} MiB; at most {MAX_TEXT_BYTES / 2**20:,.0f} MiB are read")
            try:
                return archive.read(DESCRIPTION)
            except BROKEN as error:
                raise self._wrong(f"cannot be read ({error}); export the FMU again") from None

    def check_library(self, version: int, identifier: str) -> None:
        """Raise InputError where it holds no machine code for this machine.

        The message names the machines that it is built for.
        """
        folder = platform_folder(version)
        name = f"binaries/{folder}/{identifier}{SYSTEMS.get(sys.platform, SYSTEMS['linux'])[2]}"
        if name not in self.names:
            parts = [PurePosixPath(entry).parts for entry in self.names]
            platforms = sorted({part[1] for part in parts if len(part) == 3 and part[0] == "binaries"})
            held = ", ".join(shortened(one_line(entry)) for entry in platforms[:9]) or "nothing"
            raise InputError(f"has no {name}, which this machine needs; it is built for {held}", file=self.file)

    def _wrong(self, what: str) -> InputError:
        return InputError(f"its {DESCRIPTION} {what}", file=self.file)


def open_archive(file: Path, study: Path | None = None) -> Archive:
    """Return the archive of an FMU; study: the file that names it, None where the user does.

    Raises UnnamedCodeError as `plant.own_code` does, and InputError for what is no FMU or cannot be unpacked safely.
    """
    digest = named_binary(file, study, MAX_BINARY_BYTES).digest
    try:
        with zipfile.ZipFile(BytesIO(read_input(file, MAX_BINARY_BYTES))) as archive:
            infos = archive.infolist()
    except BROKEN as error:
        raise InputError(f"is no archive that can be read ({error}); an FMU is a ZIP file", file=file) from None
    _check(infos, file)
    names = tuple(info.filename for info in infos)
    if DESCRIPTION not in names:
        raise InputError(f"holds no {DESCRIPTION}, so it is no FMU; export it again", file=file)
    return Archive(file, digest, names)


def unpacked(file: Path, digest: str) -> Path:
    """Return a folder of this process with the content of an archive; InputError where it has changed since it was looked at."""
    if digest not in _unpacked:
        remove_abandoned()
        folder = Path(tempfile.mkdtemp(prefix=PREFIX))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        _held.append(_locked(folder, os.O_CREAT))
        with _opened(file, digest) as archive:
            try:
                archive.extractall(folder)
            except BROKEN as error:
                raise InputError(f"cannot be unpacked ({error}); export it again", file=file) from None
        _unpacked[digest] = folder
    return _unpacked[digest]


def remove_abandoned() -> None:
    """Remove the folders of processes that were killed: those whose locks the system has taken back."""
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError):
            if not folder.is_symlink() and folder.stat().st_uid == os.getuid():
                handle = _locked(folder)
                if handle is not None:
                    shutil.rmtree(folder, ignore_errors=True)
                    os.close(handle)


def _locked(folder: Path, flags: int = 0) -> int | None:
    """Return the handle of a folder's lock, which this process now holds; None where another does or the system has none."""
    if fcntl is None:
        return None
    handle = os.open(folder / LOCK, os.O_RDWR | os.O_NOFOLLOW | flags, 0o600)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        return None
    return handle


def _opened(file: Path, digest: str) -> zipfile.ZipFile:
    content = read_input(file, MAX_BINARY_BYTES)
    if digest_of_bytes(content) != digest:
        raise InputError("has changed since it was read; run the study again", file=file)
    return zipfile.ZipFile(BytesIO(content))


def platform_folder(version: int) -> str:
    """Return the folder of machine code for this machine, by FMI version."""
    short, long, _ = SYSTEMS.get(sys.platform, SYSTEMS["linux"])
    wide, arm = sys.maxsize > 2**32, platform.machine().lower() in ("arm64", "aarch64")
    if version == 2:
        return f"{short}{64 if wide else 32}"
    return f"{'aarch64' if arm else 'x86_64' if wide else 'x86'}-{long}"


def _check(infos: list[zipfile.ZipInfo], file: Path) -> None:
    """Raise InputError for content that cannot be unpacked safely.

    Such a file would leave its folder, fill the disk, or is no plain file.
    """
    size = sum(info.file_size for info in infos)
    if len(infos) > MAX_FILES or size > MAX_CONTENT_BYTES:
        raise InputError(
            f"unpacks to {len(infos):,} files of {size / 2**20:,.0f} MiB; at most {MAX_FILES:,} files of "
            f"{MAX_CONTENT_BYTES / 2**20:,.0f} MiB are unpacked",
            file=file,
        )
    for info in infos:
        name, kind = info.filename, (info.external_attr >> 16) & 0o170000
        outside = name.startswith("/") or any(mark in name for mark in ("\\", ":")) or ".." in PurePosixPath(name).parts
        if outside or not name.isprintable() or kind not in (REGULAR, FOLDER, UNSAID):
            shown = shortened(one_line(name))
            raise InputError(
                f"holds '{shown}', which is no plain file inside its own folder; it is not unpacked", file=file
            )
