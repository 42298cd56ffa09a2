"""FMI 2.0 for co-simulation: the C99 code of the controller in an FMU, and the gains next to it as SSV.

Functional Mock-up Interface 2.0.4 (Modelica Association, 2022). The FMU holds its sources, so it can be built for other
platforms; where gcc for x86-64 Linux is there, the binary is inside.
"""

from dataclasses import replace

from plant.backends.c_code import REALS
from tuner.exchange.aboard import rollback_request
from tuner.exchange.c99.export import as_held
from tuner.exchange.c99.quadrotor import c_sources
from tuner.exchange.target import Bundle, ExportTarget, Request
from tuner.exchange.texts import c_comment, filled, heading, xml_text
from tuner.extensions.fmi.archive import (
    BUILT_IN,
    MOCK_UP,
    PREFIX,
    REAL,
    SINGLE,
    UNITS,
    VALUES,
    VERSION,
    Code,
    built,
    of_binary,
    packed,
)
from tuner.extensions.fmi.code import binding
from tuner.extensions.fmi.plant_export import export_loops
from tuner.extensions.fmi.variables import gain_variables, variables
from tuner.extensions.fmi.xml_files import model_description, parameter_values, quadrotor_text
from tuner.gains import Controller

AXES = "World axes are ENU, body axes FLU, all numbers SI."


def fmu(request: Request) -> tuple[bytes, Code]:
    """Return the FMU of a request and the code in it."""
    code = code_of(request)
    exposed = variables(request.controller)
    description = model_description(quadrotor_text(request), exposed, code.guid, UNITS)
    return packed(code, description, gain_values(request), documentation(request, code)), code


def gain_values(request: Request) -> bytes:
    """Return the SSV file of a quadrotor's gains."""
    return parameter_values(gain_variables(request.controller), quadrotor_text(request).description)


def code_of(request: Request) -> Code:
    """Write the sources of an FMU and compile them where possible."""
    controller = request.controller
    exposed = variables(controller)
    generated = c_sources(controller, request.settings[REAL.name], PREFIX, request.digest)
    about = heading(request, c_comment)
    return built(generated, request.digest, lambda guid: binding(controller, exposed, about, guid))


def documentation(request: Request, code: Code) -> str:
    """Return the page that simulators show for an FMU."""
    lines = "\n".join(f"<p>{line}.</p>" for line in heading(request, xml_text))
    return filled(
        "tuner.extensions.fmi", "index.html", title="Quadrotor controller", axes=AXES, heading=lines, guid=code.guid
    )


def export(request: Request) -> Bundle:
    """Return the FMU and the SSV file, with those of the rollback."""
    mock_up, code = fmu(request)
    back, sentence = rollback_request(request)
    former, _ = fmu(back)
    return Bundle(
        files={MOCK_UP: mock_up, VALUES: gain_values(request)},
        rollback={MOCK_UP: former, VALUES: gain_values(back), "README.txt": f"{sentence}\n".encode()},
        held=held(request.controller, request.settings[REAL.name]),
        differences=differences(request, code),
        target_version=VERSION,
    )


def held(controller: Controller, real: str) -> Controller:
    """Return the controller with gains in the code's real type."""
    return replace(controller, gains=as_held(controller.gains, REALS[real]))


def differences(request: Request, code: Code) -> tuple[str, ...]:
    """Return the differences of the target."""
    controller, real = request.controller, request.settings[REAL.name]
    sentences = [BUILT_IN]
    if not controller.options.delay:
        sentences.append(
            "A co-simulation hands the command on at the end of the communication step, one control period of "
            f"{controller.control_period:g} s after its measurement; these gains were tuned without that delay: tune with "
            "[controller] delay = true to have it in the model."
        )
    if real == "float":
        sentences.append(SINGLE)
    sentences.append(of_binary(code))
    return tuple(sentences)


TARGET = ExportTarget(
    name="fmi",
    title="FMI 2.0 co-simulation FMU and SSV, for Simulink, Dymola, OpenModelica and other simulators",
    export=export,
    options=(REAL,),
    export_plant=export_loops,
)
