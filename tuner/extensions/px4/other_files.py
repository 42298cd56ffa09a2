"""Parameters of PX4 in other files than `.params`: airframe scripts, and flight logs (ULog).

ROMFS/px4fmu_common/init.d/airframes: `param set-default NAME VALUE` since 1.12, before `param set` where AUTOCNF is yes. The last
of repeated lines counts. Lines that another condition guards are left out, as are files that a script includes.
"""

import re
from dataclasses import dataclass, field

from plant.errors import InputError, one_line, shortened
from plant.input_files import ReadableFile, given_content, given_text
from tuner.extensions.autopilots.parameters import NUMBER, positional
from tuner.extensions.autopilots.resolution import MAX_LOG_BYTES, MAX_NAMES, Resolved, log_notes, plain_file
from tuner.extensions.logs.logged_parameters import ulog_parameters
from tuner.extensions.logs.ulog import is_ulog
from tuner.extensions.px4.text import INTEGER, NAME, REAL, WHAT
from tuner.text.sentences import first_texts

SETTING = re.compile(r"\s*param\s+set(?:-default)?\s+(?:-s\s+)?([A-Z]\w*)\s+([^\s#]+)\s*(?:fail\s*)?(?:#.*)?")
TYPE = re.compile(r"#\s*@type\s+(\S.*?)\s*")
QUADROTORS = ("quadrotor", "multirotor", "simulation", "copter")
"""Beginnings of `@type` of vehicles that may have four rotors."""
CONDITION = re.compile(r"if\s+(\S.*?)\s*(;\s*then)?")
ONE_LINE = re.compile(r"if\s.*;\s*fi\b.*")
"""Condition that ends in its own line."""
AUTOMATIC = re.compile(r".*\bAUTOCNF\b.*\byes\b.*|.*param\s+compare\s+SYS_AUTOCONFIG\s+1\b.*")
"""Condition that holds where the parameters of an airframe are set."""
INCLUDE = re.compile(r"\s*(?:\.|sh|source)\s+(\S+)")


def plain(file: ReadableFile) -> ReadableFile:
    """Return a file of parameters in the columns of QGroundControl."""
    return plain_file(file, resolved(file))


def resolved(file: ReadableFile) -> Resolved | None:
    """Return the parameters of a script or log; None for any other file."""
    content = given_content(file, f"give {WHAT}", MAX_LOG_BYTES)
    if is_ulog(content):
        log = ulog_parameters(content, str(file))
        head = [f"# Stack: {log.firmware or 'PX4'}", *([f"# Version: {log.version}"] if log.version else [])]
        return Resolved(_columns(head, log.values), log_notes(log))
    if b"param set" not in content or not any(map(SETTING.fullmatch, lines := _lines(file))):
        return None
    return _script(lines, file)


def _lines(file: ReadableFile) -> list[str]:
    return given_text(file, f"give {WHAT}").splitlines()


def _columns(head: list[str], values: dict[str, float]) -> str:
    """Return parameters as QGroundControl writes them."""
    rows = [
        f"1\t1\t{name}\t{positional(value) if not value.is_integer() else int(value)}\t"
        f"{INTEGER if value.is_integer() else REAL}"
        for name, value in values.items()
    ]
    return "\n".join([*head, *rows]) + "\n"


def _script(lines: list[str], file: ReadableFile) -> Resolved:
    """Return the parameters that an airframe script sets."""
    script = _Script()
    for line in lines:
        script.read(line.strip())
    if (kind := script.kind.lower()) and not kind.startswith(QUADROTORS):
        message = (
            f"given {shortened(script.kind)}; only files of quadrotors can be read: gains mean other torques elsewhere"
        )
        raise InputError(message, file=file, key="@type")
    values = {name: float(text) for name, text in script.values.items() if NAME.fullmatch(name)}
    return Resolved(_columns(["# Stack: PX4 Pro"], values), script.notes())


@dataclass
class _Script:
    """An airframe script.

    Attributes:
        values: Name -> number as text.
        repeated: Parameters that are set to several values.
        skipped: Conditions whose lines are left out, and values that are no numbers.
        included: Scripts that it includes.
        kind: Kind of the vehicle as `@type` states it, "" without it.
        branches: Whether the lines of each open condition count.
    """

    values: dict[str, str] = field(default_factory=dict[str, str])
    repeated: dict[str, None] = field(default_factory=dict[str, None])
    skipped: dict[str, None] = field(default_factory=dict[str, None])
    included: dict[str, None] = field(default_factory=dict[str, None])
    kind: str = ""
    branches: list[bool] = field(default_factory=list[bool])

    def read(self, line: str) -> None:
        """Read one line."""
        if ONE_LINE.fullmatch(line):
            self.skipped[line] = None
        elif match := CONDITION.fullmatch(line):
            self.branches.append(AUTOMATIC.fullmatch(shortened(match[1])) is not None)
            if not self.branches[-1]:
                self.skipped[f"if {match[1]}"] = None
        elif line.split(None, 1)[:1] in (["else"], ["elif"]) and self.branches:
            self.branches[-1] = False
        elif re.fullmatch(r"fi\b.*", line):
            del self.branches[-1:]
        elif match := TYPE.fullmatch(line):
            self.kind = match[1]
        elif all(self.branches):
            self._execute(line)

    def _execute(self, line: str) -> None:
        if match := INCLUDE.fullmatch(line):
            self.included[match[1].rpartition("/")[2]] = None
        elif match := SETTING.fullmatch(line):
            name, text = match.groups()
            if not NUMBER.fullmatch(text):
                self.skipped[f"{name} = {text}"] = None
                return
            if self.values.get(name, text) != text:
                self.repeated[name] = None
            self.values[name] = text

    def notes(self) -> tuple[str, ...]:
        """Return the sentences on included, left out and repeated lines."""
        sentences = {
            "Included by the script, and not read": self.included,
            "Left out, because the value depends on the vehicle": self.skipped,
            "Set more than once; the last value counts, as on the vehicle": self.repeated,
        }
        return (
            f"Read as an airframe script of PX4: it sets {len(self.values)} parameters.",
            *(f"{sentence}: {_listed(list(names))}." for sentence, names in sentences.items() if names),
        )


def _listed(names: list[str]) -> str:
    return first_texts([shortened(one_line(name)) for name in names], MAX_NAMES)
