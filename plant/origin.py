"""Origins of laws, metrics and references that are not bundled: a file of the user's own, or a package."""

from collections.abc import Iterable
from dataclasses import is_dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple


class Origin(NamedTuple):
    """Origin of what is not bundled: its file, or "package version" where it is packaged, and the digest of the code."""

    place: str
    digest: str
    packaged: bool = False

    @property
    def short(self) -> str:
        """The place without its folder, which differs by machine."""
        return self.place if self.packaged else Path(self.place).name


def origins(entries: Iterable[Any], name: str = "name") -> dict[str, str]:
    """Return name -> digest of those entries that are not bundled."""
    return {getattr(entry, name): entry.origin.digest for entry in entries if entry.origin is not None}


def with_origin(entry: Any, origin: Origin) -> Any:
    """Return an entry that knows where it comes from; a class gets itself."""
    if is_dataclass(entry) and not isinstance(entry, type):
        return replace(entry, origin=origin)
    setattr(entry, "origin", origin)  # noqa: B010 (a class's own attribute, whatever its type)
    return entry
