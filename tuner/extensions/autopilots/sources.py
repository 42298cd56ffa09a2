"""Parameter files of any firmware: the source guessed from their lines, one laid over another, compared name by name."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from plant.errors import InputError, UnsupportedVersionError
from plant.input_files import InputFile, ReadableFile, given_content, given_text
from tuner.extension import objects
from tuner.extensions.autopilots.assembly import LOOPS, NATIVE_LOOPS
from tuner.extensions.autopilots.parameters import single
from tuner.extensions.autopilots.resolution import MAX_LOG_BYTES, Resolved
from tuner.extensions.autopilots.vehicle_facts import VehicleFact
from tuner.study.targets import TARGETS

GAINS = "gains"
"""Source of a gains.json."""
WHAT = "a parameter file of PX4, ArduPilot, Betaflight or the Crazyflie, or a gains.json"
PERIOD, EVERY, PROFILE = "control_period", "position_every", "profile"
SAME = 1e-6
"""Share by which two texts of one float32 may differ."""

Values = Mapping[str, str | float]


@dataclass(frozen=True)
class Source:
    """Parameter files of one firmware.

    Attributes:
        line: A line that such a file alone has.
        name: A line that gives a parameter, its name as the last group that is there.
        values: Return every parameter of a file; InputError names file and parameter.
        version: Return the version that a file states, major.minor, None if silent.
        options: Return the options of the import of a file.
        is_command_line: True for lines of a command line, with whole numbers and words.
        rate_gain: Name of a gain of a rate loop.
        versions: First and last version, major and minor, whose names and units are known; None: the reader refuses others.
        is_of_known_units: Return True for a file whose names, or version, decide the units.
        wiring: Return the settings of a file that are no parameters.
        left_out: Parameters that an import takes as 0.
        scaling: Parameters that nothing tunes and that scale the loops.
        facts: Return the facts on the vehicle among the parameters of a file.
        loaded_over: Return the text of a file with another one loaded over it; None: a parameter replaces that of its name.
        resolved: Return the parameters of a log, a script or a file that includes others as text; None for any other file.
        is_log: Return True for the content of a flight log of the firmware.
        rank: Place among the sources: a lower one looks at a file first.
    """

    line: re.Pattern[str]
    name: re.Pattern[str]
    values: Callable[[ReadableFile], Values]
    version: Callable[[ReadableFile], str | None]
    options: Callable[[ReadableFile], dict[str, str]]
    rate_gain: re.Pattern[str]
    versions: tuple[tuple[int, int], tuple[int, int]] | None = None
    is_of_known_units: Callable[[ReadableFile], bool] = lambda _: True
    wiring: Callable[[ReadableFile], Values] = lambda _: {}
    is_command_line: bool = False
    left_out: frozenset[str] = frozenset()
    scaling: frozenset[str] = frozenset()
    facts: Callable[[Values], Sequence[VehicleFact]] = lambda _: ()
    loaded_over: Callable[[ReadableFile, ReadableFile], str] | None = None
    resolved: Callable[[ReadableFile], Resolved | None] = lambda _: None
    is_log: Callable[[bytes], bool] = lambda _: False
    rank: int = 0

    def name_in(self, line: str) -> str | None:
        """Return the name of a line's parameter, if any."""
        match = self.name.fullmatch(line)
        return None if match is None else match[match.lastindex or 0]


@cache
def sources() -> dict[str, Source]:
    """Return the sources of parameter files by name; the first that recognizes a file is its source."""
    return dict(sorted(objects("sources").items(), key=lambda entry: entry[1].rank))


def major_minor(version: str | None) -> str | None:
    """Return the first two numbers of a version."""
    match = re.match(r"\d+\.\d+", version or "")
    return match[0] if match else None


def fixed_options(name: str, *keys: str) -> Callable[[ReadableFile], dict[str, str]]:
    """Return the options with the rates of a target; keys: those that its importer has."""
    rates = {PERIOD: f"{TARGETS[name].control_period:.9g}", EVERY: str(TARGETS[name].position_every)}
    given = {LOOPS.name: NATIVE_LOOPS, **rates}
    return lambda _: {key: given[key] for key in keys}


def guess_source(file: ReadableFile) -> str:
    """Return the source of a file; InputError where nothing is recognized."""
    content = given_content(file, f"give {WHAT}", MAX_LOG_BYTES)
    if log := next((name for name, source in sources().items() if source.is_log(content)), None):
        return log
    text = given_text(InputFile(Path(file), content), f"give {WHAT}")
    if text.lstrip().startswith("{"):
        return GAINS
    lines = text.splitlines()
    for name, source in sources().items():
        if any(source.line.fullmatch(line) for line in lines):
            return name
    raise InputError(f"holds nothing of a known firmware; give {WHAT}, or name the source with --from", file=file)


def changed_values(before: Values, after: Values) -> dict[str, tuple[str | float | None, str | float | None]]:
    """Return name -> values before and after where they differ; None: not there."""
    return {
        name: (before.get(name), after.get(name))
        for name in dict.fromkeys((*after, *before))
        if name not in before or name not in after or before[name] != after[name]
    }


def overlaid(source: Source, before: ReadableFile, after: ReadableFile) -> str:
    """Return the parameters of a vehicle after loading a file, as text."""
    if source.loaded_over is not None:
        return source.loaded_over(before, after)
    later = given_text(after, f"give {WHAT}").splitlines()
    replaced = {name for line in later if (name := source.name_in(line)) is not None}
    lines, current = list[str](), None
    for line in given_text(before, f"give {WHAT}").splitlines():
        # Fields of a parameter in YAML's block style stand below it, indented further.
        current = source.name_in(line) or (current if line.startswith("    ") else None)
        if current not in replaced:
            lines.append(line)
    return "\n".join([*lines, *later]) + "\n"


def check_versions(source: Source, before: ReadableFile, after: ReadableFile) -> None:
    """Refuse two files that state different versions; raises InputError that names both."""
    earlier, later = source.version(before), source.version(after)
    if earlier is not None and later is not None and earlier != later:
        # An export is of the version that it is written for; what it replaces lies beside it, in the same names.
        rollback = Path(after).parent / "rollback" / after.name
        such = f", such as {rollback} for {before}" if rollback.exists() else ""
        differ = "names, units and defaults differ; give files of one version"
        message = f"is of version {later}, and {before} of {earlier}: {differ}{such}"
        raise InputError(message, file=after, key="version")


def version_fault(source: Source, files: Sequence[ReadableFile]) -> str:
    """Return the fault in the version of files, "" without one.

    Raises InputError where a file is of another firmware.
    """
    try:
        stated_versions = {file: source.version(file) for file in files}
    except UnsupportedVersionError as error:
        return str(error)
    for file, version in stated_versions.items():
        if version is not None and source.versions is not None:
            first, last = source.versions
            if not first <= (*map(int, version.split(".")),) <= last:
                span = f"{first[0]}.{first[1]} to {last[0]}.{last[1]}"
                return f"{file.name} is of version {version}; names and units are known of {span}"
    if not any(map(source.is_of_known_units, files)):
        return "no file states the firmware's version, which decides the meaning of its gains: give one with its first lines"
    return ""


def differing_values(
    source: Source, written: Values, held: Values
) -> dict[str, tuple[str | float, str | float | None]]:
    """Return name -> written and held value where they differ; None: missing."""
    return {
        name: (value, held.get(name))
        for name, value in written.items()
        if name not in held or not is_same(value, held[name], source.is_command_line)
    }


def is_same(written: str | float, held: str | float, is_integer: bool) -> bool:
    """Return True if a vehicle may hold a written value so: as float32, a whole number, or a word in either case."""
    if isinstance(written, str) or isinstance(held, str):
        first, second = str(written).strip(), str(held).strip()
        return first.casefold() == second.casefold() or (is_integer and _is_same_integer(first, second))
    return abs(single(written) - single(held)) <= SAME * max(abs(written), abs(held))


def _is_same_integer(first: str, second: str) -> bool:
    """Return True for two spellings of one whole number."""
    return bool(re.fullmatch(r"[+-]?\d+", first) and re.fullmatch(r"[+-]?\d+", second)) and int(first) == int(second)
