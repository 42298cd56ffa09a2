"""FMI 2.0 for co-simulation: the C99 code of the controller in an FMU, and the gains next to it as SSV.

Functional Mock-up Interface 2.0.4 (Modelica Association, 2022). The FMU holds its sources, so it can be built for other
platforms; where gcc for x86-64 Linux is there, the binary is inside.
"""

import hashlib
import io
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.resources import files

import numpy as np

from tuner.exchange.aboard import rollback_request
from tuner.exchange.c99.quadrotor import c_sources
from tuner.exchange.target import Bundle, ExportTarget, Option, Request
from tuner.exchange.texts import c_comment, filled, heading, xml_text
from tuner.extensions.fmi.code import PLATFORM, binding, compiler, shared_library
from tuner.extensions.fmi.variables import variables
from tuner.extensions.fmi.xml_files import IDENTIFIER, model_description, parameter_values
from tuner.gains import Controller

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
REAL = Option("real", "floating-point type of the code", ("float", "double"), "float")
MOCK_UP, VALUES = "gainproof.fmu", "gainproof.ssv"


@dataclass(frozen=True)
class Code:
    """All sources (name -> text), GUID and binary (or None) of an FMU."""

    sources: dict[str, str]
    guid: str
    binary: bytes | None


def fmu(request: Request) -> tuple[bytes, Code]:
    """Return the FMU of a request and the code in it."""
    code = code_of(request)
    content = {
        "modelDescription.xml": model_description(request, variables(request.controller), code.guid, UNITS),
        f"resources/{VALUES}": parameter_values(request),
        "documentation/index.html": documentation(request, code).encode(),
        **{f"sources/{name}": text.encode() for name, text in code.sources.items()},
    }
    if code.binary is not None:
        content |= {f"binaries/{PLATFORM}/{IDENTIFIER}.so": code.binary}
    return archive(content), code


def code_of(request: Request) -> Code:
    """Write the sources of an FMU and compile them where possible."""
    controller = request.controller
    exposed = variables(controller)
    generated = c_sources(controller, request.settings[REAL.name], PREFIX, request.digest)
    sources = {f"{NAME}.h": generated.header, f"{NAME}.c": generated.source}
    sources |= {name: files("tuner.extensions.fmi").joinpath(name).read_text(encoding="utf-8") for name in FMI_SOURCES}

    about = heading(request, c_comment)
    guid = guid_of(request.digest, sources | {"binding.h": binding(controller, exposed, about, "")})
    sources |= {"binding.h": binding(controller, exposed, about, guid)}
    gcc = compiler()
    return Code(sources, guid, None if gcc is None else shared_library(sources, UNITS, gcc))


def guid_of(digest: str, sources: dict[str, str]) -> str:
    """Return the GUID of gains and code; it changes with every byte."""
    total = hashlib.sha256(digest.encode())
    for name in sorted(sources):
        total.update(name.encode() + b"\0" + sources[name].encode() + b"\0")
    text = total.hexdigest()
    return f"{{{text[:8]}-{text[8:12]}-{text[12:16]}-{text[16:20]}-{text[20:32]}}}"


def documentation(request: Request, code: Code) -> str:
    """Return the page that simulators show for an FMU."""
    lines = "\n".join(f"<p>{line}.</p>" for line in heading(request, xml_text))
    return filled("tuner.extensions.fmi", "index.html", heading=lines, guid=code.guid)


def export(request: Request) -> Bundle:
    """Return the FMU and the SSV file, with those of the rollback."""
    mock_up, code = fmu(request)
    back, sentence = rollback_request(request)
    former, _ = fmu(back)
    return Bundle(
        files={MOCK_UP: mock_up, VALUES: parameter_values(request)},
        rollback={MOCK_UP: former, VALUES: parameter_values(back), "README.txt": f"{sentence}\n".encode()},
        held=held(request.controller, request.settings[REAL.name]),
        differences=differences(request, code),
        target_version="FMI 2.0 co-simulation, SSP 1.0",
    )


def held(controller: Controller, real: str) -> Controller:
    """Return the controller with gains in the code's real type."""
    if real == "double":
        return controller
    return replace(controller, gains=tuple(float(np.float32(gain)) for gain in controller.gains))


def differences(request: Request, code: Code) -> tuple[str, ...]:
    """Return the differences of the target."""
    controller, real = request.controller, request.settings[REAL.name]
    sentences = [
        "Gains are constants built into the code: a simulator can read them, not set or tune them; export again to change."
    ]
    if not controller.options.delay:
        sentences.append(
            "A co-simulation hands the command on at the end of the communication step, one control period of "
            f"{controller.control_period:g} s after its measurement; these gains were tuned without that delay: tune with "
            "[controller] delay = true to have it in the model."
        )
    if real == "float":
        sentences.append(
            "The code computes in single precision, as on a microcontroller; --set real=double for double."
        )
    if code.binary is None:
        sentences.append(
            "The FMU holds sources only: there is no gcc for x86-64 Linux here; build the library by the command in "
            "documentation/index.html, or export where gcc is installed."
        )
    else:
        sentences.append(f"The binary is for x86-64 Linux ({PLATFORM}) only; elsewhere build it from sources/.")
    return tuple(sentences)


TARGET = ExportTarget(
    name="fmi",
    title="FMI 2.0 co-simulation FMU and SSV, for Simulink, Dymola, OpenModelica and other simulators",
    export=export,
    options=(REAL,),
)
