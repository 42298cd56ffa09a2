"""Registries of laws, metrics and references: what is bundled, what the user's files define, what installed packages offer.

A package offers an entry by an entry point, as in its pyproject.toml:

    [project.entry-points."gainproof.laws"]
    my_law = "my_package.my_law:LAW"
"""

import hashlib
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from plant.entry_points import DISTRIBUTION, files_of
from plant.errors import InputError, check_name
from plant.input_files import read_input
from plant.origin import Origin, with_origin

T = TypeVar("T")


class Registry(dict[str, T]):
    """Entries by name. An entry has an `origin`, which is None for what is bundled.

    kind: in messages, "law". name_of: the name of an entry. Packages are asked only for a name that is not known otherwise, for
    a look at what is installed takes time.
    """

    def __init__(self, kind: str, name_of: Callable[[T], str], entries: Iterable[T]) -> None:
        super().__init__({name_of(entry): entry for entry in entries})
        self.kind = kind
        self.group = f"gainproof.{kind}s"
        self._name_of = name_of
        self._has_packages = False

    def find(self, name: str) -> T:
        """Return an entry; UnknownNameError, with the nearest name, where there is none."""
        if name not in self:
            self.ask_packages()
        check_name(self.kind, name, self)
        return self[name]

    def add(self, entry: T, origin: Origin) -> T:
        """Add a user's entry, in place of an earlier one of its file; return it with its origin.

        Raises InputError where another has its name.
        """
        name = self._name_of(entry)
        earlier: Any = self.get(name)
        if earlier is not None and earlier.origin is None:
            message = f"'{name}' is a {self.kind} of gainproof itself; give yours another name"
            raise InputError(message, file=origin.place, key=self.kind)
        if earlier is not None and earlier.origin == origin:
            return earlier
        if earlier is not None and earlier.origin.place != origin.place:
            message = f"'{name}' is the {self.kind} of {earlier.origin.place} already; give one of them another name"
            raise InputError(message, file=origin.place, key=self.kind)
        self[name] = with_origin(entry, origin)
        return self[name]

    def ask_packages(self) -> None:
        """Take what installed packages offer, once a process."""
        if self._has_packages:
            return
        self._has_packages = True
        from importlib.metadata import entry_points

        for point in entry_points(group=self.group):
            if not _is_own(point):
                self.add(_loaded(point), _origin(point))


def _is_own(point: Any) -> bool:
    return point.dist.name == DISTRIBUTION


def _loaded(point: Any) -> Any:
    try:
        return point.load()
    except Exception as error:
        what = f"{type(error).__name__}: {error}"
        raise InputError(
            f"the entry point {point.name} = {point.value} cannot be loaded: {what}", file=point.group
        ) from error


def _origin(point: Any) -> Origin:
    return Origin(f"{point.dist.name} {point.dist.version}", _digest(point), True)


def _digest(point: Any) -> str:
    """Return the digest of an entry point's package, or of its module."""
    digest = hashlib.blake2b(digest_size=12)
    for name, file in files_of(point.module.partition(".")[0]).items():
        digest.update(name.encode() + b"\0" + read_input(file))
    return digest.hexdigest()
