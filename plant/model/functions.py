"""Rules of model functions, checked on the functions of the user's own before a backend takes them.

A model function is a pure function of scalars: no `if` on a value, no loop over time, no state that hides between calls, nothing
from outside but numbers, records, other such functions and `plant.primitives`. Backends rebind its names, so mathematics from
elsewhere would stay in Python.
"""

import ast
import inspect
import textwrap
from collections.abc import Callable, Iterator
from types import BuiltinFunctionType, FunctionType, ModuleType
from typing import Any

from plant import primitives
from plant.errors import InputError

# Statements that a model function cannot have, and what to write in their place.
REFUSED: dict[type[ast.AST], str] = {
    ast.If: "an `if` on a value; write select(condition, a, b)",
    ast.IfExp: "an `if` on a value; write select(condition, a, b)",
    ast.BoolOp: "`and` or `or` on values; write both(a, b) or either(a, b)",
    ast.While: "a loop; write the terms out",
    ast.For: "a loop; write the terms out",
    ast.Global: "a state that hides between calls; keep it in State",
    ast.Nonlocal: "a state that hides between calls; keep it in State",
    ast.Try: "`try`; a model function cannot fail",
    ast.Import: "an import; write it at the top of the file",
    ast.ImportFrom: "an import; write it at the top of the file",
}
HIDDEN = "a state that hides between calls, '{}'; keep it in State"


def place_of(thing: Any, file: str, line: int = 0) -> str:
    """Return file and line of a class or function of the user's; the file alone where its source is not to be had."""
    try:
        _, first = inspect.getsourcelines(thing)
    except (OSError, TypeError):
        return file
    return f"{file}:{first + line}"


def check_model_function(function: Any, name: str, arguments: int, file: str) -> Callable[..., Any]:
    """Return a model function of so many arguments, after a look at it and at all that it calls; InputError with its line."""
    if not isinstance(function, FunctionType):
        given = "nothing" if function is None else repr(function)
        raise InputError(f"given {given}; write def {name}(...) with {arguments} arguments", file=file, key=name)
    count = function.__code__.co_argcount
    if count != arguments:
        place = place_of(function, file)
        raise InputError(f"takes {count} arguments; it must take {arguments}", file=place, key=name)
    for each in _reached(function, {}):
        _check_statements(each, file)
        _check_names(each, file)
    return function


def _reached(function: FunctionType, seen: dict[FunctionType, None]) -> Iterator[FunctionType]:
    """Yield a function and the functions of the user's that it calls."""
    if function in seen or function.__module__ in (primitives.__name__, "typing", "collections"):
        return
    seen[function] = None
    yield function
    for name in function.__code__.co_names:
        value = function.__globals__.get(name)
        if isinstance(value, FunctionType):
            yield from _reached(value, seen)


def _check_statements(function: FunctionType, file: str) -> None:
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        return
    for node in ast.walk(tree):
        reason = next((text for kind, text in REFUSED.items() if isinstance(node, kind)), None)
        if reason is None and isinstance(node, (ast.Attribute, ast.Subscript)) and isinstance(node.ctx, ast.Store):
            reason = HIDDEN.format(ast.unparse(node))
        if reason is not None:
            place = place_of(function, file, getattr(node, "lineno", 1) - 1)
            raise InputError(f"{reason}", file=place, key=function.__name__)


def _check_names(function: FunctionType, file: str) -> None:
    for name in function.__code__.co_names:
        value = function.__globals__.get(name)
        if isinstance(value, (ModuleType, BuiltinFunctionType)) and value not in vars(primitives).values():
            allowed = ", ".join(primitives.__all__)
            raise InputError(
                f"uses '{name}', which backends cannot replace; take from plant.primitives: {allowed}",
                file=place_of(function, file),
                key=function.__name__,
            )
        if isinstance(value, (list, dict, set)):
            raise InputError(HIDDEN.format(name), file=place_of(function, file), key=function.__name__)
