"""Write the package of a new extension from a template: what a stranger adds to the tool without a change of it."""

import keyword
from pathlib import Path

from plant.errors import InputError, StoreError, check_name
from plant.output_files import make_folders, write_new_file

HOME = Path(__file__).parent
KINDS = ("report", "law", "target")
"""Templates: command, metric and section of the report; control law; export target."""
DEFAULT_KIND = "report"
NAME = "@NAME@"
"""Place of the extension's name in file names and texts."""
ENDING = ".in"


def write_extension(name: str, kind: str | None = None) -> list[Path]:
    """Write the package of an extension into a new folder.

    Args:
        name: Path of the new folder; its last part is the name of the package and of the extension.
        kind: Template, see `KINDS`; by default that of a command, a metric and a section.

    Returns its files. Raises InputError for a name that is none in Python, StoreError where the folder exists.
    """
    folder, kind = Path(name), kind or DEFAULT_KIND
    check_name("kind of extension", kind, KINDS, key="--kind")
    package = folder.name
    if not package.isidentifier() or not package.islower() or keyword.iskeyword(package):
        message = (
            f"given '{package}'; write lower-case letters, digits and _, a letter first, for instance my_extension"
        )
        raise InputError(message, key="tuner new extension")
    if folder.exists():
        raise StoreError(f"{folder} exists already and was not touched; choose another name, or another folder")
    written = [folder / "pyproject.toml", folder / package / "__init__.py"]
    texts = [_filled(HOME / kind / f"pyproject.toml{ENDING}", package), ""]
    for template in sorted((HOME / kind).glob(f"*.py{ENDING}")):
        written.append(folder / package / template.name.removesuffix(ENDING))
        texts.append(_filled(template, package))
    try:
        for file, text in zip(written, texts, strict=True):
            make_folders(file.parent)
            write_new_file(file, text.encode())
    except OSError as error:
        raise StoreError(f"{folder} cannot be written ({error.strerror}); give another folder") from error
    return written


def _filled(template: Path, package: str) -> str:
    return template.read_text(encoding="utf-8").replace(NAME, package)
