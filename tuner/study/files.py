"""Studies as a person names them: a path, a file of one's own without its ending, or one that comes with the tool."""

from pathlib import Path

from plant.errors import InputError, UnknownNameError

SHIPPED = Path(__file__).resolve().parents[2] / "studies"
"""The folder of the shipped studies: next to the packages, in a clone as in an installed wheel."""


def shipped_studies() -> dict[str, Path]:
    """Return name -> file of every study that comes with the tool."""
    return {path.stem: path for path in sorted(SHIPPED.glob("*.toml"))}


def study_file(given: Path) -> Path:
    """Return the file of a study: the path given where it exists, else NAME.toml in this folder, else the shipped NAME.

    Raises InputError where a name is none of these; a path to nowhere is returned for its reader to report.
    """
    shipped = shipped_studies()
    if given.exists() and not given.is_dir():
        return given
    if str(given) == given.name and not given.suffix:
        local = Path(f"{given}.toml")
        if local.is_file():
            return local
        if given.name in shipped:
            return shipped[given.name]
        raise UnknownNameError("study", given.name, shipped)
    if given.suffix == ".toml" and given.stem in shipped:
        raise InputError(
            f"there is no such file; `{given.stem}` alone names the study that comes with the tool", file=given
        )
    return given


def named_study(given: Path) -> Path | None:
    """Return the file of a .toml path or shipped study, else None."""
    if given.suffix == ".toml" or (not given.exists() and str(given) in shipped_studies()):
        return study_file(given)
    return None


def base_file(folder: Path, name: str) -> Path:
    """Return the base file in a study's folder, else the shipped one."""
    near = folder / name
    if not near.is_file() and Path(name).name == name:
        return shipped_studies().get(Path(name).stem, near)
    return near


def is_shipped(file: Path) -> bool:
    """Return True for a file among the shipped studies, links resolved."""
    return file.resolve().is_relative_to(SHIPPED)


def check_file_name(path: Path) -> None:
    """Refuse a study file whose name cannot stand in a results folder: with a backslash or bytes that are no UTF-8."""
    if "\\" in path.name or not path.name.isprintable():
        raise InputError("its name holds a backslash or signs that do not print; rename the file", file=path)
