"""Signatures of the Python interface name their types: no function, method or property takes or returns `Any`."""

import inspect
import typing
from collections.abc import Callable
from typing import Any

import pytest

import tuner


def public_functions():
    """Names and functions of the interface; methods and properties of its classes, as far as they are written here."""
    for name in tuner.__all__:
        entry = getattr(tuner, name)
        members = [(name, entry)] if inspect.isfunction(entry) else []
        if inspect.isclass(entry):
            for attribute, member in inspect.getmembers(entry):
                function = member.fget if isinstance(member, property) else member
                if inspect.isfunction(function) and not attribute.startswith("_"):
                    members.append((f"{name}.{attribute}", function))
        for path, function in members:
            if function.__module__.startswith(("tuner.", "plant.", "objectives.")):
                yield pytest.param(function, id=path)


def mentions_any(annotation):
    """Whether an annotation is `Any`, or has it inside."""
    if isinstance(annotation, list):
        return any(map(mentions_any, annotation))
    if isinstance(annotation, str):
        return "Any" in annotation.replace("AnyStudy", "").replace("AnyResults", "")
    return annotation is Any or any(map(mentions_any, typing.get_args(annotation)))


@pytest.mark.parametrize("function", list(public_functions()))
def test_no_signature_holds_any(function):
    signature = inspect.signature(function)
    annotations = [signature.return_annotation, *(p.annotation for p in signature.parameters.values())]
    assert not [annotation for annotation in annotations if mentions_any(annotation)]


def test_any_inside_a_type_is_seen():
    assert mentions_any(Callable[[dict[str, Any]], int])
    assert mentions_any(dict[str, list[Any]]) and mentions_any("dict[str, Any]")
    assert not mentions_any(dict[str, list[int]]) and not mentions_any("AnyStudy | None")
