"""modelDescription.xml of FMI 2.0: what a simulator reads of the FMU before it loads it.

Signals change at control instants only (variability discrete). Gains are constants: their step-independent parts are worked out
at export and built into the code, so that what runs is bit for bit the C code.

Next to it the gains as an SSV file (System Structure and Parameterization 1.0, Modelica Association, 2019).

SSP defines a unit by whole exponents of SI base units; the one of a super-twisting gain has fractions, so that gain stands
without a unit and its description names it.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from tuner.exchange.target import Request
from tuner.exchange.texts import heading, xml_text
from tuner.extensions.fmi.variables import FmuVariable, base_unit

HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


def element(name: str, attributes: Mapping[str, object] = {}, children: Iterable[str] = ()) -> str:  # noqa: B006
    """Return an element; children: elements as text, one after the other."""
    given = "".join(f' {key}="{xml_text(_text(value))}"' for key, value in attributes.items())
    inner = "\n".join(children)
    if not inner:
        return f"<{name}{given}/>"
    indented = "\n".join(f"  {line}" for line in inner.split("\n"))
    return f"<{name}{given}>\n{indented}\n</{name}>"


def document(root: str) -> bytes:
    """Return a whole file."""
    return (HEAD + root + "\n").encode()


def _text(value: object) -> str:
    """Return a value as XML text; numbers read back to the same bits."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(float(value)) if isinstance(value, float) else str(value)


IDENTIFIER = "gainproof_controller"


class ModelText(NamedTuple):
    """Name and description of an FMU, and its control period [s]."""

    name: str
    description: str
    period: float


def quadrotor_text(request: Request) -> ModelText:
    """Return the texts of a quadrotor's controller."""
    cascade = request.controller.cascade
    name = f"Quadrotor controller: {cascade.position.name} on position, {cascade.attitude.name} on attitude"
    return ModelText(name, " ".join(f"{line}." for line in heading(request, str)), request.controller.control_period)


def model_description(model: ModelText, exposed: Sequence[FmuVariable], guid: str, sources: Sequence[str]) -> bytes:
    """Return modelDescription.xml; sources: names of the C files to compile."""
    return document(
        element(
            "fmiModelDescription",
            {
                "fmiVersion": "2.0",
                "modelName": model.name,
                "guid": guid,
                "description": model.description,
                "generationTool": "gainproof",
                "variableNamingConvention": "structured",
                "numberOfEventIndicators": 0,
            },
            [
                _co_simulation(sources),
                element("UnitDefinitions", {}, [_unit(unit) for unit in units_of(exposed)]),
                element("LogCategories", {}, [element("Category", {"name": "logStatusError"})]),
                element("DefaultExperiment", {"startTime": 0.0, "stepSize": model.period}),
                element("ModelVariables", {}, [_variable(i, entry) for i, entry in enumerate(exposed)]),
                _structure(exposed),
            ],
        )
    )


def units_of(exposed: Sequence[FmuVariable]) -> list[str]:
    """Return the units that occur, in the order of their first use."""
    return list(dict.fromkeys(entry.unit for entry in exposed))


def _co_simulation(sources: Sequence[str]) -> str:
    return element(
        "CoSimulation",
        {
            "modelIdentifier": IDENTIFIER,
            "needsExecutionTool": False,
            "canHandleVariableCommunicationStepSize": False,
            "canInterpolateInputs": False,
            "canBeInstantiatedOnlyOncePerProcess": False,
            "canNotUseMemoryManagementFunctions": False,
            "canGetAndSetFMUstate": True,
            "canSerializeFMUstate": True,
        },
        [element("SourceFiles", {}, [element("File", {"name": name}) for name in sources])],
    )


def _unit(unit: str) -> str:
    base = base_unit(unit)
    return element("Unit", {"name": unit}, [] if base is None else [element("BaseUnit", base)])


def _variable(reference: int, entry: FmuVariable) -> str:
    kind = {
        "input": {"causality": "input", "variability": "discrete"},
        "output": {"causality": "output", "variability": "discrete", "initial": "calculated"},
        "constant": {"causality": "local", "variability": "constant", "initial": "exact"},
    }[entry.kind]
    start = {} if entry.kind == "output" else {"start": entry.start}
    about = {"name": entry.name, "valueReference": reference, "description": entry.about}
    return element("ScalarVariable", about | kind, [element("Real", {"unit": entry.unit} | start)])


def _structure(exposed: Sequence[FmuVariable]) -> str:
    """Return outputs and what is worked out at initialization; the outputs of a step depend on all inputs and on the past."""
    outputs = [i + 1 for i, entry in enumerate(exposed) if entry.kind == "output"]
    return element(
        "ModelStructure",
        {},
        [
            element("Outputs", {}, [element("Unknown", {"index": i}) for i in outputs]),
            element("InitialUnknowns", {}, [element("Unknown", {"index": i, "dependencies": ""}) for i in outputs]),
        ],
    )


SPACES = {
    "xmlns:ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "xmlns:ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
}


def parameter_values(gains: Sequence[FmuVariable], description: str) -> bytes:
    """Return the SSV file of gains; names are those of the FMU's constants."""
    parameters = []
    for gain in gains:
        unit = {} if base_unit(gain.unit) is None else {"unit": gain.unit}
        about = {"name": gain.name, "description": f"{gain.about} [{gain.unit}]"}
        parameters.append(element("ssv:Parameter", about, [element("ssv:Real", {"value": gain.start} | unit)]))
    derived = [(unit, base) for unit in units_of(gains) if (base := base_unit(unit)) is not None]
    units = [element("ssc:Unit", {"name": unit}, [element("ssc:BaseUnit", base)]) for unit, base in derived]
    return document(
        element(
            "ssv:ParameterSet",
            SPACES
            | {
                "version": "1.0",
                "name": "gains",
                "description": description,
                "generationTool": "gainproof",
            },
            [element("ssv:Parameters", {}, parameters), element("ssv:Units", {}, units)],
        )
    )
