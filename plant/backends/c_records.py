"""Records as C structures: one typedef for each NamedTuple, with members in the order and under the names of its fields."""

import re
from collections.abc import Callable
from typing import Any

from plant.records import is_leaf

GENERIC = ("Memory", "Constants", "Gains")


class CRecords:
    """C names of record types; prefix: before each name. The types named first are those in `given`, which need no typedef.

    note: comment behind a member, from the annotation of its leaf.
    """

    def __init__(self, prefix: str, given: dict[Any, str], note: Callable[[Any], str] = lambda _: "") -> None:
        self._prefix = prefix
        self._note = note
        self._names: dict[Any, str] = dict(given)
        self.typedefs: list[str] = []

    def name(self, kind: Any) -> str:
        """Return the C name of a record type; its typedef and those of its parts are then among `typedefs`."""
        if is_leaf(kind):
            return f"{self._prefix}_real"
        if kind not in self._names:
            parts = kind.__annotations__.items()
            lines = "\n".join(f"    {self.name(part)} {field};{self._note(part)}" for field, part in parts)
            name = self._free(kind)
            self.typedefs.append(f"typedef struct {{\n{lines}\n}} {name};")
            self._names[kind] = name
        return self._names[kind]

    def _free(self, kind: Any) -> str:
        plain = snake(kind.__name__)
        if kind.__name__ in GENERIC:
            plain = f"{kind.__module__.rpartition('.')[2]}_{plain}"
        name = f"{self._prefix}_{plain}"
        while name in self._names.values():
            name += "_"
        return name


def snake(name: str) -> str:
    """Return a CamelCase name in lower case with underscores."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
