"""A firmware's control libraries with every float a double, so that laws are compared and not rounding."""

import re
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from tuner.extensions.autopilots.libraries.building import ControlLibraries

LITERAL = re.compile(r"(?<![\w.])((?:\d[\d']*\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)f\b")
FUNCTION = re.compile(r"\b(sqrt|fabs|sin|cos|tan|asin|acos|atan2|fmax|fmin|pow|floor|round|exp)f\b")
# Sizes of types are what changes.
SIZES = re.compile(r"static_assert\(sizeof[^;]*;")
ENDINGS = {".cpp", ".hpp", ".h"}


def in_double(text: str) -> str:
    """Return a source with types, constants and functions of C++ of twice the precision; overloads stay apart."""
    for kind, wider in (("double", "wide"), ("float", "double")):
        text = re.sub(rf"\b{kind}\b(?!\.h)", wider, text)
    return SIZES.sub("", FUNCTION.sub(r"\1", LITERAL.sub(r"\1", text)))


def built_in_double(
    libraries: ControlLibraries, checkout: Path, place: Path, parts: Sequence[str] = (), options: Sequence[str] = ()
) -> Path:
    """Compile a copy of a checkout in double precision; return the program.

    Args:
        libraries: Control libraries.
        checkout: The checkout.
        place: Folder of the copy and of the program.
        parts: Folders that are copied, by default all.
        options: Further options of the compiler.
    """
    for folder in parts or libraries.folders:
        for file in (checkout / folder).rglob("*"):
            if file.suffix in ENDINGS and "test" not in file.name.lower():
                copied(file, place / "sources" / file.relative_to(checkout))
    for file in (libraries.source, libraries.middleware):
        copied(file, place / "ours" / file.name)
    made = replace(
        libraries,
        source=place / "ours" / libraries.source.name,
        middleware=place / "ours" / libraries.middleware.name,
    )
    (place / "wide.hpp").write_text("using wide = long double;\n")
    return made.compile(place / "sources", place / "in_double", (*options, "-include", str(place / "wide.hpp")))


def copied(file: Path, to: Path) -> None:
    """Copy a source in double precision, once."""
    if not to.exists():
        to.parent.mkdir(parents=True, exist_ok=True)
        to.write_text(in_double(file.read_text(errors="replace")))
        shutil.copymode(file, to)
