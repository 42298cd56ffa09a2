"""The YAML file of parameters for the Crazyflie's Python library.

bitcraze/crazyflie-lib-python, cflib/localization/param_io.py: `type: persistent_param_state`, `version: '1'` (a text: a number
is refused), and under `params` for each parameter is_stored, default_value, stored_value. `cflib.utils.param_file_helper` stores
such a file on the vehicle.
"""

import re
from collections.abc import Iterable, Mapping

from plant.errors import InputError
from plant.input_files import ReadableFile
from tuner.extensions.autopilots.parameters import as_bytes, enter, positional, read_lines, read_number
from tuner.extensions.crazyflie.map import INTEGERS, TABLE

TYPE, VERSION = "persistent_param_state", "1"
_NAME = r"(\w+\.\w+):"
_FLOW = re.compile(rf"\s+{_NAME}\s*\{{([^}}]*)\}}\s*\Z")
_OPEN = re.compile(rf"\s+{_NAME}\s*\Z")
_FIELD = re.compile(r"\s*(is_stored|default_value|stored_value)\s*:\s*([^,\s]+)\s*\Z")
_QUOTED_VERSION = re.compile(r"""version:\s*(['"])1\1\s*\Z""")


def text(comments: Iterable[str], values: Mapping[str, float]) -> bytes:
    """Return the file; values: parameter -> value as the vehicle holds it."""
    lines = [f"# {line}" for line in comments]
    lines += [f"type: {TYPE}", f"version: '{VERSION}'", "params:"]
    for name, value in values.items():
        usual = number(name, TABLE[name].usual)
        lines.append(f"  {name}: {{is_stored: true, default_value: {usual}, stored_value: {number(name, value)}}}")
    return as_bytes(lines)


def number(name: str, value: float) -> str:
    """Return a value as text of its type: an integer without a dot, a float with one, never an exponent."""
    return str(round(value)) if name in INTEGERS else positional(value)


def read(file: ReadableFile) -> dict[str, float]:
    """Return parameter -> stored value, for the parameters that are stored; raises InputError naming what is wrong."""
    lines = [line.split("#")[0].rstrip() for line in read_lines(file, "a parameter file of cflib (YAML)")]
    if f"type: {TYPE}" not in lines:
        raise InputError(f"must be {TYPE}: give a parameter file of cflib (YAML)", file=file, key="type")
    if not any(_QUOTED_VERSION.match(line) for line in lines):
        raise InputError("must be '1', in quotes: cflib refuses a number", file=file, key="version")
    stored: dict[str, float] = {}
    for name, fields in _states(lines, file).items():
        if fields.get("is_stored") == "true":
            enter(stored, name, read_number(fields.get("stored_value", ""), name, file), file)
    return stored


def _states(lines: list[str], file: ReadableFile) -> dict[str, dict[str, str]]:
    """Return parameter -> field -> text: from YAML in flow or block style."""
    states: dict[str, dict[str, str]] = {}
    fields: dict[str, str] = {}
    for line in lines:
        if flow := _FLOW.match(line):
            parts = [_FIELD.match(part) for part in flow[2].split(",")]
            states[flow[1]] = {part[1]: part[2] for part in parts if part}
        elif opening := _OPEN.match(line):
            fields = states.setdefault(opening[1], {})
        elif part := _FIELD.match(line):
            fields[part[1]] = part[2]
        elif line and line[0] == " ":
            raise InputError(
                f"'{line.strip()}' is no parameter; give a parameter file of cflib (YAML)", file=file, key="params"
            )
    return states
