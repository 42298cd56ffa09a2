"""Everything that is wrong with a gains.json, problem by problem."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path

from plant.airframes import Airframe
from plant.cascade import Cascade, close_cascade
from plant.errors import InputError
from plant.gains import GainAddress, gain_addresses
from plant.laws import law
from plant.nominal import ControlOptions
from tuner.gains.airframe_block import airframe_of, airframe_problems
from tuner.gains.document import within
from tuner.gains.hashing import content_hash
from tuner.gains.parsing import check_identity, parsed
from tuner.gains.problems import not_finite, schema_problems, text_problems
from tuner.gains.ranges import check_value
from tuner.gains.sections import VERSIONS
from tuner.gains.shapes import Row
from tuner.gains.timing import check_plant_step, timing_of
from tuner.gains.version_0 import brought_up
from tuner.text.locating import moved
from tuner.text.magnitude import check_magnitude


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
    check_identity(given, path)
    if wrong := [*not_finite(given), *text_problems(given)]:
        return Examined(path, given, given, [moved(error, path, error.key or "") for error in wrong])
    current = given["version"] in VERSIONS
    document = given if current else _brought_up(given, path, airframe)
    wrong = schema_problems(document) or list(_semantic_problems(document, airframe, path))
    if current:
        wrong += list(_hash_problems(given))
    return Examined(path, given, document, [moved(error, path, error.key or "") for error in wrong])


def _brought_up(given: Row, path: Path, airframe: Airframe | None) -> Row:
    try:
        return brought_up(given, path, airframe)
    except InputError as error:
        raise error.located(file=path, key="airframe") from None


def _semantic_problems(document: Row, airframe: Airframe | None, path: Path) -> Iterator[InputError]:
    """Yield what no schema can tell: numbers that contradict each other, gains that the period does not allow."""
    structure, block = document["controller"], document["airframe"]
    yield from _located("airframe", airframe_problems(block))
    yield from _failed("controller", lambda: options_of(structure))
    yield from _failed("controller", lambda: _check_timing(structure, airframe or airframe_of(block, path)))
    period = structure["control_period"]["value"]
    for gain in gain_addresses(cascade_of(structure)):
        entry = document["gains"][gain.address]
        yield from _failed("gains", lambda entry=entry, gain=gain: _check_gain(gain, entry, period))


def _hash_problems(document: Row) -> Iterator[InputError]:
    try:
        found = content_hash(document)
    except InputError as error:
        yield error
        return
    if isinstance(document.get("sha256"), str) and document["sha256"] != found:
        message = f"the content has another hash ({found}): edited by hand? To accept the edit, remove the key sha256"
        yield InputError(message, key="sha256")


def _check_timing(structure: Row, airframe: Airframe) -> None:
    for key in ("control_period", "plant_step"):
        check_magnitude(structure[key]["value"], None, key)
    timing = timing_of(*[float(structure[key]["value"]) for key in ("control_period", "plant_step")])
    check_plant_step(timing, airframe)


def _check_gain(gain: GainAddress, entry: Row, period: float) -> None:
    check_magnitude(entry["value"], None, f"{gain.address}.value")
    check_value(f"{gain.address}.value", gain, entry["value"], period)
    low, high = entry.get("low", -inf), entry.get("high", inf)
    if low > high:
        raise InputError(f"given {low:g}; this must not be above high = {high:g}", key=f"{gain.address}.low")
    if not within(entry["value"], low, high):
        message = (
            f"given {entry['value']:g} {gain.unit}, outside of the range {low:g} to {high:g} that stands beside it: correct one "
            "of them, or leave low and high out"
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


def cascade_of(structure: Row) -> Cascade:
    """Return the cascade of a "controller" that the schema accepts."""
    return close_cascade(law(structure["position"]), law(structure["attitude"]))


def options_of(structure: Row) -> ControlOptions:
    """Return the options of a "controller" that the schema accepts; raises InputError where one is out of range."""
    return ControlOptions(
        attitude_rate=structure["attitude_rate"],
        position_rate=structure["position_rate"],
        lag_aware=structure["lag_aware"],
        delay=structure["delay"],
        tilt_limit=float(structure["tilt_limit"]["value"]),
        yaw_torque_cutoff=float(structure.get("yaw_torque_cutoff", {"value": 0.0})["value"]),
    )
