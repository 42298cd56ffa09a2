"""Border of the public functions: arguments by name and type, refused with what is allowed."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import cache, wraps
from numbers import Integral, Real
from os import PathLike
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin

from plant.errors import InputError, UnknownNameError, shortened

F = TypeVar("F", bound=Callable[..., Any])
NUMBERS = {int: Integral, float: Real, bool: Integral}
# Classes whose items are looked at; arrays and series count as sequences.
CONTAINERS = (Mapping, Sequence, list, tuple, dict)
# Names of options of the command line that Python calls otherwise.
OTHER_NAMES = {"seeds": "flights", "change": "changes", "set": "changes"}
CLASS_NAMES = {Path: "a path", str: "text", NoneType: "None", Mapping: "a dict", Sequence: "a list"}
STUDIES = ("ComparisonStudy", "SearchedStudy")
# Class among the allowed ones, attribute or class of the value -> the remedy.
REMEDIES = (
    ("Gains", "gains", "design.gains"),
    ("Gains", "recommended", "results.recommended"),
    ("Gains", "default_row", "tuner.default_gains(study)"),
    ("a list of", "judge_margins", "a list of them, [gains]"),
    ("Gains", "items", "tuner.default_gains(study).replace(values)"),
    ("a study", "items", "tuner.make_study(tables)"),
)
# Most classes of items that a message lists.
MAX_CLASSES = 4


def checked(function: F) -> F:
    """Return a function that refuses unknown and wrong arguments with an InputError."""
    signature = inspect.signature(function)

    @wraps(function)
    def call(*args: Any, **named: Any) -> Any:
        for name in named.keys() - signature.parameters.keys():
            _refuse_name(function.__name__, name, signature)
        try:
            bound = signature.bind(*args, **named)
        except TypeError as error:
            raise InputError(f"{error}; arguments: {', '.join(signature.parameters)}", key=function.__name__) from None
        for name, value in bound.arguments.items():
            parameter = signature.parameters[name]
            values = value if parameter.kind is parameter.VAR_KEYWORD else {name: value}
            for each, content in values.items():
                _check_type(f"{function.__name__}: {each}", content, parameter.annotation)
        return function(*args, **named)

    return call  # pyright: ignore[reportReturnType]


def _refuse_name(function: str, name: str, signature: inspect.Signature) -> None:
    arguments = signature.parameters
    if any(parameter.kind is parameter.VAR_KEYWORD for parameter in arguments.values()):
        return
    if OTHER_NAMES.get(name) in arguments:
        raise InputError(f"unknown argument '{name}'; in Python it is {OTHER_NAMES[name]}", key=function)
    raise UnknownNameError("argument", name, arguments, key=function)


def _check_type(key: str, value: object, hint: Any) -> None:
    if hint is inspect.Parameter.empty or accepts(value, hint):
        return
    allowed = class_names(hint)
    wrong = next((each for each in value if not isinstance(each, str)), value) if isinstance(value, list) else value
    remedy = next(
        (f"; give {text}" for kind, mark, text in REMEDIES if kind in str(allowed) and hasattr(wrong, mark)), ""
    )
    raise InputError(f"given {_name_of(value)}; allowed: {', '.join(allowed)}{remedy}", key=key)


def _name_of(value: object) -> str:
    items = list(value.values()) if isinstance(value, dict) else value
    if isinstance(items, list | tuple) and items:
        return f"{type(value).__name__} with {_name_of(items[0])}"
    return shortened(repr(value)) if isinstance(value, str | int | float) or value is None else type(value).__name__


def accepts(value: object, hint: Any) -> bool:
    """Return True for a value that a type annotation includes; protocols and names of types include all."""
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return any(accepts(value, each) for each in inner)
    if hint in NUMBERS:
        return isinstance(value, NUMBERS[hint]) and (hint is bool or not isinstance(value, bool))
    kind = NoneType if hint is None else origin or hint
    if not isinstance(kind, type) or getattr(kind, "_is_protocol", False):
        return True
    if kind is Path:
        return isinstance(value, PathLike)
    if kind not in CONTAINERS:
        return isinstance(value, kind)
    return hasattr(value, "__array__") or (_contains(value, kind) and _accepts_items(value, inner))


def _contains(value: object, kind: type) -> bool:
    return isinstance(value, kind) and not isinstance(value, str)


def _accepts_items(value: Any, inner: tuple[Any, ...]) -> bool:
    items = value.values() if isinstance(value, Mapping) else value
    return not inner or all(accepts(each, inner[1 if isinstance(value, Mapping) else 0]) for each in items)


@cache
def class_names(hint: Any) -> tuple[str, ...]:
    """Return the names of the classes in an annotation."""
    inner = get_args(hint)
    if get_origin(hint) in (Union, UnionType):
        names = [name for each in inner for name in class_names(each)]
        return tuple(dict.fromkeys(names))
    kind = get_origin(hint) or hint
    name = CLASS_NAMES.get(kind) or getattr(kind, "__name__", str(kind))
    items = class_names(inner[-1]) if inner and kind is not type else ()
    if 0 < len(items) <= MAX_CLASSES:
        return (f"{name} of {' or '.join(items)}",)
    return ("a study" if name in STUDIES else name,)
