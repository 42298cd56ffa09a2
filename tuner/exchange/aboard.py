"""Current parameters of a vehicle, which an export replaces or keeps.

They come from a parameter file (--previous), or from what gains.json recorded when the gains were imported. With them
an export writes what our loops carry, leaves everything else as the vehicle has it, and can say what changes.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from plant.input_files import ReadableFile, file_sha256
from plant.quadrotor.gains import default_row
from tuner.exchange.target import C, ExportRequest, ExportTarget, Option, PlantRequest, Request
from tuner.gains import Controller, content_hash, content_sha256, read_gains, to_document

KEEP = "keep"
MAX_NAME_LETTERS = 128
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
class VehicleParameters:
    """Parameters on the vehicle: name -> value in the target's unit; origin: the file they are known from, for a sentence."""

    values: Mapping[str, float]
    origin: str


def vehicle_parameters(
    request: Request, target: str, read: Callable[[Path], Mapping[str, float]]
) -> VehicleParameters | None:
    """Return the parameters on the vehicle, None if unknown; read: a file of the target, InputError where it is none."""
    known_from = origin(request, target)
    if known_from is None:
        return None
    if request.previous is not None:
        return VehicleParameters(read(request.previous), known_from)
    assert request.controller.vehicle is not None
    return VehicleParameters(request.controller.vehicle.parameters, known_from)


def origin(request: ExportRequest[C], target: str) -> str | None:
    """Return the source of the vehicle's parameters, None where it is unknown."""
    if request.previous is not None:
        return f"the previous file {plain_name(request.previous)}"
    record = request.controller.vehicle
    if record is None or record.target != target:
        return None
    return f"the file {record.file} that the gains were imported from"


def plain_name(file: ReadableFile) -> str:
    """Return a file's name for any text: letters, digits, blanks, dots, dashes and underscores."""
    return re.sub(r"[^A-Za-z0-9 ._-]", "_", file.name)[-MAX_NAME_LETTERS:]


def remembered(controller: C, target: ExportTarget, given: list[str]) -> list[str]:
    """Return the given options, completed by those of the import."""
    record = controller.vehicle
    if record is None or record.target != target.name:
        return given
    named = {entry.partition("=")[0] for entry in given}
    left_open = {option.name for option in target.options} - named
    return [*given, *(f"{name}={value}" for name, value in record.settings.items() if name in left_open)]


def describe_unmanaged(
    present: VehicleParameters | None, unmanaged: Mapping[str, float], assumed: Mapping[str, float]
) -> tuple[str, ...]:
    """Return sentences on the parameters that stay on the vehicle.

    Args:
        present: the parameters on the vehicle, None if unknown.
        unmanaged: those of them that our loops have no counterpart of.
        assumed: those that its file does not hold and that scale the gains.
    """
    if present is None or not unmanaged:
        return ()
    listed = ", ".join(f"{name} = {value:g}" for name, value in unmanaged.items())
    sentences = [
        f"Our loops have no counterpart of these parameters, which stay as the vehicle has them ({present.origin}): {listed}."
    ]
    if assumed:
        taken = ", ".join(f"{name} = {value:g}" for name, value in assumed.items())
        sentences.append(f"Not in {present.origin}, so not written and taken as: {taken}.")
    return tuple(sentences)


def previous_controller(request: Request) -> tuple[Controller, str, str]:
    """Return the controller to restore, its file's digest and a sentence.

    Raises InputError where the previous file is no gains.json.
    """
    controller = request.controller
    if request.previous is not None:
        return read_gains(request.previous), content_sha256(request.previous), "The gains flown before this export."
    defaults = replace(controller, gains=tuple(default_row(controller.cascade, controller.airframe.vehicle)))
    sentence = "The default gains of these laws: no gains.json with the previous ones was given."
    return defaults, content_hash(to_document(defaults, {})), sentence


def plant_rollback(request: PlantRequest) -> tuple[PlantRequest, str]:
    """Return the request for the plant's gains to restore, and a sentence.

    Raises InputError where the previous file is no gains.json of these loops.
    """
    study, previous = request.controller.study, request.previous
    if previous is not None:
        row, digest = study.read_row(previous), file_sha256(previous)
        sentence = "The gains flown before this export."
    else:
        row, digest = study.default_row, ""
        sentence = "The default gains of the study: no gains.json with the previous ones was given."
    former = replace(request.controller, gains=tuple(row.tolist()))
    return replace(request, controller=former, digest=digest, previous=None), sentence


def rollback_request(request: Request) -> tuple[Request, str]:
    """Return the request for the controller to restore, and its sentence."""
    controller, digest, sentence = previous_controller(request)
    return replace(request, controller=controller, digest=digest, previous=None), sentence
