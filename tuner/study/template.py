"""The study file that `tuner new NAME` writes: every table, the usual values, a comment on each line."""

import os
import re
from pathlib import Path
from typing import Any

from plant.errors import InputError, StoreError
from plant.input_files import read_input_text
from plant.output_files import make_folders, write_new_file
from plant.own_code import refuse_unnamed
from plant.texts import toml_table
from tuner.study.files import SHIPPED, check_file_name, study_file
from tuner.study.reading import parse_toml
from tuner.text.toml_text import with_paths

TEMPLATE = """# A tuning study. Check it with `tuner check FILE`, run it with `tuner run FILE`.
# Everything that is commented out stands at its default; remove the # to change it.
title = "@TITLE@"
seed = 2025                     # every random number follows from this one

[airframe]
name = "hummingbird"            # bundled: `tuner list airframes`
# file = "my_quad.toml"         # or your own, instead of name

[controller]
attitude = "hybrid"             # law of roll, pitch, yaw: `tuner list laws`
position = "ladrc"              # law of x, y, z
# control_period = 0.004        # s
# plant_step = 0.001            # s, Runge-Kutta step of the plant; else as long as the rotors' lag allows
# position_every = 1            # periods between two steps of the position law
# attitude_rate = "measured"    # "observer": the law takes the rate from its own observer
# position_rate = "measured"
# lag_aware = true              # observers are fed with the modelled actuator output
# delay = false                 # true: the command acts one period after its measurement
# tilt_limit_deg = 30
# rpm_notches = 0               # harmonics of the rotors' measured speed that notches take out of the gyro, up to 3
# battery_compensation = 0      # share of the sag of the airframe's battery that commands are raised by, up to 1
# yaw_torque_cutoff = 0         # Hz, low-pass on the yaw torque; 0: none, `tuner check` says where heavy rotors want one

# [limits]                      # a flight that leaves these has failed
# position = 5.0                # m
# tilt_deg = 80

# AXIS.GAIN or GROUP.GAIN; groups: attitude, tilt (roll, pitch), position, horizontal (x, y).
[gains]
"tilt.omega_o" = {}                                  # searched in its usual range
"tilt.lambda" = { low = 1.0, high = 15.0 }           # searched in this range
"tilt.k1" = { low = 0.0, high = 30.0, scale = "linear" }
"tilt.k2" = {}
"yaw.lambda" = { tie = "tilt.lambda" }               # always the same as that one
"yaw.k1" = 5.0                                       # fixed
"position.omega_c" = {}
"position.omega_o" = {}

[[scenario]]
name = "gusts"
duration = 10.0                 # s
search = 16                     # flights while searching: of every candidate the first few, of what survives them all
# held_out = 1024               # flights that only the final check sees

[scenario.reference]
kind = "steps"                  # hover, level, steps, ramp, figure_eight, helix, waypoints: `tuner list references`
x = 1.0                         # m
time = 1.0                      # s

[scenario.air]
intensity = "light"             # none, light, moderate, severe, or the wind at 20 ft in m/s
altitude = 10.0                 # m above ground
mean_wind = true                # flights start trimmed against the mean wind; false: its turbulence alone
# window = [1.0, 6.0]           # s, turbulence only then

# [scenario.air.gust]           # one 1-cos pulse of wind
# amplitude = 5.0               # m/s
# start = 4.0                   # s
# length = 2.0                  # s

# [scenario.sensors]            # RMS noise: position 0.002 m, velocity 0.01 m/s, attitude 0.002 rad, rate 0.01 rad/s
# rate = 0.02

[scenario.spread]               # uniform, as a share of the nominal value
mass = 0.05
inertia = 0.10
lag = 0.20                      # of the rotors, whose nominal lag the observers are made for; 0.2 unless given

[[objective]]
metric = "itae.position"        # `tuner list metrics`
risk = "cvar"                   # mean, quantile, cvar, worst: `tuner list risks`
level = 0.9

[[objective]]
metric = "travel"               # how much the rotor commands move

[[constraint]]
metric = "failure"
max = 0.0

# [mission]                     # automatic limits: what the median flight of every scenario must do; `tuner check` shows them
# followed = 0.7                # where the reference moves: RMS error at most this share of a flight that never leaves its start
# held = 0.5                    # where it rests: RMS error at most this share of limits.position
# off = ["rms.position"]        # quantities without one: rms.position, rms.tilt, rms.yaw, rms.z, or rms.position@SCENARIO

[[margin]]                      # known without flying: what breaks it is not flown; `tuner list margins`
quantity = "phase_margin"       # of every loop as it is flown, lag and sampling included
min = 35                        # deg
# axis = "attitude"             # an axis or group; without it the worst of all six counts
# spread = true                 # in the worst corner of [scenario.spread] too
# hard = false                  # fly it all the same and count it as a broken constraint

[[margin]]
quantity = "ms"                 # peak of the sensitivity
max = 2

# [[guarantee]]                 # known without flying: what breaks it is not flown; `tuner list theorems`
# theorem = "ultimate_error"
# axis = "tilt"
# max = 0.2                     # rad

[search]                        # `tuner list searches`; "auto" chooses by the numbers of gains, objectives and candidates
# algorithm = "auto"
# population = 8                # candidates of a generation; these are the sizes of a search by a model
# generations = 17
# first = 8                     # flights of each scenario that every candidate makes; what survives them makes the others

[pick]
rule = "knee"                   # knee, closest, min:METRIC, or weights with weights = { "itae.position" = 2, travel = 1 }
"""


def write_study(name: str, source: Path | None = None) -> list[Path]:
    """Write the commented template, or a copy of the study `source`, and return what was written: NAME.toml in this folder first.

    Code beside a shipped study is copied along, to be changed. Raises StoreError where a file of such a name is there already,
    and UnnamedCodeError where a study from elsewhere names code that the user has not named: the copy would run it.
    """
    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    check_file_name(path)
    title = "".join(letter for letter in path.stem.replace("_", " ") if letter not in '"\\')
    if source is None:
        files = {path: TEMPLATE.replace("@TITLE@", title)}
    else:
        origin = study_file(source)
        code = {path.parent / name: read_input_text(origin.parent / name) for name in _shipped_code(origin)}
        if not code and origin.parent.resolve() != path.parent.resolve():
            for name in _code_of(origin):
                refuse_unnamed(origin.parent / name)
        files = {path: copied_study(origin, path), **code}
    # Code that lies there already, as it is, serves another study too.
    new = {file: content for file, content in files.items() if file == path or not _holds(file, content)}
    for taken in filter(Path.exists, new):
        raise StoreError(f"{taken} exists already and was not touched; choose another name, or another folder")
    for file, content in new.items():
        _write_new(file, content)
    return list(new)


def _holds(file: Path, text: str) -> bool:
    return file.is_file() and read_input_text(file) == text


def _write_new(path: Path, text: str) -> None:
    try:
        make_folders(path.parent)
        write_new_file(path, text.encode())
    except FileExistsError:
        raise StoreError(f"{path} exists already and was not touched; choose another name") from None
    except OSError as error:
        raise StoreError(f"{path} cannot be written ({error.strerror})") from None


def _shipped_code(study: Path) -> list[str]:
    """Return the files of code that a shipped study names, relative to it; none of a study of the user's own."""
    return [name for name in _code_of(study) if name.endswith(".py")] if study.parent.resolve() == SHIPPED else []


def _code_of(study: Path) -> list[str]:
    """Return the files of code that a study names, FMUs included, relative to it."""
    named: list[str] = []

    def note(name: str) -> str:
        named.append(name)
        return name

    with_paths(parse_toml(study), note)
    return [name for name in named if name.endswith((".py", ".fmu"))]


def copied_study(source: Path, target: Path) -> str:
    """Return the text of a study, comments included, as it stands at another path: its paths and its comments follow.

    Raises InputError where the source cannot be read, or spells a path so that it cannot be replaced in the text.
    """
    table = parse_toml(source)
    text = read_input_text(source, "utf-8-sig")
    moves: dict[str, str] = {}
    wanted = _moved(table, source.parent, target.parent, moves)
    for old, new in moves.items():
        text = text.replace(f'"{old}"', f'"{new}"')
    name = re.escape(source.stem)
    for pattern, word in (
        (rf"(studies/)?\b{name}\.toml", target.name),
        (rf"\bresults/{name}\b", f"results/{target.stem}"),
    ):
        text = re.sub(rf"(?m)^(#.*?){pattern}", lambda found, word=word: f"{found[1]}{word}", text)
    if toml_table(text, source) != wanted:
        raise InputError(
            f"its paths cannot be changed for {target.parent}; copy the file and change them by hand", file=source
        )
    return text


def _moved(table: dict[str, Any], home: Path, away: Path, moves: dict[str, str]) -> dict[str, Any]:
    """Return the content of a study with its paths from another folder; moves: filled with what each became."""
    shipped = home.resolve() == SHIPPED

    def move(name: str) -> str:
        stays = home.resolve() == away.resolve() or (shipped and name.endswith(".py"))
        moves[name] = name if stays else Path(os.path.relpath(home / name, away)).as_posix()
        return moves[name]

    moved = with_paths(table, move)
    # The base of a shipped study is found by its name from everywhere.
    base = moved.get("base")
    return {**moved, "base": move(base)} if isinstance(base, str) and not shipped else moved
