"""Parsing of a gains.json, with checks of its format and version."""

import json
from pathlib import Path
from re import fullmatch
from typing import Any

from plant.errors import InputError
from plant.input_files import given_text
from plant.texts import json_table
from tuner.gains.sections import FORMAT, PLANT_FORMAT, VERSION, VERSIONS, Row
from tuner.text.product import current_format
from tuner.text.sentences import listing
from tuner.text.toml_text import shown

FIRST_VERSION = "0.1"
UPDATE = "update gainproof"
WANTED = "give the gains.json of a results folder"
IMPORT = "`tuner import FILE --from SOURCE --airframe NAME` writes one from a vehicle's parameter file"


def parsed(path: Path) -> Row:
    """Return the content; raises InputError where it is no JSON object, or one with a key twice."""
    text = given_text(path, WANTED)
    content = text.lstrip()
    if not content.startswith(("{", "[")):
        line = 1 + text[: len(text) - len(content)].count("\n")
        raise InputError(f"not JSON, line {line} begins with no {{; {WANTED}: {IMPORT}", file=path)
    document = json_table(text, path)
    twice: list[str] = []
    json.loads(text, object_pairs_hook=lambda pairs: _noting_twice(pairs, twice))
    if twice:
        raise InputError("this key occurs twice in one object; remove one", file=path, key=twice[0])
    return document


def _noting_twice(pairs: list[tuple[str, Any]], twice: list[str]) -> Row:
    seen: Row = {}
    for name, value in pairs:
        if name in seen:
            twice.append(name)
        seen[name] = value
    return seen


def format_of(document: Row) -> object:
    """Return the format of a document under the project's present name."""
    return current_format(document.get("format"))


def check_identity(document: Row, path: Path) -> None:
    """Raise InputError for no gains.json, or one of an unknown version."""
    if format_of(document) == PLANT_FORMAT:
        raise InputError(
            "holds gains of a user plant; this command is for quadrotors: `tuner show` and `tuner report` take "
            "the results folder",
            file=path,
            key="format",
        )
    if format_of(document) != FORMAT:
        given = f"given {shown(document['format'])}" if "format" in document else "this key is missing"
        message = f"{given}; this must be '{FORMAT}': {WANTED}"
        raise InputError(message, file=path, key="format")
    version = document.get("version")
    if version in (FIRST_VERSION, *VERSIONS):
        return
    readable = f"this gainproof reads {listing([FIRST_VERSION, *VERSIONS])}"
    if "version" not in document:
        raise InputError(f'this key is missing; {readable}: write "version": "{VERSION}"', file=path, key="version")
    if isinstance(version, str) and fullmatch(r"1\.[0-9]+", version):
        message = f"written in version {version} of the format{_writer(document)}; {readable}: {UPDATE}"
    else:
        message = f"unknown version {shown(version)}{_writer(document)}; {readable}: {UPDATE}, or write the file again"
    raise InputError(message, file=path, key="version")


def _writer(document: Row) -> str:
    generator = document.get("generator")
    if not isinstance(generator, dict):
        return ""
    words = [str(generator[key])[:40] for key in ("name", "version") if isinstance(generator.get(key), str)]
    return f" by {' '.join(words)}" if words else ""
