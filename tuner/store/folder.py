"""A results folder: what a run writes, each file aside first and then renamed, so that a kill leaves no half file.

run.json, inputs/, study.toml, resolved.json, environment.json, history.csv, generations/NNNN.npz, flights/, front.csv,
summary.json, gains.json, responses.npz, report.html, figures/, manifest.json. Their contents are described in
results/README.md. A file is on the disk before its name is, and its name before the next file is begun; those that belong
together are written side by side, because a disk takes some in the time of one.
"""

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import Any

from plant import output_files
from plant.errors import StoreError
from tuner.store import manifest
from tuner.store.advice import can_be_resumed, resume_hint
from tuner.store.columns import Columns, csv_text
from tuner.store.document import Document, json_text
from tuner.store.lock import NAME as LOCK
from tuner.store.lock import Lock
from tuner.store.manifest import Manifest, digest_at, digest_of, manifest_of, read_manifest
from tuner.store.npz import npz_bytes


class Folder:
    """A results folder that this process, and no other, writes.

    As a context manager it lets go of the folder at the end, and an error that leaves it unfinished carries a note on what
    goes on with it. A new folder that is still empty then is removed.
    """

    def __init__(self, path: Path, lock: Lock, former: Manifest | None = None, made: bool = False) -> None:
        self.path = path
        self._made = made
        self._lock = lock
        self._former = former
        self._digests: dict[str, str] = {}
        self._begun = False

    def __enter__(self) -> "Folder":
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        ending = _hidden_interrupt(error) or error
        if ending is None or not self._removed():
            if ending is not None and not isinstance(ending, StoreError):
                note = resume_hint(self.path, self._made)
                # The run of a contender lies in the folder of its contest: both say the same.
                if note not in getattr(ending, "__notes__", ()):
                    ending.add_note(note)
            self.close()
        if ending is not None and ending is not error:
            raise ending

    def _removed(self) -> bool:
        """Release and remove a new folder with the lock alone; return success."""
        if not self._made or [path.name for path in self.path.iterdir()] != [LOCK]:
            return False
        with suppress(OSError):
            (self.path / LOCK).unlink()
            self.close()
            self.path.rmdir()
        return not self.path.exists()

    @classmethod
    def create(cls, path: Path, inside: str = "generations", empty: bool = False) -> "Folder":
        """Make a new folder, with one inside; StoreError if anything is there already: nothing is ever overwritten.

        empty: whether an empty folder may be there.
        """
        free = empty and path.is_dir() and not path.is_symlink() and not any(path.iterdir())
        if os.path.lexists(path) and not free:
            resume = f"continue it with `tuner resume {path}`, " if can_be_resumed(path) else ""
            raise StoreError(f"{path} exists already; {resume}choose another --out, or remove it")
        try:
            output_files.refuse_links_to(path)
            output_files.make_folders(path.parent)
            path.mkdir(mode=output_files.FOLDER_MODE, exist_ok=empty)
            output_files.make_folders(path / inside)
        except OSError as error:
            raise StoreError(f"{path} cannot be made ({_reason(error)}); choose another folder with --out") from error
        return cls(path, Lock(path), made=True)

    @classmethod
    def open(cls, path: Path) -> "Folder":
        """Open a folder to go on writing it; StoreError where there is none, or where another process writes it."""
        if not path.is_dir():
            raise StoreError(f"{path}: there is no such results folder; give a folder that `tuner run` wrote")
        output_files.refuse_links_in(path)
        lock = Lock(path)
        folder = cls(path, lock, _former(path))
        folder._clear()
        return folder

    @classmethod
    def open_or_create(cls, path: Path) -> "Folder":
        """Open a folder, or make it where there is none."""
        return cls.open(path) if path.is_dir() else cls.create(path)

    def close(self) -> None:
        """Let other processes write it."""
        self._lock.release()

    def seal(self) -> None:
        """Write the manifest of a complete folder and release the lock."""
        self._put(manifest.FILE, manifest_of(True, self._digests).text().encode())
        self.close()

    def amend(self, *patterns: str) -> None:
        """Update the manifest of a complete folder for files that were rewritten.

        Folders that are not complete have none to update.
        """
        self.written(*patterns)
        if self._former is not None and self._former.complete:
            self._put(manifest.FILE, manifest_of(True, self._former.files | self._digests).text().encode())

    def write_text(self, name: str, text: str) -> None:
        """Write a text file."""
        self.write_bytes(name, text.encode())

    def write_bytes(self, name: str, content: bytes) -> None:
        """Write a file of bytes."""
        self.write_together({name: content})

    def write_together(self, files: Mapping[str, bytes]) -> None:
        """Write files of bytes by name, side by side."""
        if not self._begun:
            self._begun = True
            former = {} if self._former is None else self._former.files
            self._put(manifest.FILE, manifest_of(False, former).text().encode())
        put_together(self.path, files, self._made)
        self._digests |= {name: digest_of(content) for name, content in files.items()}

    def write_json(self, name: str, content: Any) -> None:
        """Write a document, or plain data, as a JSON file."""
        self.write_text(name, content.text() if isinstance(content, Document) else json_text(content))

    def write_table(self, name: str, table: Columns) -> None:
        """Write a table as .csv or .npz, by the name's ending."""
        self.write_tables({name: table})

    def write_tables(self, tables: Mapping[str, Columns]) -> None:
        """Write tables of columns by name, side by side."""
        self.write_together({name: table_bytes(name, table) for name, table in tables.items()})
        for name in (name for name in tables if name.endswith(".npz")):
            # Of a run that an earlier version began.
            self.remove(str(PurePosixPath(name).with_suffix(".parquet")))

    def keep(self, name: str) -> bool:
        """Take a file of an earlier session over as it is; False where it is missing or not what that session wrote."""
        digest = digest_at(self.path / name)
        former = {} if self._former is None else self._former.files
        if digest is None or former.get(name, digest) != digest:
            return False
        self._digests[name] = digest
        return True

    def written(self, *patterns: str) -> None:
        """Add this session's files of other writers (figures) to the manifest."""
        for pattern in patterns:
            for file in sorted(self.path.glob(pattern)):
                digest = digest_at(file)
                if digest is not None and not file.name.startswith("."):
                    self._digests[file.relative_to(self.path).as_posix()] = digest

    def remove(self, name: str) -> None:
        """Remove a file of an earlier end of this run, if any."""
        self._digests.pop(name, None)
        try:
            (self.path / name).unlink(missing_ok=True)
        except OSError as error:
            raise StoreError(f"{self.path / name} cannot be removed ({_reason(error)}); remove it by hand") from error

    def _put(self, name: str, content: bytes) -> None:
        put(self.path, name, content, self._made)

    def _clear(self) -> None:
        """Remove what a killed process left half written."""
        for file in self.path.rglob(f".*{output_files.ASIDE}"):
            with suppress(OSError):
                file.unlink()


def put(folder: Path, name: str, content: bytes, made: bool = False) -> Path:
    """Write a file of a results folder atomically, and return its path.

    made: whether the folder was made by this process. Raises StoreError with the reason where it cannot be written.
    """
    file = folder / name
    output_files.refuse_links(folder, name)
    try:
        output_files.make_folders(file.parent)
        output_files.replace_file(file, content, _settled)
    except OSError as error:
        raise StoreError(
            f"{file} cannot be written ({_reason(error)}); earlier results are saved. Free disk space and "
            f"{resume_hint(folder, made)}"
        ) from error
    return file


def put_together(folder: Path, files: Mapping[str, bytes], made: bool = False) -> list[Path]:
    """Write files of a results folder, by name and in parallel; return their paths.

    Each is written as `put` does.
    """

    def written(name: str) -> Path:
        return put(folder, name, files[name], made)

    if len(files) == 1:
        return [written(name) for name in files]
    with ThreadPoolExecutor(len(files) or 1) as pool:
        return list(pool.map(written, files))


def table_bytes(name: str, table: Columns) -> bytes:
    """Return a table as .csv or .npz bytes, by the name's ending."""
    if name.endswith(".csv"):
        return csv_text(table).encode()
    return npz_bytes(table)


def _hidden_interrupt(error: BaseException | None) -> KeyboardInterrupt | None:
    """Return the Ctrl-C during whose handling an error came, if any.

    One that lands while a thread starts leaves `threading` with a lock that it does not hold, and a RuntimeError about it.
    """
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error


def _former(path: Path) -> Manifest | None:
    """Return the manifest of the session before; None where there is none to be trusted."""
    try:
        return read_manifest(path)
    except StoreError:
        return None


def _reason(error: OSError) -> str:
    return error.strerror or str(error)


def _settled(path: Path) -> None:
    """Have the disk take what was written: a file's bytes, or a folder's names where the system can do that."""
    if path.is_dir() and os.name != "posix":
        return
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
