"""The identity of a model: a digest of everything that it is made of, so that no part of it can be forgotten in a key.

Functions count by their code, defaults, closures and the globals that they name; records by their fields; dataclasses field
by field, but for fields that do not count when two are compared. The object of a name is followed to the end.
"""

import hashlib
from collections.abc import Iterator, Mapping, Set
from dataclasses import fields, is_dataclass
from enum import Enum
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np


def identity(value: Any) -> str:
    """Return the digest of model functions, record types, dataclasses and what is built of them; TypeError for others."""
    digest = hashlib.blake2b(digest_size=12)
    for part in _parts(value, {}):
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()


def _parts(value: Any, seen: dict[int, int]) -> Iterator[str]:
    if value is None or isinstance(value, (bool, int, float, complex, str, bytes, Enum, np.generic)):
        yield repr(value)
    elif hasattr(value, "__metadata__"):
        # A number annotated with its unit.
        yield repr(value)
    elif isinstance(value, (ModuleType, BuiltinFunctionType, np.ufunc)):
        yield value.__name__
    elif isinstance(value, Mapping):
        yield f"mapping of {len(value)}"
        for key in sorted(value, key=repr):
            yield repr(key)
            yield from _parts(value[key], seen)
    elif isinstance(value, Set):
        yield repr(sorted(map(repr, value)))
    elif isinstance(value, (tuple, list)):
        yield f"{type(value).__name__} of {len(value)}"
        for entry in value:
            yield from _parts(entry, seen)
    elif id(value) in seen:
        yield f"number {seen[id(value)]} again"
    else:
        seen[id(value)] = len(seen)
        yield from _object(value, seen)


def _object(value: Any, seen: dict[int, int]) -> Iterator[str]:
    if isinstance(value, FunctionType):
        yield from _function(value, seen)
    elif isinstance(value, type):
        yield value.__qualname__
        if issubclass(value, tuple):
            # The order of fields is the order of rows, so it counts.
            yield from _parts(list(value.__annotations__.items()), seen)
    elif is_dataclass(value):
        yield type(value).__qualname__
        for field in fields(value):
            if field.compare:
                yield field.name
                yield from _parts(getattr(value, field.name), seen)
    else:
        raise TypeError(f"{value!r} has no identity: a model is made of functions, records and numbers")


def _function(function: FunctionType, seen: dict[int, int]) -> Iterator[str]:
    yield function.__qualname__
    yield from _code(function.__code__)
    yield from _parts((function.__defaults__, function.__kwdefaults__), seen)
    for cell in function.__closure__ or ():
        yield from _parts(cell.cell_contents, seen)
    for name in _names(function.__code__):
        if name in function.__globals__:
            yield name
            yield from _parts(function.__globals__[name], seen)


def _code(code: CodeType) -> Iterator[str]:
    yield code.co_code.hex()
    yield repr((code.co_names, code.co_varnames, code.co_freevars))
    for constant in code.co_consts:
        yield from _code(constant) if isinstance(constant, CodeType) else _parts(constant, {})


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)
