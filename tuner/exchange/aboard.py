"""Parameters that a vehicle flies at present, which an export replaces or keeps.

It comes from a parameter file (--previous), or from what gains.json recorded when the gains were imported. With it an export
writes what our loops carry, leaves everything else as the vehicle has it, and can say what changes.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from plant.gains import default_row
from tuner.exchange.target import ExportTarget, Option, Request
from tuner.gains import Controller, content_hash, content_sha256, read_gains, to_document

KEEP = "keep"
MOST_NAME = 128
OTHERS = Option(
    "others",
    "what acts in these loops and ours have not (see the import): keep what is on the vehicle, or switch it off",
    (KEEP, "off"),
    KEEP,
)
DERIVATIVE = Option(
    "rate_derivative",
    "gains on measured acceleration, which our law has not: drop leaves them out, inertia counts them as added inertia",
    ("drop", "inertia"),
    "drop",
)


@dataclass(frozen=True)
class Aboard:
    """Parameters on the vehicle: name -> value in the target's unit; origin: the file they are known from, for a sentence."""

    values: Mapping[str, float]
    origin: str


def aboard(request: Request, target: str, read: Callable[[Path], Mapping[str, float]]) -> Aboard | None:
    """Return the parameters on the vehicle, None if unknown; read: a file of the target, InputError where it is none."""
    known_from = origin(request, target)
    if known_from is None:
        return None
    if request.previous is not None:
        return Aboard(read(request.previous), known_from)
    assert request.controller.vehicle is not None
    return Aboard(request.controller.vehicle.parameters, known_from)


def origin(request: Request, target: str) -> str | None:
    """Return the source of the parameters on the vehicle, None where they are not known."""
    if request.previous is not None:
        return f"the previous file {plain_name(request.previous)}"
    record = request.controller.vehicle
    if record is None or record.target != target:
        return None
    return f"the file {record.file} that the gains were imported from"


def plain_name(file: Path) -> str:
    """Return the name of a file as it may stand in any text: letters, digits, blanks, dots, dashes and underscores."""
    return re.sub(r"[^A-Za-z0-9 ._-]", "_", file.name)[-MOST_NAME:]


def remembered(controller: Controller, target: ExportTarget, given: list[str]) -> list[str]:
    """Return the options with those of the import that the person did not give anew."""
    record = controller.vehicle
    if record is None or record.target != target.name:
        return given
    named = {entry.partition("=")[0] for entry in given}
    known = {option.name for option in target.options} - named
    return [*given, *(f"{name}={value}" for name, value in record.settings.items() if name in known)]


def said_of_others(present: Aboard | None, kept: Mapping[str, float], assumed: Mapping[str, float]) -> tuple[str, ...]:
    """Return sentences on what stays on the vehicle; kept: parameters as the vehicle has them, assumed: those that its file
    does not tell and that scale the gains.
    """
    if present is None or not kept:
        return ()
    there = ", ".join(f"{name} = {value:g}" for name, value in kept.items())
    sentences = [
        f"Our loops have no counterpart of these parameters, which stay as the vehicle has them ({present.origin}): {there}."
    ]
    if assumed:
        taken = ", ".join(f"{name} = {value:g}" for name, value in assumed.items())
        sentences.append(f"Not in {present.origin}, so not written and taken as: {taken}.")
    return tuple(sentences)


def previous_controller(request: Request) -> tuple[Controller, str, str]:
    """Return the controller to go back to, the digest that its file names, and one sentence that says what it is.

    Raises InputError where the previous file is no gains.json.
    """
    controller = request.controller
    if request.previous is not None:
        return read_gains(request.previous), content_sha256(request.previous), "The gains flown before this export."
    defaults = replace(controller, gains=tuple(default_row(controller.cascade, controller.airframe.vehicle)))
    sentence = "The default gains of these laws: no gains.json with the previous ones was given."
    return defaults, content_hash(to_document(defaults, {})), sentence


def rollback_request(request: Request) -> tuple[Request, str]:
    """Return the request that would have exported the controller to go back to, and the sentence that says what it is."""
    controller, digest, sentence = previous_controller(request)
    return replace(request, controller=controller, digest=digest, previous=None), sentence
