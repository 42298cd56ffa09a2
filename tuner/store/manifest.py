"""manifest.json: the digest of every file that a results folder consists of, so that damage to any of them is told.

    format "holdfast-manifest", version 1
    complete  whether the folder was written to its end
    files     {NAME: SHA-256 as hex digits}, without the manifest itself, the lock, and what a person put there

It is written last. While a folder is being written it says so, and holds the digests of the session before.
"""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from plant.errors import StoreError
from plant.input_files import read_input_text
from tuner.store.advice import mend

FILE, FORMAT, VERSION = "manifest.json", "holdfast-manifest", 1
NONE_YET = f"it has no {FILE}, as folders of earlier versions have none, so damage to its files cannot be told"


@dataclass(frozen=True)
class Manifest:
    """complete: whether the folder was written to its end. files: SHA-256 by name."""

    complete: bool
    files: dict[str, str]

    def encoded(self) -> bytes:
        """Return the content of manifest.json."""
        document = {
            "format": FORMAT, "version": VERSION, "complete": self.complete, "files": dict(sorted(self.files.items())),
        }  # fmt: skip
        return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()


@dataclass(frozen=True)
class Damage:
    """A file of a folder that is not what was written. folder: the one whose manifest names it."""

    folder: Path
    name: str
    what: str

    def __str__(self) -> str:
        return f"{self.folder / self.name} {self.what}; {mend(self.folder, self.name)}"


def digest_of(content: bytes) -> str:
    """Return the SHA-256 of a file's content as 64 hex digits."""
    return hashlib.sha256(content).hexdigest()


def digest_at(file: Path) -> str | None:
    """Return the SHA-256 of a regular file; None where there is none or it cannot be read."""
    try:
        if not file.is_file():
            return None
        with file.open("rb") as opened:
            return hashlib.file_digest(opened, "sha256").hexdigest()
    except OSError:
        return None


def read_manifest(path: Path) -> Manifest | None:
    """Return the manifest of a results folder, None where there is none; StoreError where it is damaged."""
    try:
        content = json.loads(read_input_text(path / FILE))
        if content["format"] != FORMAT or content["version"] != VERSION or not isinstance(content["complete"], bool):
            raise ValueError
        if not all(_inside(name) and isinstance(digest, str) for name, digest in content["files"].items()):
            raise ValueError
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise StoreError(str(Damage(path, FILE, "is damaged"))) from None
    return Manifest(content["complete"], content["files"])


def first_damage(path: Path, unread: tuple[str, ...] = ()) -> Damage | None:
    """Return the first file of a folder that is missing or not what was written; nothing where nothing can be told.

    unread: beginnings of names of which only the existence is looked at. Folders within that have a manifest of their own
    are looked at too.
    """
    manifest = read_manifest(path)
    if manifest is None or not manifest.complete:
        return None
    for name, digest in manifest.files.items():
        file = path / name
        if not file.exists():
            return Damage(path, name, "is missing")
        if not name.startswith(unread or ("\0",)) and digest_at(file) != digest:
            return Damage(path, name, "is not what was written")
        within = first_damage(file.parent, unread) if file.name == FILE else None
        if within is not None:
            return within
    return None


def refuse_damage(path: Path, unread: tuple[str, ...] = ()) -> None:
    """Raise StoreError where a file of a folder is missing or not what was written."""
    found = first_damage(path, unread)
    if found is not None:
        raise StoreError(str(found))


def unfinished(path: Path) -> bool:
    """Return whether a folder says that it was not written to its end."""
    manifest = read_manifest(path)
    return manifest is not None and not manifest.complete


def _inside(name: str) -> bool:
    """Return whether a name stays within the folder: the manifest may be a stranger's."""
    place = PurePosixPath(name)
    return bool(name) and "\0" not in name and not place.is_absolute() and ".." not in place.parts
