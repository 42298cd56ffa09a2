"""manifest.json: the digest of every file that a results folder consists of, so that damage to any of them is detected.

    format "gainproof-manifest", version 1
    complete  whether the folder was written to its end
    files     {NAME: SHA-256 as hex digits}, without the manifest itself, the lock, and what a person put there

It is written last. While a folder is being written it says so, and holds the digests of the session before.
"""

import hashlib
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Annotated, Literal

from pydantic import AfterValidator

from plant.errors import StoreError
from plant.input_files import read_input_text
from tuner.store.advice import repair_hint
from tuner.store.document import Document
from tuner.text.product import READ_FORMER

FILE = "manifest.json"
FORMAT, VERSION = "gainproof-manifest", 1
NONE_YET = f"it has no {FILE}, as folders of earlier versions, so damage to its files cannot be detected"


def _inside(name: str) -> str:
    """Return a name that stays within the folder: the manifest may be a stranger's."""
    place = PurePosixPath(name)
    if not name or "\0" in name or place.is_absolute() or ".." in place.parts:
        raise ValueError("leads out of the folder")
    return name


class Manifest(Document):
    """Content of manifest.json. complete: the folder was written to its end; files: SHA-256 by name."""

    format: Annotated[Literal["gainproof-manifest"], READ_FORMER]
    version: Literal[1]
    complete: bool
    files: dict[Annotated[str, AfterValidator(_inside)], str]


def manifest_of(complete: bool, files: dict[str, str]) -> Manifest:
    """Return the manifest of a folder, files by name."""
    return Manifest(format=FORMAT, version=VERSION, complete=complete, files=dict(sorted(files.items())))


@dataclass(frozen=True)
class Damage:
    """A file of a folder that is not what was written. folder: the one whose manifest names it."""

    folder: Path
    name: str
    what: str

    def __str__(self) -> str:
        return f"{self.folder / self.name} {self.what}; {repair_hint(self.folder, self.name)}"


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
        return Manifest.parse(read_input_text(path / FILE))
    except FileNotFoundError:
        return None
    except (OSError, ValueError):
        raise StoreError(str(Damage(path, FILE, "is damaged"))) from None


def first_damage(path: Path, unread: tuple[str, ...] = ()) -> Damage | None:
    """Return the first missing or changed file of a folder.

    None where there is none, or no manifest of a complete folder.
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
    """Raise StoreError for a missing or changed file of a folder."""
    damage = first_damage(path, unread)
    if damage is not None:
        raise StoreError(str(damage))


def unfinished(path: Path) -> bool:
    """Return True for a folder that was not written to its end."""
    manifest = read_manifest(path)
    return manifest is not None and not manifest.complete
