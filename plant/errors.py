"""The one error tree of the project.

    ToolError                  anything this tool reports to its user; the command line catches this root and nothing else
    ├── InputError             something the user gave cannot be used: names file and key, what was given, what is allowed
    │   ├── UnknownNameError   a name that no schema or registry has, with the nearest valid ones
    │   ├── UnphysicalError    numbers that no real airframe can have
    │   ├── UnsupportedVersionError  a file of a known firmware in a version whose names and units are not known
    │   ├── UnnamedCodeError   code in a results folder that the user has not named, see `plant.own_code`
    │   └── MissingPackageError  an optional package that is not installed
    └── StoreError             a results folder that exists, is missing, or cannot be trusted
        └── FolderLockedError  a results folder that another process is writing

A failed flight is not in this tree: it is a result with a status (`plant.quadrotor.closed_loop.Status`).
"""

from collections.abc import Collection, Iterable
from difflib import get_close_matches
from importlib.util import find_spec
from os import PathLike

# Characters of a name and of a dotted key of the user's that a message repeats.
LONGEST, LONGEST_KEY = 60, 180


def one_line(text: str) -> str:
    """Return a text with unprintable characters escaped: it may come from a file of the user's."""
    return "".join(letter if letter.isprintable() else letter.encode("unicode_escape").decode() for letter in text)


def shortened(text: str, longest: int = LONGEST) -> str:
    """Return a text, or the beginning of a long one."""
    return text if len(text) <= longest else f"{text[: longest - 3]}..."


class ToolError(Exception):
    """Root of all errors a user can cause or meet; printed, it is one line."""

    def __str__(self) -> str:
        return one_line(super().__str__())


class InputError(ToolError):
    """Raised where something that the user gave cannot be used.

    message: what was given, what is allowed and what to do.
    file: the file the value came from.
    key: the dotted key inside that file.
    """

    def __init__(self, message: str, *, file: str | PathLike[str] | None = None, key: str | None = None) -> None:
        self.message = message
        self.file = None if file is None else str(file)
        self.key = key
        # An empty key has to be seen.
        place = None if key is None else shortened(key, LONGEST_KEY) or '""'
        super().__init__(": ".join(part for part in (self.file, place, message) if part))

    def located(self, *, file: str | PathLike[str] | None = None, key: str | None = None) -> "InputError":
        """Return the same error with missing file and key filled in."""
        copy = type(self).__new__(type(self))
        InputError.__init__(copy, self.message, file=self.file or file, key=self.key or key)
        return copy


class UnknownNameError(InputError):
    """A name that is not among the valid ones; the message ends with the nearest of them.

    Args:
        kind: what the name represents ("law", "metric", "key").
        name: name as given.
        valid: all valid names.
    """

    def __init__(
        self,
        kind: str,
        name: str,
        valid: Iterable[str],
        *,
        file: str | PathLike[str] | None = None,
        key: str | None = None,
    ) -> None:
        names = sorted(valid)
        near = get_close_matches(name[:LONGEST], names, n=1, cutoff=0.5)
        hint = f"did you mean '{near[0]}'? " if near else ""
        super().__init__(f"unknown {kind} '{shortened(name)}'; {hint}valid: {', '.join(names)}", file=file, key=key)


def check_name(
    kind: str, name: str, valid: Collection[str], *, file: str | PathLike[str] | None = None, key: str | None = None
) -> None:
    """Raise UnknownNameError where a name is not among the valid ones."""
    if name not in valid:
        raise UnknownNameError(kind, name, valid, file=file, key=key)


class UnphysicalError(InputError):
    """An airframe whose numbers contradict physics or break a sanity rule."""


class UnsupportedVersionError(InputError):
    """A file of a firmware in an unsupported version."""


class UnnamedCodeError(InputError):
    """Code in a results folder that the user has not named."""


class MissingPackageError(InputError):
    """An optional package that is not installed; the message ends with the command that installs it."""


def how_to_install(extra: str) -> str:
    """Return the command that installs the packages of an extra of this project."""
    # The reader of metadata takes 20 ms to import, which only this sentence needs.
    import re
    from importlib.metadata import PackageNotFoundError, requires

    try:
        wanted = [entry.partition(";") for entry in requires("gainproof") or ()]
    except PackageNotFoundError:
        return f"pip install '.[{extra}]'"
    packages = [name.strip() for name, _, condition in wanted if re.search(rf"extra == .{extra}\b", condition)]
    return f"pip install {' '.join(map(repr, packages))}"


def require_package(package: str, extra: str, *, key: str | None = None) -> None:
    """Raise MissingPackageError where a package of an extra cannot be imported; key: what of the user's asks for it."""
    if find_spec(package) is None:
        raise MissingPackageError(f"needs the package {package}; install it with: {how_to_install(extra)}", key=key)


class StoreError(ToolError):
    """A results folder that exists, is missing, or holds a corrupt file."""


class FolderLockedError(StoreError):
    """A results folder that another process is writing."""
