"""Model functions become another backend's by rebinding their names.

A model function is plain Python on scalars. Its code object stays as it is; only the globals (and closure cells) it looks up
are replaced: mathematical names by the backend's, called model functions by their own rebound selves. So there is one source
of the model and no twin that can drift.
"""

import builtins
import dis
from collections.abc import Callable, Mapping
from pathlib import Path
from types import CellType, FunctionType
from typing import Any

from plant import primitives
from plant.records import source_of

Wrap = Callable[[FunctionType], Any]
PRIMITIVES = {name: getattr(primitives, name) for name in primitives.__all__}
# Their meaning on scalars differs from that on arrays or symbols, so a model function must not use them.
FORBIDDEN = frozenset({"abs", "min", "max", "sum", "round", "float", "int", "bool", "len", "print"})


def global_names(function: FunctionType) -> list[str]:
    """Return the names that a function looks up outside; attributes of records, which may have the same names, are none."""
    loaded = [entry.argval for entry in dis.get_instructions(function) if entry.opname in ("LOAD_GLOBAL", "LOAD_NAME")]
    return list(dict.fromkeys(loaded))


class Rebinder:
    """Rebinds model functions, each once.

    Args:
        names: what each mathematical name means here.
        wrap: applied to every rebound function (a compiler's decorator).
        stand_ins: what is called in place of a model function, as it is.
        sources: files of all functions and records seen, for cache keys.
    """

    def __init__(
        self,
        names: dict[str, Any],
        wrap: Wrap = lambda function: function,
        stand_ins: Mapping[Callable[..., Any], Callable[..., Any]] | None = None,
    ) -> None:
        self._names = names
        self._wrap = wrap
        self._done: dict[Callable[..., Any], Any] = dict(stand_ins or {})
        self.sources: set[Path] = set()

    def __call__(self, function: Callable[..., Any]) -> Any:
        """Return the backend's version of a model function."""
        if not isinstance(function, FunctionType):
            raise TypeError(f"{function!r} is not a model function")
        if function not in self._done:
            self._done[function] = self._wrap(self._rebound(function))
        return self._done[function]

    def _rebound(self, function: FunctionType) -> FunctionType:
        code = function.__code__
        self.sources.add(Path(code.co_filename))
        world = function.__globals__
        names: dict[str, Any] = {"__name__": world["__name__"], "__builtins__": builtins}
        for name in code.co_names:
            if name in world:
                names[name] = self._translate(name, world[name])
            # A field of a record may bear the name; reading the code takes 0.4 ms, so it is read for such names alone.
            elif name in FORBIDDEN and name in global_names(function):
                raise TypeError(f"model function {function.__qualname__} uses the builtin '{name}'")
        closure = tuple(
            CellType(self._translate(name, cell.cell_contents))
            for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True)
        )
        rebound = FunctionType(code, names, function.__name__, function.__defaults__, closure)
        rebound.__qualname__ = function.__qualname__
        return rebound

    def _translate(self, name: str, value: Any) -> Any:
        if name in PRIMITIVES and value is PRIMITIVES[name]:
            return self._names[name]
        if isinstance(value, FunctionType) and not _is_record_helper(value):
            return self(value)
        if isinstance(value, type):
            self.sources.add(source_of(value))
        return value


def _is_record_helper(function: FunctionType) -> bool:
    return function.__module__ in ("typing", "collections")
