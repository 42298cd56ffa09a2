"""Model functions: written out as lines, and the rules that those of the user's own are checked by before a backend takes them.

A model function is a pure function of scalars: no `if` on a value, no loop over time, no state that hides between calls, nothing
from outside but numbers, records, other such functions and `plant.primitives`. Backends rebind its names, so mathematics from
elsewhere would stay in Python.
"""

import ast
import builtins
import inspect
import linecache
import textwrap
from collections.abc import Callable, Iterator
from types import FunctionType, ModuleType
from typing import Any

from plant import primitives
from plant.backends.rebind import global_names
from plant.errors import InputError

# Statements that a model function cannot have, and what to write in their place.
REFUSED: dict[type[ast.AST], str] = {
    ast.If: "an `if` on a value; write select(condition, a, b)",
    ast.IfExp: "an `if` on a value; write select(condition, a, b)",
    ast.BoolOp: "`and` or `or` on values; write both(a, b) or either(a, b)",
    ast.Not: "`not` on a value; write the opposite comparison",
    ast.Assert: "`assert`; a model function cannot fail",
    ast.Raise: "`raise`; a model function cannot fail",
    ast.Match: "a `match` on a value; write select(condition, a, b)",
    ast.While: "a loop; write the terms out",
    ast.For: "a loop; write the terms out",
    ast.Global: "a state that hides between calls; keep it in {memory}",
    ast.Nonlocal: "a state that hides between calls; keep it in {memory}",
    ast.Try: "`try`; a model function cannot fail",
    ast.Import: "an import; write it at the top of the file",
    ast.ImportFrom: "an import; write it at the top of the file",
}
HIDDEN = "a state that hides between calls, '{name}'; keep it in {memory}"
CHAIN = "a chain of comparisons; write both(a < b, b < c)"
# What cannot change between calls, and other functions, which are looked at themselves.
ALLOWED = (int, float, str, tuple, FunctionType)
# Builtins that a look at the globals does not find; on arrays and symbols they mean something else.
BUILTINS = {
    "abs": "absolute",
    "min": "minimum",
    "max": "maximum",
    "round": "floor",
    **dict.fromkeys(("bool", "float", "int", "len", "pow", "print", "sum"), ""),
}


def written(name: str, lines: list[str], names: dict[str, Any]) -> Callable[..., Any]:
    """Return the function that stands in these lines, with names as its globals; tracebacks show the lines."""
    source = "\n".join(lines) + "\n"
    file = f"<{name} of the loop>"
    linecache.cache[file] = (len(source), None, source.splitlines(True), file)
    world: dict[str, Any] = {"__name__": __name__, **names}
    exec(compile(source, file, "exec"), world)
    return world[name]


def place_of(thing: Any, file: str, line: int = 0) -> str:
    """Return file and line of a class or function of the user's; the file alone where its source is not to be had."""
    try:
        _, first = inspect.getsourcelines(thing)
    except (OSError, TypeError):
        return file
    # It may stand in a file that the user's own imports.
    if isinstance(thing, FunctionType):
        file = thing.__code__.co_filename
    return f"{file}:{first + line}"


def place_of_field(record: Any, name: str, file: str) -> str:
    """Return file and line of a field of a record of the user's; those of the record where its source is not to be had."""
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(record)))
    except (OSError, TypeError, SyntaxError):
        return place_of(record, file)
    lines = [
        node.lineno
        for node in ast.walk(tree)
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.target.id == name
    ]
    return place_of(record, file, lines[0] - 1 if lines else 0)


def check_model_function(
    function: Any, name: str, arguments: int, file: str, memory: str = "State"
) -> Callable[..., Any]:
    """Return a model function of so many arguments, after a look at it and at all that it calls; InputError with its line.

    memory: the record that holds what goes from one call to the next.
    """
    if not isinstance(function, FunctionType):
        given = "nothing" if function is None else repr(function)
        raise InputError(f"given {given}; write def {name}(...) with {arguments} arguments", file=file, key=name)
    count = function.__code__.co_argcount
    if count != arguments:
        place = place_of(function, file)
        raise InputError(f"takes {count} arguments; it must take {arguments}", file=place, key=name)
    for each in _reached(function, {}):
        _check_statements(each, file, memory)
        _check_names(each, file, memory)
    return function


def _reached(function: FunctionType, seen: dict[FunctionType, None]) -> Iterator[FunctionType]:
    """Yield a function and the functions of the user's that it calls."""
    if function in seen or function.__module__ in (primitives.__name__, "typing", "collections"):
        return
    seen[function] = None
    yield function
    for name in global_names(function):
        value = function.__globals__.get(name)
        if isinstance(value, FunctionType):
            yield from _reached(value, seen)


def _check_statements(function: FunctionType, file: str, memory: str) -> None:
    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    except (OSError, TypeError, SyntaxError):
        return
    for node in ast.walk(tree):
        reason = next((text for kind, text in REFUSED.items() if isinstance(node, kind)), None)
        if reason is None and isinstance(node, (ast.Attribute, ast.Subscript)) and isinstance(node.ctx, ast.Store):
            reason = HIDDEN.replace("{name}", ast.unparse(node))
        if isinstance(node, ast.Compare) and len(node.ops) > 1:
            reason = CHAIN
        if reason is not None:
            place = place_of(function, file, _line_of(node, tree) - 1)
            raise InputError(reason.replace("{memory}", memory), file=place, key=function.__name__)


def _line_of(node: ast.AST, tree: ast.AST) -> int:
    """Return the line of a node; an operator has that of the expression around it."""
    around = next((outer for outer in ast.walk(tree) if node in ast.iter_child_nodes(outer)), node)
    return getattr(node, "lineno", getattr(around, "lineno", 1))


def _check_names(function: FunctionType, file: str, memory: str) -> None:
    for name in global_names(function):
        value = function.__globals__.get(name)
        if value is None and name in BUILTINS:
            instead = f"; write {BUILTINS[name]}" if BUILTINS[name] else ""
            message = f"uses the builtin '{name}', which backends cannot replace{instead}"
            raise InputError(message, file=place_of(function, file), key=function.__name__)
        is_missing = name not in function.__globals__ and not hasattr(builtins, name)
        is_outside = isinstance(value, ModuleType) or (callable(value) and not _is_record(value))
        is_allowed = value is None or isinstance(value, ALLOWED) or value in vars(primitives).values()
        if is_missing or (is_outside and not is_allowed):
            why = "the file does not define" if is_missing else "backends cannot replace"
            raise InputError(
                f"uses '{name}', which {why}; take from plant.primitives: {', '.join(primitives.__all__)}",
                file=place_of(function, file),
                key=function.__name__,
            )
        if not is_allowed and not _is_record(value):
            message = HIDDEN.replace("{name}", name).replace("{memory}", memory)
            raise InputError(message, file=place_of(function, file), key=function.__name__)


def _is_record(value: object) -> bool:
    """Return True for a type of records."""
    return isinstance(value, type) and issubclass(value, tuple)
