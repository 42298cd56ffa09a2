"""A profile with `pid_type = ADRC`, and the craft's plants, from files."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from pydantic import Field, ValidationError

from plant.errors import InputError, check_name, shortened
from plant.input_files import ReadableFile, given_text
from plant.texts import check_texts, toml_table
from tuner.extensions.betaflight.commands import read_profile
from tuner.extensions.betaflight.presets import command_lines
from tuner.extensions.betaflight.text import parse_integer, read_selected
from tuner.extensions.betaflight_adrc.linear_loop import AxisPlant, Sampling, scaled
from tuner.extensions.betaflight_adrc.settings import (
    AXES,
    BUILDS,
    DEFAULT_BUILD,
    REVISION,
    SETTINGS,
    Build,
    Tune,
    build_of,
    default_tune,
    read_setting,
    recognize_build,
)
from tuner.text.strict_table import StrictTable

THRUST_LINEAR = ((0, 1.0), (10, 1.03), (25, 1.09), (60, 1.36), (80, 1.63), (90, 1.81), (95, 1.91), (100, 2.02))
"""thrust_linear [%] and the slope of its curve at hover, by which it multiplies every output; measured by its pilots."""
DEFAULT_GYRO_RATE = 8000.0
"""Rate of most gyros [Hz]; a BMI270 has 3,200."""
MAX_RATE = 32000.0
LOW_PASSES = (("gyro_lpf1_static_hz", 250.0), ("gyro_lpf2_static_hz", 500.0))
FOLLOWING = ("gyro_lpf1_dyn_min_hz", 250.0)
"""Lower cut-off of the low-pass that follows the throttle, and its default; 0 for a static one."""
MAX_NOTCH_NAMES = 3
DEFAULT_IDLE = 550.0
"""Default of motor_idle [0.01 %]."""
MAX_IDLE = 0.2
"""Largest share of the motor range that is read."""


class CraftAxisTable(StrictTable):
    """Plant of an axis; delay: that of a frequency response."""

    gain: Annotated[float, Field(ge=0.01, le=1e5)]
    """Acceleration [deg/s2] per unit of output."""
    lag: Annotated[float, Field(ge=1e-3, le=0.2)]
    """Motor lag [s]."""
    delay: Annotated[float, Field(ge=0.0, le=0.05)]
    """Dead time with half a period of the hold [s]."""
    zero: Annotated[float, Field(ge=0.0, le=5.0)] = 0.0
    """Time constant of the zero of yaw [s]."""


class CraftTable(StrictTable):
    """Plants of a craft by axis."""

    roll: CraftAxisTable | None = None
    """Plant of roll."""
    pitch: CraftAxisTable | None = None
    """Plant of pitch."""
    yaw: CraftAxisTable | None = None
    """Plant of yaw."""


@dataclass(frozen=True)
class Profile:
    """A profile of a vehicle, as read.

    Attributes:
        tune: Its settings of the law.
        number: Number of the profile.
        revision: Revision of the firmware, "" for none.
        is_known: Whether revision or settings show the build, or a person named it.
        sampling: Rates and filters.
        linear: Factor of thrust_linear on every output.
        idle: Share of the motor range below which no motor idles.
        notes: Sentences on assumptions.
    """

    tune: Tune
    number: int
    revision: str
    is_known: bool
    sampling: Sampling
    linear: float
    idle: float
    notes: tuple[str, ...]

    def plants(self, plants: Mapping[str, AxisPlant]) -> dict[str, AxisPlant]:
        """Return plants with the gain of thrust_linear."""
        return {axis: scaled(plant, self.linear) for axis, plant in plants.items()}


def read_adrc(file: ReadableFile, number: int | None = None, build: str = "", gyro_rate: float = 0.0) -> Profile:
    """Return a profile with the law; raises InputError naming the setting that it refuses.

    Args:
        file: Output of `diff all` or `dump all`.
        number: Number of the profile, None for the selected one.
        build: Name of the build, "" to recognize it.
        gyro_rate: Rate of the gyro [Hz], 0 for the usual one.
    """
    chosen = (read_selected(file) or 0) if number is None else number
    texts = read_profile(file, chosen).values
    if texts.get("pid_type") != "ADRC":
        message = (
            f"profile {chosen} has pid_type = {shortened(texts.get('pid_type', 'CLASSIC'))}; give a profile with ADRC"
        )
        raise InputError(f"{message} by --profile", file=file, key="pid_type")
    revision = next((match[1] for line in command_lines(file) if (match := REVISION.fullmatch(line))), "")
    recognized = build_of(build) if build else recognize_build(revision, frozenset(texts))
    tune = _tune(texts, recognized or BUILDS[DEFAULT_BUILD], file)
    sampling = _sampling(texts, gyro_rate, file)
    level = _number(texts, "thrust_linear", 0.0, file)
    if not 0.0 <= level <= 100.0:
        raise InputError(f"given {level:g}; allowed 0 to 100", file=file, key="thrust_linear")
    low, high = next(pair for pair in zip(THRUST_LINEAR, THRUST_LINEAR[1:], strict=False) if level <= pair[1][0])
    factor = low[1] + (high[1] - low[1]) * (level - low[0]) / (high[0] - low[0])
    notes = _notes(texts, sampling, gyro_rate, recognized, revision)
    idle = 1e-4 * _number(texts, "motor_idle" if "motor_idle" in texts else "dshot_idle_value", DEFAULT_IDLE, file)
    if not 0.0 <= idle <= MAX_IDLE:
        raise InputError(f"given {100.0 * idle:g} %; allowed 0 to {100.0 * MAX_IDLE:g} %", file=file, key="motor_idle")
    return Profile(tune, chosen, revision, recognized is not None, sampling, factor, idle, notes)


def _tune(texts: Mapping[str, str], build: Build, file: ReadableFile) -> Tune:
    """Return the settings of the law, each within range and build."""
    names = [name for name in texts if name in SETTINGS or name.startswith("adrc_")]
    tune = default_tune(build)
    return replace(
        tune, numbers={**tune.numbers, **{name: read_setting(name, texts[name], build, file) for name in names}}
    )


def _sampling(texts: Mapping[str, str], gyro_rate: float, file: ReadableFile) -> Sampling:
    """Return the rates and the first-order low-passes of the gyro."""
    rate = gyro_rate or DEFAULT_GYRO_RATE
    if not 500.0 <= rate <= MAX_RATE:
        raise InputError(f"given {rate:g} Hz; allowed 500 to {MAX_RATE:g} Hz", key="gyro_rate")
    divider = _number(texts, "pid_process_denom", 1.0, file)
    if not 1.0 <= divider <= 16.0:
        raise InputError(f"given {divider:g}; allowed 1 to 16", file=file, key="pid_process_denom")
    cutoffs = [_number(texts, name, default, file) for name, default in LOW_PASSES]
    cutoffs[0] = _number(texts, *FOLLOWING, file) or cutoffs[0]
    return Sampling(divider / rate, 1.0 / rate, tuple(cutoff for cutoff in cutoffs if cutoff > 0.0))


def _number(texts: Mapping[str, str], name: str, default: float, file: ReadableFile) -> float:
    return parse_integer(texts[name], name, file) if name in texts else default


def _notes(
    texts: Mapping[str, str], sampling: Sampling, gyro_rate: float, build: Build | None, revision: str
) -> tuple[str, ...]:
    """Return the sentences on assumptions."""
    notes: list[str] = []
    if build is None:
        shown = f"revision {revision}" if revision else "the file names no revision"
        notes.append(f"Build not recognized ({shown}): taken as {DEFAULT_BUILD}. Name it by --build.")
    if not gyro_rate:
        rate = 1.0 / sampling.period
        notes.append(
            f"The loop is taken to run at {rate:.0f} Hz, of a gyro of {DEFAULT_GYRO_RATE:.0f} Hz. See --gyro-rate."
        )
    others = [name for name in texts if re.fullmatch(r"gyro_lpf[12]_type|dyn_notch_count|rpm_filter_harmonics", name)]
    if others:
        listed = ", ".join(f"{name} = {shortened(texts[name])}" for name in others[:MAX_NOTCH_NAMES])
        notes.append(f"Not in the margins: {listed}.")
    return tuple(notes)


def read_plants(path: Path, sampling: Sampling) -> dict[str, AxisPlant]:
    """Return the plants in a TOML file; raises InputError naming file and key.

    A table per axis has gain [deg/s2 per unit], lag [s], delay [s], and zero [s] for yaw.
    """
    table = toml_table(given_text(path, "give a table of plants by axis (.toml), or a file of command lines"), path)
    check_texts(table, file=path)
    try:
        craft = CraftTable.model_validate(table)
    except ValidationError as error:
        # Imported here: `tuner list` takes 0.07 s more with the tables of all studies.
        from tuner.study.messages import translated

        raise translated(error, path, CraftTable) from None
    tables = {axis: table for axis in AXES if (table := getattr(craft, axis)) is not None}
    if not tables:
        raise InputError(f"given nothing; give tables {', '.join(f'[{axis}]' for axis in AXES)}", file=path)
    return {
        axis: AxisPlant.identified(table.gain, table.lag, table.delay, sampling.period, table.zero)
        for axis, table in tables.items()
    }


def changed(profile: Profile, changes: Mapping[str, str]) -> Profile:
    """Return the profile with other settings; raises InputError naming one that is refused."""
    tune, file = profile.tune, Path("--gain")
    for name in changes:
        check_name("setting", name, SETTINGS, key="--gain")
    numbers = {name: read_setting(name, text, tune.build, file) for name, text in changes.items()}
    return replace(profile, tune=replace(tune, numbers={**tune.numbers, **numbers}))
