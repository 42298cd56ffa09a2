"""Records as C structures: one typedef for each NamedTuple, with members in the order and under the names of its fields."""

import re
from typing import Any

GENERIC = ("Memory", "Constants", "Gains")


class CRecords:
    """C names of record types; prefix: before each name. The types named first are those in `given`, which need no typedef."""

    def __init__(self, prefix: str, given: dict[Any, str]) -> None:
        self._prefix = prefix
        self._names: dict[Any, str] = dict(given)
        self.typedefs: list[str] = []

    def name(self, kind: Any) -> str:
        """Return the C name of a record type; its typedef and those of its parts are then among `typedefs`."""
        if kind is float:
            return f"{self._prefix}_real"
        if kind not in self._names:
            members = [(self.name(part), field) for field, part in kind.__annotations__.items()]
            name = self._free(kind)
            lines = "\n".join(f"    {part} {field};" for part, field in members)
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
