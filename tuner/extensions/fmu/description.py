"""modelDescription.xml of an FMU (FMI 2.0 and 3.0): what it takes and shows, with units, and what its code is called.

The text is whatever its maker wrote: it has no document type, so no entities, and only checked names and numbers leave this file.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from keyword import iskeyword
from math import isfinite
from pathlib import Path
from typing import NamedTuple
from xml.etree.ElementTree import Element, ParseError, fromstring

from plant.errors import InputError, one_line, shortened
from plant.texts import LONGEST_TITLE, check_text

# Largest value reference, and most variables of which anything is kept.
MAX_REFERENCE, MAX_VARIABLES = 2**32 - 1, 500_000
LONGEST_NAME, LONGEST_UNIT = 120, 40
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,199}")
INPUT, OUTPUT, PARAMETER, OTHER = "input", "output", "parameter", "other"
ROLES = {"input": INPUT, "output": OUTPUT, "parameter": PARAMETER}


class FmuVariable(NamedTuple):
    """A real scalar of an FMU.

    name: as studies write it; given: as the FMU calls it. unit: "" where none is stated. start: 0 where none is stated.
    """

    name: str
    given: str
    reference: int
    role: str
    unit: str
    start: float


@dataclass(frozen=True)
class Description:
    """Used content of modelDescription.xml.

    version: of FMI, 2 or 3. model: its name; title: its description. identifier: of its machine code. token: that this code
    asks for. states, derivatives: value references of its continuous states and of their derivatives, none where it does not
    say. directional: whether it gives directional derivatives.
    """

    version: int
    model: str
    title: str
    identifier: str
    token: str
    variables: tuple[FmuVariable, ...]
    states: tuple[int, ...]
    derivatives: tuple[int, ...]
    directional: bool


def read_description(content: bytes, file: Path) -> Description:
    """Return the description of an FMU for co-simulation; InputError for another and for a text that cannot be trusted."""
    root = _root(content, file)
    given = root.get("fmiVersion", "")
    version = int(given[0]) if re.fullmatch(r"[23]\.\d.*", given) else 0
    if not version:
        raise InputError(f"is of FMI {shortened(one_line(given)) or '(not said)'}; read are FMI 2.0 and 3.0", file=file)
    simulation = root.find("CoSimulation")
    if simulation is None:
        kinds = [kind for kind in ("ModelExchange", "ScheduledExecution") if root.find(kind) is not None]
        raise InputError(
            f"is no co-simulation ({', '.join(kinds) or 'of no kind'}), so it brings no solver; export it for co-simulation",
            file=file,
        )
    identifier = simulation.get("modelIdentifier", "")
    if not IDENTIFIER.fullmatch(identifier):
        raise InputError(f"its modelIdentifier is '{shortened(one_line(identifier))}'; allowed: a name of C", file=file)
    variables = tuple(_variables(root, version, file))
    states, derivatives = _states(root, version)
    return Description(
        version,
        _text(root.get("modelName", identifier), file),
        _text(root.get("description", ""), file),
        identifier,
        _text(root.get("guid" if version == 2 else "instantiationToken", ""), file),
        variables,
        states,
        derivatives,
        simulation.get(f"providesDirectionalDerivative{'s' if version == 3 else ''}") in ("true", "1"),
    )


def _root(content: bytes, file: Path) -> Element:
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content or b"\0" in content:
        raise InputError(
            "its modelDescription.xml declares a document type, which no FMU needs; it is not read", file=file
        )
    try:
        root = fromstring(content)
    except (ParseError, ValueError, LookupError) as error:
        raise InputError(f"its modelDescription.xml is no XML: {error}; export it again", file=file) from None
    if root.tag != "fmiModelDescription":
        raise InputError(f"its modelDescription.xml describes '{shortened(one_line(root.tag))}' and no FMU", file=file)
    return root


def _text(text: str, file: Path) -> str:
    line = shortened(" ".join(text.split()), LONGEST_TITLE)
    check_text(line, LONGEST_TITLE, file=file, key="modelDescription.xml")
    return line


def _number(text: str | None, key: str, file: Path) -> float:
    try:
        value = float(text or "0")
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        shown = shortened(one_line(text or ""))
        raise InputError(f"its modelDescription.xml gives '{shown}' for {key}; allowed: a finite number", file=file)
    return value


def _variables(root: Element, version: int, file: Path) -> Iterator[FmuVariable]:
    """Yield the real scalars of a description."""
    listing = root.find("ModelVariables")
    units = _declared_units(root, version)
    for entry in [] if listing is None else list(listing)[:MAX_VARIABLES]:
        real = entry if version == 3 else entry.find("Real")
        if real is None or (version == 3 and (entry.tag != "Float64" or entry.find("Dimension") is not None)):
            continue
        given = entry.get("name", "")
        role = ROLES.get(entry.get("causality", "local"), OTHER)
        unit = real.get("unit") or units.get(real.get("declaredType", ""), "")
        check_text(given, LONGEST_NAME, file=file, key="modelDescription.xml")
        check_text(unit, LONGEST_UNIT, file=file, key=given)
        start = _number(real.get("start"), given, file)
        yield FmuVariable(
            as_name(given), given, _reference(entry.get("valueReference", ""), given, file), role, unit, start
        )


def _declared_units(root: Element, version: int) -> dict[str, str]:
    """Return the unit of each declared type that has one."""
    types = root.find("TypeDefinitions")
    declared: dict[str, str] = {}
    for entry in [] if types is None else types:
        real = entry if version == 3 else entry.find("Real")
        if real is not None:
            declared[entry.get("name", "")] = real.get("unit", "")
    return declared


def _reference(text: str, key: str, file: Path) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 12 and int(text) <= MAX_REFERENCE):
        raise InputError(
            f"its modelDescription.xml gives '{shortened(one_line(text))}' as valueReference", file=file, key=key
        )
    return int(text)


def _states(root: Element, version: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the value references of continuous states and of their derivatives; none where they do not go together."""
    listing = root.find("ModelVariables")
    entries = [] if listing is None else list(listing)
    if version == 2:
        by_key = {str(i + 1): entry for i, entry in enumerate(entries)}
        listed = [entry.get("index", "") for entry in root.findall("ModelStructure/Derivatives/Unknown")]
    else:
        by_key = {entry.get("valueReference", ""): entry for entry in entries}
        listed = [entry.get("valueReference", "") for entry in root.findall("ModelStructure/ContinuousStateDerivative")]
    rates = [by_key.get(name) for name in listed]
    states = [None if rate is None else by_key.get(_state_of(rate, version)) for rate in rates]
    references = [
        ["" if each is None else each.get("valueReference", "") for each in group] for group in (states, rates)
    ]
    if not all(text.isdigit() for group in references for text in group):
        return (), ()
    return tuple(map(int, references[0])), tuple(map(int, references[1]))


def _state_of(rate: Element, version: int) -> str:
    """Return the key of a derivative's state: an index in FMI 2, a value reference in FMI 3."""
    real = rate.find("Real") if version == 2 else rate
    return "" if real is None else real.get("derivative", "")


def as_name(given: str) -> str:
    """Return the name of a variable in studies: _ in place of all but letters and digits, a letter in front."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", given).strip("_")
    name = name if name[:1].isalpha() else f"v{name}"
    return f"{name}_" if iskeyword(name) else name
