"""Presets of Betaflight: command lines with `#$` directives, as the Configurator resolves them.

betaflight/betaflight-configurator, src/tabs/presets/PresetsRepoIndexed/PresetParser.js. `INCLUDE` puts another preset in its
place, and an option acts where the preset itself has it CHECKED. `FIRMWARE_VERSION` states the releases.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from plant.errors import InputError, shortened
from plant.input_files import MAX_JSON_BYTES, InputFile, ReadableFile, given_content
from tuner.extensions.autopilots.parameters import read_lines
from tuner.extensions.autopilots.resolution import Resolved
from tuner.text.sentences import first_texts

WHAT = "what Betaflight's command line prints for 'diff all' or 'dump all'"
DIRECTIVE = re.compile(r"#\$\s*(.*)")
INCLUDE = re.compile(r"INCLUDE:\s*(\S+)")
OPTION_BEGIN = re.compile(r"OPTION BEGIN\s*(\((?:UN)?CHECKED\))?\s*:?\s*(.*)", re.IGNORECASE)
OPTION_END = re.compile(r"OPTION END.*", re.IGNORECASE)
STATED_VERSION = re.compile(r"#\$\s*FIRMWARE_VERSION:\s*(\d+\.\d+)(?:\.\d+\S*)?\s*")
OPTION_STATE = re.compile(r"#\$ OPTION (applied|left out): (.*)")
"""Line that replaces an option."""
INCLUDABLE = re.compile(r"(?!.*\.\.)[\w.+-]+(/[\w.+-]+)*")
"""Path of an included file: no folder above, no drive."""
MAX_DEPTH = 8
"""Largest number of presets within each other."""
MAX_FILES = 100
"""Largest number of included presets."""
MAX_NAMES = 20
"""Largest number of options or settings that a sentence names."""
MAX_LINES = 100_000
"""Largest number of lines."""


def command_lines(file: ReadableFile) -> list[str]:
    """Return the lines of a file with its includes and options resolved; InputError where an include is not there."""
    lines = [line.strip() for line in read_lines(file, WHAT)]
    if not any(map(DIRECTIVE.fullmatch, lines)):
        return lines
    return _Preset(file, _checked_options(lines)).resolved(lines)


def resolved_preset(file: ReadableFile) -> Resolved | None:
    """Return a preset with its includes; None without any."""
    matches = filter(None, map(DIRECTIVE.fullmatch, map(str.strip, read_lines(file, WHAT))))
    has_include = any(INCLUDE.fullmatch(match[1]) for match in matches)
    return Resolved("\n".join(command_lines(file)) + "\n") if has_include else None


def stated_versions(lines: list[str]) -> list[str]:
    """Return the releases that a preset is for, such as 4.5."""
    return list(dict.fromkeys(match[1] for line in lines if (match := STATED_VERSION.fullmatch(line))))


def options_note(lines: list[str]) -> tuple[str, ...]:
    """Return the sentence on the options of a preset; lines: resolved."""
    by_state: dict[str, list[str]] = {"applied": [], "left out": []}
    for match in filter(None, map(OPTION_STATE.fullmatch, lines)):
        by_state[match[1]].append(shortened(match[2]))
    if not any(by_state.values()):
        return ()
    texts = [f"{state}: {_listed(list(dict.fromkeys(names)))}" for state, names in by_state.items()]
    return (f"Options of the preset, {'; '.join(texts)}.",)


def _listed(names: list[str]) -> str:
    return first_texts(names, MAX_NAMES) or "none"


def _checked_options(lines: list[str]) -> frozenset[str]:
    """Return the names of a preset's checked options in lower case."""
    directives = filter(None, map(DIRECTIVE.fullmatch, lines))
    options = filter(None, (OPTION_BEGIN.fullmatch(directive[1]) for directive in directives))
    return frozenset(option[2].strip().lower() for option in options if (option[1] or "").lower() == "(checked)")


@dataclass
class _Preset:
    """The resolution of one preset.

    Attributes:
        file: Path of the preset.
        checked: Names of its checked options, in lower case.
        n_files: Number of included files so far.
        n_lines: Number of lines so far.
    """

    file: ReadableFile
    checked: frozenset[str]
    n_files: int = 0
    n_lines: int = 0

    def resolved(self, lines: list[str]) -> list[str]:
        """Return the lines with everything included, without options that are not checked."""
        return list(self._resolve(lines, 0))

    def _resolve(self, lines: list[str], depth: int) -> Iterator[str]:
        is_left_out = False
        for line in lines:
            directive = DIRECTIVE.fullmatch(line)
            if directive is None:
                if not is_left_out:
                    yield self._counted(line)
            elif option := OPTION_BEGIN.fullmatch(directive[1]):
                is_left_out = option[2].strip().lower() not in self.checked
                # Options of an included preset are not those that a pilot sees.
                if depth == 0 or not is_left_out:
                    yield f"#$ OPTION {'left out' if is_left_out else 'applied'}: {option[2].strip()}"
            elif OPTION_END.fullmatch(directive[1]):
                is_left_out = False
            elif include := INCLUDE.fullmatch(directive[1]):
                if not is_left_out:
                    yield from self._resolve(self._included(include[1], depth), depth + 1)
            elif depth == 0:
                yield self._counted(line)

    def _included(self, name: str, depth: int) -> list[str]:
        """Return the lines of an included preset."""
        self.n_files += 1
        if depth >= MAX_DEPTH or self.n_files > MAX_FILES:
            message = (
                f"includes more than {MAX_FILES} presets, or {MAX_DEPTH} within each other; give the resolved lines"
            )
            raise InputError(message, file=self.file)
        path = _find_included(_path_of(self.file), name)
        if path is None:
            message = (
                f"includes {shortened(name)}, which is neither in its folder nor in the folder of all presets; give the "
                f"preset within that folder, or {WHAT}"
            )
            raise InputError(message, file=self.file, key="INCLUDE")
        # Read as any other file of a stranger, but no included preset is larger than a few kilobytes.
        content = given_content(path, f"give {WHAT}", MAX_JSON_BYTES)
        return [line.strip() for line in read_lines(InputFile(path, content), WHAT)]

    def _counted(self, line: str) -> str:
        self.n_lines += 1
        if self.n_lines > MAX_LINES:
            raise InputError(f"has more than {MAX_LINES:,} lines with its includes; give {WHAT}", file=self.file)
        return line


def _path_of(file: ReadableFile) -> Path:
    return file.path if isinstance(file, InputFile) else file


def _find_included(preset: Path, name: str) -> Path | None:
    """Return the path of an included file, None without one.

    Names begin at the folder of all presets, whose folders are parents of this preset; a file may also be in its own folder.
    """
    if not INCLUDABLE.fullmatch(name):
        return None
    path, within = PurePosixPath(name), preset.resolve().parent
    roots = [folder.parent for folder in (within, *within.parents) if folder.name == path.parts[0]]
    places = [*[(root, root / path) for root in roots], (within, within / path), (within, within / path.name)]
    return next((file for root, file in places if file.is_file() and file.resolve().is_relative_to(root)), None)
