"""Studies as a person names them: a path, a file of one's own without its ending, or one that comes with the tool."""

import os
import re
from pathlib import Path
from typing import Any

from plant.errors import InputError, UnknownNameError
from plant.input_files import read_input_text
from plant.texts import toml_table
from tuner.text.toml_text import with_paths

SHIPPED = Path(__file__).resolve().parents[2] / "studies"
"""The folder of the shipped studies: beside the packages, in a clone as in an installed wheel."""


def shipped_studies() -> dict[str, Path]:
    """Return name -> file of every study that comes with the tool."""
    return {path.stem: path for path in sorted(SHIPPED.glob("*.toml"))}


def study_file(given: Path) -> Path:
    """Return the file of a study: the path given where it exists, else NAME.toml in this folder, else the shipped NAME.

    Raises InputError where a name is none of these; a path to nowhere is returned for its reader to report.
    """
    known = shipped_studies()
    if given.exists() and not given.is_dir():
        return given
    if str(given) == given.name and not given.suffix:
        own = Path(f"{given}.toml")
        if own.is_file():
            return own
        if given.name in known:
            return known[given.name]
        raise UnknownNameError("study", given.name, known)
    if given.suffix == ".toml" and given.stem in known:
        raise InputError(
            f"there is no such file; `{given.stem}` alone names the study that comes with the tool", file=given
        )
    return given


def base_file(folder: Path, name: str) -> Path:
    """Return the file that a study in a folder names as its base: beside it, else the shipped study of that file name."""
    beside = folder / name
    if not beside.is_file() and Path(name).name == name:
        return shipped_studies().get(Path(name).stem, beside)
    return beside


def copied_study(source: Path, target: Path) -> str:
    """Return the text of a study, comments included, as it stands at another path: its paths and its comments follow.

    Raises InputError where the source cannot be read, or spells a path so that it cannot be replaced in the text.
    """
    from tuner.study.reading import parse_toml

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

    def move(name: str) -> str:
        moves[name] = name if home.resolve() == away.resolve() else Path(os.path.relpath(home / name, away)).as_posix()
        return moves[name]

    moved = with_paths(table, move)
    # The base of a shipped study is found by its name from everywhere.
    if isinstance(moved.get("base"), str) and home.resolve() != SHIPPED:
        moved["base"] = move(moved["base"])
    return moved
