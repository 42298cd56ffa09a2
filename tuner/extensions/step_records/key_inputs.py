"""Inputs of a step in a keyed folder: their digests, and the values that a message names where one changed."""

import json
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from typing import TypeAlias

from plant.errors import InputError, shortened
from plant.input_files import parse_json
from plant.texts import toml_table, values_in
from tuner.store.manifest import digest_of

Input: TypeAlias = Mapping[str, str]
"""An input of a step: its digest and the values that a message names, as texts."""
Inputs: TypeAlias = Mapping[str, Input]
"""Name of an input, as a message calls it -> the input."""
DIGEST = "sha256"
"""Name of the digest in an input; no message shows it."""
MAX_VALUES = 1000
"""Values of a file that are recorded for messages; the digest covers all."""
N_SHOWN = 3
"""Changed values of an input that a message names."""
ABSENT_FILE = "none"
"""Text of a value that is not there."""


def step_key(inputs: Inputs, before: str) -> str:
    """Return the key of a step; before: that of the step before it."""
    text = json.dumps([before, {name: dict(value) for name, value in inputs.items()}], sort_keys=True)
    return sha256(text.encode()).hexdigest()


def changes(before: Inputs, now: Inputs) -> list[str]:
    """Return the changed inputs, each with up to three of its values."""
    names = [*before, *[name for name in now if name not in before]]
    return [_change(name, before.get(name), now.get(name)) for name in names if before.get(name) != now.get(name)]


def _change(name: str, before: Input | None, now: Input | None) -> str:
    if before is None or now is None:
        return f"{name} was {'not given before and is now' if before is None else 'given before and is not now'}"
    keys = [key for key in dict.fromkeys([*before, *now]) if key != DIGEST and before.get(key) != now.get(key)]
    pairs = [f"{key} {before.get(key, ABSENT_FILE)} -> {now.get(key, ABSENT_FILE)}" for key in keys]
    shown = ", ".join([shortened(pair) for pair in pairs[:N_SHOWN]] + ["..."] * (len(pairs) > N_SHOWN))
    return f"{name} changed" + (f" ({shown})" if shown else "")


def file_input(name: str, content: bytes) -> dict[str, str]:
    """Return a file as an input: its digest, and the values in it where it is TOML or JSON.

    Args:
        name: Name of the file, whose ending tells its kind.
        content: Its bytes.
    """
    return {**dict(_named_values(name, content)[:MAX_VALUES]), DIGEST: digest_of(content)}


def _named_values(name: str, content: bytes) -> list[tuple[str, str]]:
    """Return dotted keys and values of a TOML or JSON file; none of one that cannot be read, which its reader reports."""
    if not name.endswith((".toml", ".json")):
        return []
    try:
        text = content.decode()
        table = toml_table(text, Path(name)) if name.endswith(".toml") else parse_json(text)
    except (ValueError, InputError):
        return []
    # A number with unit and source is the entry "value" of its table.
    return [(key.removesuffix(".value"), str(value)) for key, value in values_in(table)]
