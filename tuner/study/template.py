"""The study file that `tuner new NAME` writes: every table, the usual values, a comment on each line."""

import os
import re
from pathlib import Path

from plant.errors import InputError, StoreError
from plant.input_files import read_input_text
from plant.output_files import make_folders, write_new_file
from plant.own_code import refuse_unnamed
from plant.texts import PlainTable, toml_table
from tuner.study.files import SHIPPED, check_file_name, study_file
from tuner.study.reading import parse_toml
from tuner.text.toml_text import with_paths

TEMPLATE = Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
"""A study with @TITLE@ for its title."""


def write_study(name: str, source: Path | None = None) -> list[Path]:
    """Write the commented template, or a copied study; return the files.

    source: the study to copy. The first file is NAME.toml in this folder.
    Code next to a shipped study is copied along, to be changed. Raises StoreError where a file of such a name is there already,
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
    """Return the code files of a shipped study, relative to it; none of a user's study."""
    return [name for name in _code_of(study) if name.endswith(".py")] if study.parent.resolve() == SHIPPED else []


def _code_of(study: Path) -> list[str]:
    """Return the code files of a study, FMUs included, relative to it."""
    named: list[str] = []

    def note(name: str) -> str:
        named.append(name)
        return name

    with_paths(parse_toml(study), note)
    return [name for name in named if name.endswith((".py", ".fmu"))]


def copied_study(source: Path, target: Path) -> str:
    """Return the text of a study, comments included, for another path.

    Its paths and its comments follow.
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
        text = re.sub(rf"(?m)^(#.*?){pattern}", lambda match, word=word: f"{match[1]}{word}", text)
    if toml_table(text, source) != wanted:
        raise InputError(
            f"its paths cannot be changed for {target.parent}; copy the file and change them by hand", file=source
        )
    return text


def _moved(table: PlainTable, home: Path, away: Path, moves: dict[str, str]) -> PlainTable:
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
