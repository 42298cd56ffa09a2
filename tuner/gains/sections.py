"""The parts of gains.json beside airframe and gains: what they are called, and their JSON Schema.

vehicle     parameter file that gains were imported from: what it says of the loops, and what of that our loops cannot carry
study       name, title, seed, digest, point: where the gains come from; feasible: false where they break limits of that study
objectives  what held-out flights say, row by row, all values of a row in its unit; interval: of low and high
design      of `tuner design`: which axes were designed, and why not
margins     loop by loop, of the loop broken where `break_at` says; what no crossing limits is left out
cost        instructions of one step of the controller, and bytes of code, on a target
exports     files that the gains were written to, and what the target adds or lacks (lossy)
"""

from collections.abc import Iterable
from typing import Any

from objectives.margins.quantities import QUANTITIES, RECORDED
from plant.cascade import AXES
from plant.nominal import LEAST_CUTOFF, MOST_CUTOFF, ControlOptions
from tuner.gains.ranges import LONGEST, SHORTEST
from tuner.gains.ucum import UCUM, ucum

Row = dict[str, Any]

# maxLength, because $ of some regular expressions lets a line break through.
DIGEST: Row = {"type": "string", "pattern": "^[0-9a-f]{64}$", "maxLength": 64}


def closed(properties: Row, optional: Iterable[str] = ()) -> Row:
    """Return the schema of an object with these keys and no others."""
    left_out = set(optional)
    return {
        "type": "object",
        "properties": properties,
        "required": [key for key in properties if key not in left_out],
        "additionalProperties": False,
    }


def measured(unit: str, **bounds: float) -> Row:
    """Return the schema of {value, unit} in one unit (UCUM)."""
    return closed({"value": {"type": "number", **bounds}, "unit": {"const": unit}})


def listed(items: Row) -> Row:
    """Return the schema of a list."""
    return {"type": "array", "items": items}


def texts(*names: str) -> Row:
    """Return the schemas of keys that hold any text."""
    return {name: {"type": "string"} for name in names}


FORMAT, VERSION = "holdfast-gains", "1.1"
# 1.1 adds "vehicle".
VERSIONS = ("1.0", VERSION)
CONVENTIONS = {
    "world_frame": "ENU",
    "body_frame": "FLU",
    "angle": "rad",
    "quaternion": "wxyz",
    "rotation": "body_to_world",
    "gains": "acceleration of the channel, torque over inertia, force over mass",
    "units": "UCUM",
}
STRUCTURE = {
    "kind": "cascade",
    "position": "x, y, z: position to acceleration, limited to the tilt cone, turned into roll, pitch and thrust at the heading",
    "attitude": "roll, pitch, yaw: angle to torque, allocated to the rotors with the thrust",
    "channel": "y'' = f + b0 u",
}
RATES = ["measured", "observer"]
KINDS = ["objective", "constraint", "requirement"]
LINEARISED, DESCRIBING = "linearised", "describing function"
PLANT_INPUT, DEMAND = "plant input", "demand of the position loop"
# Whole numbers that every reader of JSON holds exactly; a larger seed is written as text.
MOST_EXACT = 2**53 - 1


def controller_schema(laws: list[str]) -> Row:
    """Return the schema of "controller"."""
    period = measured("s", minimum=SHORTEST, maximum=LONGEST)
    options = {
        "attitude_rate": {"enum": RATES},
        "position_rate": {"enum": RATES},
        "lag_aware": {"type": "boolean"},
        "delay": {"type": "boolean"},
    }
    measures = {
        "tilt_limit": measured("rad", minimum=0.05, maximum=1.05),
        "yaw_torque_cutoff": measured("Hz", minimum=LEAST_CUTOFF, maximum=MOST_CUTOFF),
    }
    assert {*options, *measures} == set(ControlOptions.__dataclass_fields__), "every option is in the file"
    return closed(
        {
            "position": {"enum": laws},
            "attitude": {"enum": laws},
            "control_period": period,
            "plant_step": period,
            **measures,
            **options,
            "structure": closed({key: {"const": text} for key, text in STRUCTURE.items()}),
            "discretisation": closed(texts("position", "attitude")),
        },
        optional=["yaw_torque_cutoff"],
    )


def vehicle_schema() -> Row:
    """Return the schema of "vehicle"."""
    plain = {"type": "string", "pattern": "^[A-Za-z0-9 ._-]{1,128}(?!\n)$"}
    name = {"type": "string", "pattern": "^[A-Za-z][A-Za-z0-9_]{0,31}(?!\n)$"}
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
            "unit": {"enum": sorted(set(UCUM.values()))},
            "kind": {"enum": KINDS},
            "limit": number,
            **dict.fromkeys(("default", "tuned", "difference"), estimate),
            "verdict": {"type": "string"},
            "interval": interval,
        },
        optional=("interval",),
    )


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
