"""The JSON Schema (2020-12) of gains.json, made from the registries: laws, frames, numbers of an airframe, units.

Nothing but x-* at the top is open, so that a misspelt key is an error. The gains that a law needs are chosen by
controller.position and controller.attitude. It is made once a process; `tuner schema gains` prints it for other programs.

vehicle     parameter file that gains were imported from: what it says of the loops, and what of that our loops cannot carry
study       name, title, seed, digest, point: where the gains come from; feasible: false where they break limits of that study
states      steady states beside hover that margins were judged in: heading, velocity over ground and wind in the world frame
objectives  what held-out flights say, row by row, all values of a row in its unit; interval: of low and high; state: steady
            state in which a margin of the tuned gains is worst
design      of `tuner design`: which axes were designed, and why not
margins     loop by loop at hover, of the loop broken where `break_at` says; what no crossing limits is left out
controller  code: file and digest of a law of the user's own, by loop
cost        instructions of one step of the controller, and bytes of code, on a target
exports     files that the gains were written to, and what the target adds or lacks (lossy)
"""

import json
from functools import cache
from typing import Any

from objectives.margins.quantities import QUANTITIES, RECORDED
from plant.cascade import ATTITUDE_AXES, AXES, POSITION_AXES
from plant.laws import LAWS
from plant.laws.law import GainInfo, Law
from plant.laws.slower import MOST_PERIODS
from plant.nominal import BATTERY_RANGES, LEAST_CUTOFF, MOST_CUTOFF, NOTCH_RANGES, ControlOptions
from tuner.gains.airframe_block import airframe_schema
from tuner.gains.quantities import UCUM, ucum
from tuner.gains.ranges import LONGEST, SHORTEST
from tuner.gains.sections import (
    CONVENTIONS,
    DEMAND,
    DESCRIBING,
    DIGEST,
    FORMAT,
    LINEARISED,
    MOST_EXACT,
    PLANT_INPUT,
    STRUCTURE,
    VERSIONS,
    Row,
    closed,
    listed,
    measured,
    texts,
)

ID = "urn:holdfast:gains:1.2"
LOOPS = {"position": POSITION_AXES, "attitude": ATTITUDE_AXES}
# Steady states that loops are judged in; a study has a handful.
MOST_STATES = 64
# Keys that a document may lack.
OPTIONAL = ("vehicle", "study", "states", "objectives", "design", "margins", "cost", "exports", "sha256")


def gains_schema() -> Row:
    """Return the schema as JSON-able data, with the laws of the user's own that are known by now."""
    return _schema_of(tuple(LAWS.values()))


@cache
def _schema_of(_: tuple[Law, ...]) -> Row:
    top = closed(
        {
            "format": {"const": FORMAT},
            "version": {"enum": list(VERSIONS)},
            "generator": closed(texts("name", "version")),
            "conventions": closed({key: {"const": value} for key, value in CONVENTIONS.items()}),
            "airframe": airframe_schema(),
            "controller": controller_schema(list(LAWS)),
            "gains": {"type": "object"},
            "vehicle": vehicle_schema(),
            "study": study_schema(),
            "states": {**listed(state_schema()), "maxItems": MOST_STATES},
            "objectives": listed(objectives_schema()),
            "design": listed(design_schema()),
            "margins": listed(margins_schema()),
            "cost": listed(cost_schema()),
            "exports": listed(exports_schema()),
            "sha256": DIGEST,
        },
        optional=OPTIONAL,
    )
    choices, definitions = gains_by_law()
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": ID,
        "title": "gains.json of holdfast: a quadrotor controller with every number's unit (UCUM)",
        "description": "sha256: SHA-256 over the RFC 8785 canonical form of everything but sha256, exports and cost.",
        **top,
        "patternProperties": {"^x-": {}},
        "allOf": choices,
        "$defs": definitions,
    }


def gains_by_law() -> tuple[list[Row], Row]:
    """Return the choice of the gains by the law of each loop, and what it refers to; laws with the same gains share."""
    choices, definitions = [], {}
    for loop in LOOPS:
        sharing: dict[str, list[str]] = {}
        for law in LAWS.values():
            gains = {gain.name: gain_schema(gain, loop) for gain in law.gains}
            sharing.setdefault(json.dumps(gains), []).append(law.name)
        for laws in sharing.values():
            name = f"{laws[0]}.{loop}"
            choices.append(chosen(loop, laws, name))
            definitions[name] = gains_of(LAWS[laws[0]], loop)
            definitions |= {f"{name}.{_written(gain)}": gain_schema(gain, loop) for gain in LAWS[laws[0]].gains}
    return choices, definitions


def chosen(loop: str, laws: list[str], name: str) -> Row:
    """Return: where a loop has one of the laws, the gains are those of the definition of that name."""
    controller = {"type": "object", "properties": {loop: {"enum": laws}}, "required": [loop]}
    return {
        "if": {"properties": {"controller": controller}, "required": ["controller"]},
        "then": {"properties": {"gains": {"$ref": f"#/$defs/{name}"}}},
    }


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
    value = {"type": "number", bound: gain.least}
    unit = {"const": ucum(gain.unit_in(loop))}
    ends = {"type": "number"}
    return {
        "description": gain.meaning,
        **closed({"value": value, "unit": unit, "low": ends, "high": ends}, optional=("low", "high")),
    }


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


def controller_schema(laws: list[str]) -> Row:
    """Return the schema of "controller"."""
    period = measured("s", minimum=SHORTEST, maximum=LONGEST)
    options = {
        **dict.fromkeys(("attitude_rate", "position_rate"), {"enum": ["measured", "observer"]}),
        "lag_aware": {"type": "boolean"},
        "delay": {"type": "boolean"},
    }
    measures = {
        "tilt_limit": measured("rad", minimum=0.05, maximum=1.05),
        "yaw_torque_cutoff": measured("Hz", minimum=LEAST_CUTOFF, maximum=MOST_CUTOFF),
    }
    harmonics, quality, least = NOTCH_RANGES.values()
    share, cutoff = BATTERY_RANGES.values()
    present = {
        "rpm_notches": {"type": "integer", "minimum": 1, "maximum": harmonics[1]},
        "rpm_notch_q": measured("1", minimum=quality[0], maximum=quality[1]),
        "rpm_notch_min": measured("Hz", minimum=least[0], maximum=least[1]),
        "battery_compensation": measured("1", minimum=share[0], maximum=share[1]),
        "battery_cutoff": measured("Hz", minimum=cutoff[0], maximum=cutoff[1]),
    }
    assert {*options, *measures, *present} == set(ControlOptions.__dataclass_fields__), "every option is in the file"
    return closed(
        {
            "position": {"enum": laws},
            "attitude": {"enum": laws},
            "control_period": period,
            "plant_step": period,
            **measures,
            **present,
            **options,
            "position_every": {"type": "integer", "minimum": 2, "maximum": MOST_PERIODS},
            "structure": closed({key: {"const": text} for key, text in STRUCTURE.items()}),
            "discretisation": closed(texts("position", "attitude")),
            "code": closed(dict.fromkeys(LOOPS, closed(texts("file", "digest"))), optional=LOOPS),
        },
        optional=["yaw_torque_cutoff", *present, "position_every", "code"],
    )


def vehicle_schema() -> Row:
    """Return the schema of "vehicle"."""
    plain = {"type": "string", "pattern": "^[A-Za-z0-9 ._-]{1,128}(?!\n)$"}
    name = {"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_.]{0,31}(?!\n)$"}
    return closed(
        {
            **dict.fromkeys(("target", "target_version", "file"), plain),
            "sha256": DIGEST,
            "settings": listed(closed(texts("name", "value"))),
            "parameters": listed(closed({"name": name, "value": {"type": "number"}})),
            "kept": listed(name),
        }
    )


def study_schema() -> Row:
    """Return the schema of "study"."""
    seed = {"type": ["integer", "string"], "minimum": 0, "maximum": MOST_EXACT, "pattern": "^[0-9]{16,19}(?!\n)$"}
    properties = {**texts("name", "title", "digest", "point"), "seed": seed, "feasible": {"const": False}}
    return closed(properties, optional=properties)


def objectives_schema() -> Row:
    """Return the schema of one row of "objectives"."""
    number = {"type": ["number", "null"]}
    estimate = closed({"value": number, "low": number, "high": number})
    # A bootstrap has at least two flights to draw from.
    interval = closed(
        {
            "level": {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1},
            "n": {"type": "integer", "minimum": 2},
            "method": {"type": "string"},
        }
    )
    return closed(
        {
            "label": {"type": "string"},
            # A metric of the user's own may have a unit that the table lacks; it is then an annotation.
            "unit": {"anyOf": [{"enum": sorted(set(UCUM.values()))}, {"type": "string", "pattern": r"^\{[^{}]+\}$"}]},
            "kind": {"enum": ["objective", "constraint", "requirement"]},
            "limit": number,
            **dict.fromkeys(("default", "tuned", "difference"), estimate),
            "verdict": {"type": "string"},
            "interval": interval,
            "state": {"type": "string"},
        },
        optional=("interval", "state"),
    )


def state_schema() -> Row:
    """Return the schema of one row of "states"."""
    vector = {"type": "array", "items": measured("m/s"), "minItems": 3, "maxItems": 3}
    return closed({**texts("name"), "yaw": measured("rad"), "velocity": vector, "wind": vector})


def design_schema() -> Row:
    """Return the schema of one row of "design"."""
    rejection = {**measured("s-3"), "type": ["object", "null"]}
    axis, designed = {"enum": list(AXES)}, {"type": "boolean"}
    return closed({"axis": axis, "designed": designed, **texts("why"), "load_rejection": rejection})


def margins_schema() -> Row:
    """Return the schema of one row of "margins"."""
    values = {name: measured(ucum(QUANTITIES[name].unit), minimum=0) for name in RECORDED}
    about = {
        "loop": {"enum": list(AXES)},
        "break_at": {"enum": [PLANT_INPUT, DEMAND]},
        "method": {"enum": [LINEARISED, DESCRIBING]},
        "amplitude": {"type": "string"},
        "stable": {"type": "boolean"},
    }
    return closed({**about, **values}, optional=("amplitude", *values))


def cost_schema() -> Row:
    """Return the schema of one row of "cost"."""
    return closed(
        {**texts("target", "tool"), "instructions": measured("1", minimum=0), "bytes": measured("By", minimum=0)},
        optional=("instructions", "bytes"),
    )


def exports_schema() -> Row:
    """Return the schema of one row of "exports"."""
    return closed({**texts("target", "target_version", "file"), "sha256": DIGEST, "lossy": listed({"type": "string"})})
