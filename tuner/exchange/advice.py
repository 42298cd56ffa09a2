"""Advice of a refused export: the option or the target with which the same gains can be exported, found by trying.

A refusal says which number has no form in the target. Here each other choice of the target's options, one at a time, and then
portable code are tried, so that the message ends with a command that works.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from plant.errors import InputError
from tuner.exchange.c99 import export as c99
from tuner.exchange.registry import settings_of
from tuner.exchange.target import FIRMWARE, ExportRequest, ExportTarget, flag

Bundling = Callable[[ExportTarget, ExportRequest[Any]], Any]


def bundle_or_advise(target: ExportTarget, request: ExportRequest[Any], bundle: Bundling) -> Any:
    """Return the bundle of a request; InputError ends with the option or target that works.

    Args:
        target: Target of the export.
        request: Gains with the chosen options.
        bundle: Function from a target and a request to a bundle.
    """
    try:
        return bundle(target, request)
    except InputError as error:
        # A wrong file of the vehicle is as wrong with every option.
        advice = "" if error.file is not None else next(working_advice(target, request, bundle), "")
        if not advice:
            raise
        raise InputError(f"{error.message}; {advice}", key=error.key) from None


def working_advice(target: ExportTarget, request: ExportRequest[Any], bundle: Bundling) -> Iterator[str]:
    """Yield the options and the target that work, as sentences."""
    for option in target.options:
        # The firmware is that of the vehicle, and no choice.
        for choice in option.choices if option.name != FIRMWARE else ():
            changed = replace(request, settings={**request.settings, option.name: choice})
            if changed.settings != request.settings and _is_exported(target, changed, bundle):
                yield f"{flag(option.name)}={choice} exports these gains"
    code = c99.TARGET
    if target.name != code.name:
        plain = replace(request, settings=settings_of(code, ()), previous=None)
        if _is_exported(code, plain, bundle):
            yield f"--to {code.name} exports these gains as code"


def _is_exported(target: ExportTarget, request: ExportRequest[Any], bundle: Bundling) -> bool:
    try:
        bundle(target, request)
    except InputError:
        return False
    return True
