"""A plant's file, read and run: its names, its digest, and its errors as one line with file and line."""

import hashlib
import sys
import traceback
from pathlib import Path
from types import ModuleType

from plant.errors import InputError
from plant.input_files import read_input
from plant.model.plant_model import PlantModel, plant_from


def load_plant(file: Path) -> PlantModel:
    """Return the plant of a file that the user named; it is run. InputError names file and line where it does not work."""
    return plant_from(vars(run_file(file)), file.stem, str(file))


def run_file(file: Path) -> ModuleType:
    """Run a Python file of the user's as a module of its own and return it; the same content is run once.

    Raises InputError where it cannot be read or fails.
    """
    try:
        content = read_input(file)
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror}); the path is relative to the study file", file=file
        ) from None
    name = f"holdfast_user_{file.stem}_{digest_of(content)}"
    if name not in sys.modules:
        module = ModuleType(name)
        module.__file__ = str(file)
        sys.modules[name] = module
        try:
            exec(compile(content, str(file), "exec"), vars(module))
        except Exception as error:
            del sys.modules[name]
            raise InputError(f"{type(error).__name__}: {error}", file=_place(file, error)) from error
    return sys.modules[name]


def digest_of(content: bytes) -> str:
    """Return the digest of a file's content."""
    return hashlib.blake2b(content, digest_size=12).hexdigest()


def _place(file: Path, error: Exception) -> str:
    """Return the file, and the line in it that failed."""
    if isinstance(error, SyntaxError) and error.filename == str(file):
        return f"{file}:{error.lineno}"
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(file)]
    return f"{file}:{lines[-1]}" if lines else str(file)
