"""The archive of an FMU: its sources, its binary where gcc is there, and its GUID."""

import hashlib
import io
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.resources import files

from tuner.exchange.c99.sources import Code as Generated
from tuner.exchange.target import Option
from tuner.extensions.fmi.code import PLATFORM, compiler, shared_library
from tuner.extensions.fmi.xml_files import IDENTIFIER

# The earliest date that a zip archive can hold.
DATE = (1980, 1, 1, 0, 0, 0)
REGULAR_FILE = 0o100644


def archive(files: Mapping[str, bytes]) -> bytes:
    """Return the archive of files: name -> content."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w") as target:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3
            entry.external_attr = REGULAR_FILE << 16
            target.writestr(entry, files[name])
    return held.getvalue()


PREFIX = "gainproof"
FMI_SOURCES = ("fmi2_interface.h", "fmi2_cosimulation.c")
NAME = f"{PREFIX}_controller"
UNITS = ("fmi2_cosimulation.c", f"{NAME}.c")
MOCK_UP, VALUES = "gainproof.fmu", "gainproof.ssv"
REAL = Option("real", "floating-point type of the code", ("float", "double"), "float")
VERSION = "FMI 2.0 co-simulation, SSP 1.0"
BUILT_IN = (
    "Gains are constants built into the code: a simulator can read them, not set or tune them; export again to change."
)
SINGLE = "The code computes in single precision, as on a microcontroller; --set real=double for double."


@dataclass(frozen=True)
class Code:
    """All sources (name -> text), GUID and binary (or None) of an FMU."""

    sources: dict[str, str]
    guid: str
    binary: bytes | None


def built(generated: Generated, digest: str, bind: Callable[[str], str]) -> Code:
    """Return the code of an FMU, compiled where possible; bind: binding.h for a GUID."""
    sources = {f"{NAME}.h": generated.header, f"{NAME}.c": generated.source}
    sources |= {name: files("tuner.extensions.fmi").joinpath(name).read_text(encoding="utf-8") for name in FMI_SOURCES}
    guid = guid_of(digest, sources | {"binding.h": bind("")})
    sources |= {"binding.h": bind(guid)}
    gcc = compiler()
    return Code(sources, guid, None if gcc is None else shared_library(sources, UNITS, gcc))


def packed(code: Code, description: bytes, values: bytes, page: str) -> bytes:
    """Return the FMU of a code."""
    content = {
        "modelDescription.xml": description,
        f"resources/{VALUES}": values,
        "documentation/index.html": page.encode(),
        **{f"sources/{name}": text.encode() for name, text in code.sources.items()},
    }
    if code.binary is not None:
        content |= {f"binaries/{PLATFORM}/{IDENTIFIER}.so": code.binary}
    return archive(content)


def guid_of(digest: str, sources: dict[str, str]) -> str:
    """Return the GUID of gains and code; it changes with every byte."""
    total = hashlib.sha256(digest.encode())
    for name in sorted(sources):
        total.update(name.encode() + b"\0" + sources[name].encode() + b"\0")
    text = total.hexdigest()
    return f"{{{text[:8]}-{text[8:12]}-{text[12:16]}-{text[16:20]}-{text[20:32]}}}"


def of_binary(code: Code) -> str:
    """Return the sentence on the platforms of an FMU."""
    if code.binary is not None:
        return f"The binary is for x86-64 Linux ({PLATFORM}) only; elsewhere build it from sources/."
    return (
        "The FMU holds sources only: there is no gcc for x86-64 Linux here; build the library by the command in "
        "documentation/index.html, or export where gcc is installed."
    )
