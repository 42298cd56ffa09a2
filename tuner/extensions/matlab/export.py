"""MATLAB and Octave: a function that returns a struct with every gain of any law, its unit, the airframe and the limits.

The file is text that one can compare and read: 17 significant digits give every double back as it was. A gains.json can also
be read directly, `jsondecode(fileread('gains.json'))`, whose keys then read `roll_kp`; Octave 7 then has some numbers off by an
ulp, this file has none.
"""

import re
from typing import Any

from plant.errors import one_line
from plant.quadrotor.airframes.schema import GROUPS, OPTIONAL, SCALARS
from plant.quadrotor.cascade import MIN_COSINE, MIN_LIFT
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.nominal import nominal
from tuner.exchange.aboard import rollback_request
from tuner.exchange.target import Bundle, ExportTarget, Request
from tuner.exchange.texts import heading, matlab_string

FUNCTION = "gainproof_gains"
FILE = f"{FUNCTION}.m"
VERSION = "MATLAB R2016b and later, GNU Octave 6 and later"

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}\Z")
KEYWORDS = frozenset(
    "break case catch classdef continue else elseif end endfunction endif endfor endwhile for function global if otherwise "
    "parfor persistent return spmd switch try until do unwind_protect while".split()
)

# Units of where the rotors stand and which way they turn.
DERIVED = {"rotor_x": "m", "rotor_y": "m", "spin": "1", "dead_time_deviation": "s"}
# A number or a column of numbers with its unit; texts and flags have none.
Entry = tuple[Any, str]


def export(request: Request) -> Bundle:
    """Write the function; every law can be carried, see `ExportTarget.export`."""
    earlier, sentence = rollback_request(request)
    return Bundle(
        files={FILE: function(request)},
        rollback={FILE: function(earlier, sentence)},
        held=request.controller,
        differences=(
            "The file carries numbers only; the law that uses them is to be written or generated in MATLAB (the export 'fmi' "
            "carries it to Simulink).",
            "For laws of the PID family, MATLAB's pid object takes kp, ki, kd, Tf as they are, but differentiates the error; "
            "ours differentiates the measurement (pid2 with c = 0 does).",
        ),
        target_version=VERSION,
    )


def entries(request: Request) -> dict[str, Entry]:
    """Return the struct's entries (value, unit) by dotted name, in file order."""
    controller = request.controller
    vehicle, options = controller.airframe.vehicle, controller.options
    knows = nominal(vehicle, options, controller.control_period)
    table: dict[str, Entry] = {
        "source.tool": ("gainproof", ""),
        "source.digest": (request.digest, ""),
        "laws.position": (controller.cascade.position.name, ""),
        "laws.attitude": (controller.cascade.attitude.name, ""),
        "laws.attitude_rate": (options.attitude_rate, ""),
        "laws.position_rate": (options.position_rate, ""),
        "laws.lag_aware": (options.lag_aware, ""),
        "laws.delay": (options.delay, ""),
        "sample_time": (controller.control_period, "s"),
        "position_every": (controller.cascade.position_every, "1"),
        "limits.tilt": (options.tilt_limit, "rad"),
        "filters.yaw_torque_cutoff": (options.yaw_torque_cutoff, "Hz"),
        "limits.rotor_thrust_min": (knows.thrust_min, "N"),
        "limits.rotor_thrust_max": (knows.thrust_max, "N"),
        "limits.least_lift": (MIN_LIFT, "1"),
        "limits.least_cosine": (MIN_COSINE, "1"),
        "airframe.name": (controller.airframe.name, ""),
    }
    units = {name: field.unit for name, field in (SCALARS | OPTIONAL | GROUPS).items()} | DERIVED
    table |= {f"airframe.{name}": (value, units[name]) for name, value in vehicle._asdict().items()}
    gains = gain_addresses(controller.cascade)
    return table | {f"gains.{gain.address}": (controller.gains[gain.column], gain.unit) for gain in gains}


def literal(value: Any) -> str:
    """Return a value as MATLAB writes it: texts, flags, numbers, and columns of numbers (n, 1)."""
    if isinstance(value, str):
        return matlab_string(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, tuple):
        return "[" + "; ".join(f"{part:.17g}" for part in value) + "]"
    return f"{value:.17g}"


def function(request: Request, sentence: str = "") -> bytes:
    """Return the text of the function."""
    table = entries(request)
    lines = [f"function c = {FUNCTION}()", f"%{FUNCTION.upper()} Gains of a quadrotor controller as a struct."]
    lines += [f"%   {line}." for line in heading(request, one_line)]
    lines += [f"%   {one_line(sentence)}"] if sentence else []
    lines += [
        "%   World ENU, body FLU; SI units and radians. Gains are per inertia: torque = inertia * (kp * error + ...).",
        "%   c.gains.<axis>.<gain>; c.units has the same fields with the unit of each number. Vectors are columns:",
        "%   inertia and drag x, y, z; rotors 1 front left, 2 front right, 3 rear left, 4 rear right. The thrust of a rotor",
        "%   is thrust_coefficient * speed^2. limits.least_lift: share of gravity that the vertical demand keeps;",
        "%   limits.least_cosine: least cosine of the tilt by which thrust is divided.",
    ]
    lines += [f"{path(name)} = {literal(value)};{comment(unit)}" for name, (value, unit) in table.items()]
    lines += [f"{path(name, 'c.units')} = {literal(unit)};" for name, (_, unit) in table.items() if unit]
    return ("\n".join([*lines, "end"]) + "\n").encode()


def path(name: str, root: str = "c") -> str:
    """Return the place of a dotted name in the struct; each part must be a name that MATLAB takes."""
    for part in name.split("."):
        assert NAME.match(part) and part not in KEYWORDS, f"MATLAB takes no field '{part}'"
    return f"{root}.{name}"


def comment(unit: str) -> str:
    """Return the unit as a comment at the end of a line."""
    return f"  % {unit}" if unit else ""


TARGET = ExportTarget(name="matlab", title="MATLAB and Octave, a struct of gains with units", export=export)
