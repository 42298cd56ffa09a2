"""Problems of a gains.json, all at once: one error in our words for each, with its key."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from re import search
from typing import Any

from plant.errors import InputError, UnknownNameError
from plant.law_registry import LAWS
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.gains import GainAddress, gain_addresses
from plant.texts import check_name, check_texts
from tuner.gains.airframe_block import airframe_of, airframe_problems
from tuner.gains.controller import ControllerPart, TunedLoops
from tuner.gains.document import within
from tuner.gains.hashing import content_hash
from tuner.gains.parsing import check_identity, format_of, parsed
from tuner.gains.quantities import GainEntry
from tuner.gains.ranges import check_plant_step, check_value, timing_of
from tuner.gains.schema import gains_schema, validator
from tuner.gains.sections import DIGEST, FORMAT, PLANT_FORMAT, VERSIONS, Row
from tuner.gains.version_0 import brought_up
from tuner.text.input_errors import check_magnitude, dotted, joined, moved, numbers_in
from tuner.text.toml_text import shown

TYPES = {
    "object": "an object",
    "array": "a list",
    "string": "a text",
    "number": "a finite number",
    "integer": "a whole number",
    "boolean": "true or false",
    "null": "null",
}
BOUNDS = {
    "minimum": "at least",
    "exclusiveMinimum": "above",
    "maximum": "at most",
    "exclusiveMaximum": "below",
}
# What a name stands for, by the key that it has, or in which it is one.
KINDS = {"controller.position": "law", "controller.attitude": "law", "gains": "gain"}
# A misspelt key leaves a missing one behind: tell of the misspelling first.
ORDER = {"additionalProperties": 0, "enum": 1, "const": 1, "type": 1, "required": 3}


def not_finite(document: Row) -> Iterator[InputError]:
    """Yield every number that JSON cannot hold, or no double."""
    for key, value in numbers_in(document):
        if not isfinite(value):
            yield InputError(f"given {shown(value)}; this must be a finite number", key=key)


def text_problems(document: Row) -> Iterator[InputError]:
    """Yield the first unprintable text, and an invalid name of an airframe.

    A text is one line of letters that print. The contents of x-* keys are not checked.
    """
    block = document.get("airframe")
    name = block.get("name") if isinstance(block, dict) else None
    try:
        if isinstance(name, str):
            check_name(name, key="airframe.name")
        check_texts({key: value for key, value in document.items() if not key.startswith("x-")})
    except InputError as error:
        yield error


def law_problems(document: Row) -> Iterator[InputError]:
    """Yield every unknown or changed law of a file or package.

    A changed law is not the code that the gains were written with.
    """
    controller = document.get("controller")
    block = controller if isinstance(controller, dict) else {}
    code = block.get("code")
    for loop, entry in (code if isinstance(code, dict) else {}).items():
        name = block.get(loop)
        if isinstance(name, str) and isinstance(entry, dict):
            yield from _law_problem(name, str(entry.get("file")), str(entry.get("digest")), f"controller.{loop}")


def _law_problem(name: str, file: str, digest: str, key: str) -> Iterator[InputError]:
    try:
        origin = LAWS.find(name).origin
    except UnknownNameError:
        what = f"the law '{name}' is that of {file} (digest {digest}), which these gains do not hold"
        yield InputError(f"{what}; name the file with --code {file}", key=key)
        return
    if origin is None or origin.digest != digest:
        present = "is bundled" if origin is None else f"has the digest {origin.digest}"
        yield InputError(
            f"the law '{name}' of {file} had the digest {digest} when these gains were written; the one here {present}: name the "
            "file of then, or tune again",
            key=key,
        )


def schema_problems(document: Row) -> list[InputError]:
    """Return the refusals of the schema, misspelt keys first, missing ones last."""
    errors = sorted(validator().iter_errors(document), key=lambda error: ORDER.get(error.validator, 2))
    unique: dict[tuple[str | None, str], InputError] = {}
    for error in errors:
        for problem in _input_errors(error):
            # The gains of both loops may speak of the same key.
            unique.setdefault((problem.key, type(problem).__name__), problem)
    return list(unique.values())


def _input_errors(error: Any) -> Iterator[InputError]:
    kind, given, allowed, key = error.validator, error.instance, error.validator_value, dotted(error.absolute_path)
    if kind == "additionalProperties":
        properties = error.schema.get("properties", {})
        for name in _unknown(error):
            yield UnknownNameError(KINDS.get(key, "key"), name, list(properties), key=joined(key, name))
    elif kind == "required":
        for name in allowed:
            if name not in given:
                remedy = _remedy(error.schema.get("properties", {}).get(name, {}))
                yield InputError(f"this key is required and missing{remedy}", key=joined(key, name))
    elif kind == "enum" and isinstance(given, str):
        yield UnknownNameError(KINDS.get(key, "choice"), given, allowed, key=key)
    elif kind == "const" and key.endswith(".unit"):
        yield InputError(f"given unit {shown(given)}; this must be in {allowed} (UCUM)", key=key)
    else:
        yield InputError(f"given {shown(given)}; this must be {_expected(kind, allowed)}", key=key)


def _unknown(error: Any) -> list[str]:
    properties, patterns = error.schema.get("properties", {}), error.schema.get("patternProperties", {})
    return [name for name in error.instance if name not in properties and not any(search(p, name) for p in patterns)]


def _remedy(schema: Row) -> str:
    """Return the remedy for a missing quantity."""
    if "$ref" in schema:
        schema = gains_schema()["$defs"][schema["$ref"].removeprefix("#/$defs/")]
    unit = schema.get("properties", {}).get("unit", {}).get("const")
    return "" if unit is None else f'; write {{"value": ..., "unit": "{unit}"}}'


def _expected(kind: str, allowed: Any) -> str:
    if kind == "type":
        return " or ".join(TYPES[name] for name in ([allowed] if isinstance(allowed, str) else allowed))
    if kind in BOUNDS:
        return f"{BOUNDS[kind]} {allowed:g}"
    if kind in ("minItems", "maxItems"):
        return f"a list of {allowed}"
    if allowed in DIGEST.values():
        return "64 hexadecimal digits"
    if kind == "maxLength":
        return f"a text of at most {allowed} letters"
    if kind == "pattern":
        return "16 to 19 digits"
    if kind == "minLength":
        return "a text that is not empty"
    if kind == "enum":
        return f"one of {', '.join(repr(name) for name in allowed)}"
    return shown(allowed)


@dataclass(frozen=True)
class Examined:
    """A file as read: its own content, the same in the current version, and everything that is wrong with it."""

    path: Path
    given: Row
    document: Row
    problems: list[InputError]

    @property
    def digest(self) -> str:
        """Content hash of the file (64 hex digits)."""
        return content_hash(self.given)


def examine(path: Path, airframe: Airframe | None = None) -> Examined:
    """Read a gains.json and find everything that is wrong with it; InputError where it is no gains.json at all."""
    given = parsed(path)
    if format_of(given) == PLANT_FORMAT:
        return Examined(path, given, given, list(_loop_problems(given, path)))
    check_identity(given, path)
    if wrong := [*not_finite(given), *text_problems(given)]:
        return Examined(path, given, given, [moved(error, path, error.key or "") for error in wrong])
    current = given["version"] in VERSIONS
    document = {**given, "format": FORMAT} if current else _brought_up(given, path, airframe)
    wrong = (
        list(law_problems(document)) or schema_problems(document) or list(_semantic_problems(document, airframe, path))
    )
    if current:
        wrong += list(_hash_problems(given))
    return Examined(path, given, document, [moved(error, path, error.key or "") for error in wrong])


def _loop_problems(document: Row, path: Path) -> Iterator[InputError]:
    """Yield the first thing that is wrong with gains of a plant."""
    try:
        TunedLoops.read(document, path)
    except InputError as error:
        yield error


def _brought_up(given: Row, path: Path, airframe: Airframe | None) -> Row:
    try:
        return brought_up(given, path, airframe)
    except InputError as error:
        raise error.located(file=path, key="airframe") from None


def _semantic_problems(document: Row, airframe: Airframe | None, path: Path) -> Iterator[InputError]:
    """Yield what no schema can tell: numbers that contradict each other, gains that the period does not allow."""
    structure, block = ControllerPart.of(document["controller"]), document["airframe"]
    yield from _located("airframe", airframe_problems(block))
    yield from _failed("controller", lambda: structure.options)
    yield from _failed("controller", lambda: _check_timing(structure, airframe or airframe_of(block, path)))
    for gain in gain_addresses(structure.cascade):
        entry = GainEntry(**document["gains"][gain.address])
        yield from _failed("gains", lambda entry=entry, gain=gain: _check_gain(gain, entry, structure.control_period))


def _hash_problems(document: Row) -> Iterator[InputError]:
    try:
        digest = content_hash(document)
    except InputError as error:
        yield error
        return
    if isinstance(document.get("sha256"), str) and document["sha256"] != digest:
        message = f"the content has another hash ({digest}): edited by hand? To accept the edit, remove the key sha256"
        yield InputError(message, key="sha256")


def _check_timing(structure: ControllerPart, airframe: Airframe) -> None:
    check_magnitude(structure.control_period, None, "control_period")
    check_magnitude(structure.plant_step, None, "plant_step")
    check_plant_step(timing_of(structure.control_period, structure.plant_step), airframe)


def _check_gain(gain: GainAddress, entry: GainEntry, period: float) -> None:
    check_magnitude(entry.value, None, f"{gain.address}.value")
    check_value(f"{gain.address}.value", gain, entry.value, period)
    if entry.low > entry.high:
        raise InputError(
            f"given {entry.low:g}; this must not be above high = {entry.high:g}", key=f"{gain.address}.low"
        )
    if not within(entry.value, entry.low, entry.high):
        message = (
            f"given {entry.value:g} {gain.unit}, outside of its range {entry.low:g} to {entry.high:g}: "
            "correct one of them, or leave low and high out"
        )
        raise InputError(message, key=f"{gain.address}.value")


def _failed(key: str, check: Callable[[], object]) -> Iterator[InputError]:
    try:
        check()
    except InputError as error:
        yield from _located(key, iter([error]))


def _located(key: str, errors: Iterator[InputError]) -> Iterator[InputError]:
    for error in errors:
        yield moved(error, None, f"{key}.{error.key}" if error.key else key)
