"""The JSON Schema (2020-12) of gains.json, made from the registries: laws, frames, numbers of an airframe, units.

Nothing but x-* at the top is open, so that a misspelt key is an error. The gains that a law needs are chosen by
controller.position and controller.attitude. It is made once a process; `tuner schema gains` prints it for other programs.

vehicle     parameter file that gains were imported from: what it says of the loops, and what of that our loops cannot carry
study       name, title, seed, digest, point: where the gains come from; feasible: false where they break limits of that study
states      steady states besides hover that margins were judged in: heading, velocity over ground and wind in the world frame
objectives  what held-out flights say, row by row, all values of a row in its unit; interval: of low and high; state: steady
            state in which a margin of the tuned gains is worst
design      of `tuner design`: which axes were designed, and why not
margins     loop by loop at hover, of the loop broken where `break_at` says; what no crossing limits is left out
controller  code: file and digest of a law of the user's own, by loop
cost        instructions of one step of the controller, and bytes of code, on a target
exports     files that the gains were written to, and what the target adds or lacks (lossy)

Of the gains of a plant only its loops are read, see `LoopsTable`.
"""

import json
from functools import cache
from typing import Annotated, Any

from pydantic import Field

from objectives.margins.quantities import QUANTITIES, RECORDED
from plant.law_registry import LAWS
from plant.laws.law import GainInfo, Law
from plant.laws.slower import MAX_PERIODS
from plant.quadrotor.cascade import ATTITUDE_AXES, AXES, POSITION_AXES
from plant.quadrotor.nominal import BATTERY_RANGES, MAX_CUTOFF, MIN_CUTOFF, NOTCH_RANGES, ControlOptions
from tuner.gains.airframe_block import AIRFRAME
from tuner.gains.channels import ChannelTable
from tuner.gains.quantities import UCUM, ucum
from tuner.gains.ranges import LONGEST, SHORTEST
from tuner.gains.sections import (
    CONVENTIONS,
    DEMAND,
    DESCRIBING,
    DIGEST,
    FORMAT,
    LINEARISED,
    MAX_EXACT_INTEGER,
    PLANT_INPUT,
    STRUCTURE,
    VERSIONS,
    Row,
    closed,
    listed,
    measured,
    texts,
)
from tuner.text.strict_table import StrictTable

ID = "urn:gainproof:gains:1.2"
LOOPS = {"position": POSITION_AXES, "attitude": ATTITUDE_AXES}
# Unit, least and most of options that are numbers.
MEASURES = {
    "tilt_limit": ("rad", 0.05, 1.05),
    "yaw_torque_cutoff": ("Hz", MIN_CUTOFF, MAX_CUTOFF),
    "rpm_notch_q": ("1", *NOTCH_RANGES["rpm_notch_q"]),
    "rpm_notch_min": ("Hz", *NOTCH_RANGES["rpm_notch_min"]),
    "battery_compensation": ("1", *BATTERY_RANGES["battery_compensation"]),
    "battery_cutoff": ("Hz", *BATTERY_RANGES["battery_cutoff"]),
}
# Steady states that loops are judged in; a study has a handful.
MAX_STATES = 64
NUMBER_OR_NULL = {"type": ["number", "null"]}
TARGET_TEXT = {"type": "string", "pattern": "^[A-Za-z0-9 ._-]{1,128}(?!\n)$"}
PARAMETER_NAME = {"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_.]{0,31}(?!\n)$"}
SEED = {"type": ["integer", "string"], "minimum": 0, "maximum": MAX_EXACT_INTEGER, "pattern": "^[0-9]{16,19}(?!\n)$"}
# A metric of the user's own may have a unit that the table lacks; it is then an annotation.
ANY_UNIT = {"anyOf": [{"enum": sorted(set(UCUM.values()))}, {"type": "string", "pattern": r"^\{[^{}]+\}$"}]}
VELOCITY = {**listed(measured("m/s")), "minItems": 3, "maxItems": 3}
MARGINS = {name: measured(ucum(QUANTITIES[name].unit), minimum=0) for name in RECORDED}

VEHICLE = closed(
    {
        **dict.fromkeys(("target", "target_version", "file"), TARGET_TEXT),
        "sha256": DIGEST,
        "settings": listed(closed(texts("name", "value"))),
        "parameters": listed(closed({"name": PARAMETER_NAME, "value": {"type": "number"}})),
        "kept": listed(PARAMETER_NAME),
    }
)
ORIGIN = {**texts("name", "title", "digest", "point"), "seed": SEED, "feasible": {"const": False}}
STATE = closed({**texts("name"), "yaw": measured("rad"), "velocity": VELOCITY, "wind": VELOCITY})
INTERVAL = closed(
    {
        "level": {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1},
        # A bootstrap has at least two flights to draw from.
        "n": {"type": "integer", "minimum": 2},
        **texts("method"),
    }
)
OBJECTIVE = closed(
    {
        **texts("label"),
        "unit": ANY_UNIT,
        "kind": {"enum": ["objective", "constraint", "requirement"]},
        "limit": NUMBER_OR_NULL,
        **dict.fromkeys(
            ("default", "tuned", "difference"), closed(dict.fromkeys(("value", "low", "high"), NUMBER_OR_NULL))
        ),
        **texts("verdict"),
        "interval": INTERVAL,
        **texts("state"),
    },
    optional=("interval", "state"),
)
DESIGN = closed(
    {
        "axis": {"enum": list(AXES)},
        "designed": {"type": "boolean"},
        **texts("why"),
        "load_rejection": {**measured("s-3"), "type": ["object", "null"]},
    }
)
MARGIN = closed(
    {
        "loop": {"enum": list(AXES)},
        "break_at": {"enum": [PLANT_INPUT, DEMAND]},
        "method": {"enum": [LINEARISED, DESCRIBING]},
        **texts("amplitude"),
        "stable": {"type": "boolean"},
        **MARGINS,
    },
    optional=("amplitude", *MARGINS),
)
COST = closed(
    {**texts("target", "tool"), "instructions": measured("1", minimum=0), "bytes": measured("By", minimum=0)},
    optional=("instructions", "bytes"),
)
EXPORT = closed({**texts("target", "target_version", "file"), "sha256": DIGEST, "lossy": listed({"type": "string"})})
# Sections that a document may lack.
SECTIONS: Row = {
    "vehicle": VEHICLE,
    "study": closed(ORIGIN, optional=ORIGIN),
    "states": {**listed(STATE), "maxItems": MAX_STATES},
    "objectives": listed(OBJECTIVE),
    "design": listed(DESIGN),
    "margins": listed(MARGIN),
    "cost": listed(COST),
    "exports": listed(EXPORT),
    "sha256": DIGEST,
}


def gains_schema() -> Row:
    """Return the JSON-able schema, with the laws registered so far.

    The user's laws are among them.
    """
    return _schema_of(tuple(LAWS.values()))


@cache
def _schema_of(_: tuple[Law, ...]) -> Row:
    top = closed(
        {
            "format": {"const": FORMAT},
            "version": {"enum": list(VERSIONS)},
            "generator": closed(texts("name", "version")),
            "conventions": closed({key: {"const": value} for key, value in CONVENTIONS.items()}),
            "airframe": AIRFRAME,
            "controller": controller_schema(),
            "gains": {"type": "object"},
            **SECTIONS,
        },
        optional=SECTIONS,
    )
    choices, definitions = gains_by_law()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": ID,
        "title": "gains.json of gainproof: a quadrotor controller with every number's unit (UCUM)",
        "description": "sha256: SHA-256 over the RFC 8785 canonical form of everything but sha256, exports and cost.",
        **top,
        "patternProperties": {"^x-": {}},
        "allOf": choices,
        "$defs": definitions,
    }


def gains_by_law() -> tuple[list[Row], Row]:
    """Return the choice of gains by each loop's law, and its definitions.

    Laws with the same gains share a definition.
    """
    choices, definitions = [], {}
    for loop in LOOPS:
        sharing: dict[str, list[str]] = {}
        for law in LAWS.values():
            gains = {gain.name: gain_schema(gain, loop) for gain in law.gains}
            sharing.setdefault(json.dumps(gains), []).append(law.name)
        for laws in sharing.values():
            name = f"{laws[0]}.{loop}"
            controller = {"type": "object", "properties": {loop: {"enum": laws}}, "required": [loop]}
            chosen = {"properties": {"controller": controller}, "required": ["controller"]}
            choices.append({"if": chosen, "then": {"properties": {"gains": {"$ref": f"#/$defs/{name}"}}}})
            definitions[name] = gains_of(LAWS[laws[0]], loop)
            definitions |= {f"{name}.{_written(gain)}": gain_schema(gain, loop) for gain in LAWS[laws[0]].gains}
    return choices, definitions


def gains_of(law: Law, loop: str) -> Row:
    """Return the schema of the gains of one loop; those of the other loop are left to its own."""
    axes, others = LOOPS[loop], LOOPS["attitude" if loop == "position" else "position"]
    properties = {
        f"{axis}.{_written(gain)}": {"$ref": f"#/$defs/{law.name}.{loop}.{_written(gain)}"}
        for axis in axes
        for gain in law.gains
    }
    return {**closed(properties), "patternProperties": {f"^({'|'.join(others)})\\.": {}}}


def _written(gain: GainInfo) -> str:
    return gain.name.rstrip("_")


def gain_schema(gain: GainInfo, loop: str) -> Row:
    """Return the schema of one gain: value, unit and, where a search had one, its range."""
    bound = "exclusiveMinimum" if gain.exclusive else "minimum"
    ends = dict.fromkeys(("low", "high"), {"type": "number"})
    properties = {**measured(ucum(gain.unit_in(loop)), **{bound: gain.least})["properties"], **ends}
    return {"description": gain.meaning, **closed(properties, optional=ends)}


def schema_text() -> str:
    """Return the schema as the text of a file."""
    return json.dumps(gains_schema(), indent=1, ensure_ascii=False) + "\n"


def validator() -> Any:
    """Return a validator of the schema, of the package jsonschema."""
    return _validator_of(tuple(LAWS.values()))


@cache
def _validator_of(_: tuple[Law, ...]) -> Any:
    from jsonschema import Draft202012Validator

    return Draft202012Validator(gains_schema())


def controller_schema() -> Row:
    """Return the schema of "controller"."""
    laws, period = {"enum": list(LAWS)}, measured("s", minimum=SHORTEST, maximum=LONGEST)
    measures = {name: measured(unit, minimum=low, maximum=high) for name, (unit, low, high) in MEASURES.items()}
    options = {
        "tilt_limit": measures.pop("tilt_limit"),
        "yaw_torque_cutoff": measures.pop("yaw_torque_cutoff"),
        "rpm_notches": {"type": "integer", "minimum": 1, "maximum": NOTCH_RANGES["rpm_notches"][1]},
        **measures,
        **dict.fromkeys(("attitude_rate", "position_rate"), {"enum": ["measured", "observer"]}),
        **dict.fromkeys(("lag_aware", "delay"), {"type": "boolean"}),
    }
    assert set(options) == set(ControlOptions.__dataclass_fields__), "every option is in the file"
    return closed(
        {
            **dict.fromkeys(LOOPS, laws),
            **dict.fromkeys(("control_period", "plant_step"), period),
            **options,
            "position_every": {"type": "integer", "minimum": 2, "maximum": MAX_PERIODS},
            "structure": closed({key: {"const": text} for key, text in STRUCTURE.items()}),
            "discretisation": closed(texts(*LOOPS)),
            "code": closed(dict.fromkeys(LOOPS, closed(texts("file", "digest"))), optional=LOOPS),
        },
        optional=["yaw_torque_cutoff", *NOTCH_RANGES, *BATTERY_RANGES, "position_every", "code"],
    )


class NumberTable(StrictTable):
    """A number with its unit."""

    value: float
    """The number."""
    unit: str
    """UCUM code of its unit, or the unit in braces."""


class LoopsTable(StrictTable):
    """Loops of a plant in a gains.json."""

    version: int
    """Version of the format."""
    control_period: NumberTable
    """Period of the controller."""
    channels: Annotated[list[ChannelTable], Field(min_length=1)]
    """Loops, in the keys of a study."""
    gains: dict[str, NumberTable]
    """Gains by address."""
    observer: str = ""
    """Observer of the study, by its keys; by default none."""
