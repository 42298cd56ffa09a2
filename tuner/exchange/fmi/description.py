"""modelDescription.xml of FMI 2.0: what a simulator reads of the FMU before it loads it.

Signals change at control instants only (variability discrete). Gains are constants: their step-independent parts are worked out
at export and built into the code, so that what runs is bit for bit the C code.
"""

from collections.abc import Sequence

from tuner.exchange.exporter import Request
from tuner.exchange.fmi.units import base_unit
from tuner.exchange.fmi.variables import Variable
from tuner.exchange.fmi.xml import document, element
from tuner.exchange.heading import heading

IDENTIFIER = "holdfast_controller"


def model_description(request: Request, found: Sequence[Variable], guid: str, sources: Sequence[str]) -> bytes:
    """Return modelDescription.xml; sources: names of the C files to compile."""
    controller = request.controller
    laws = f"{controller.cascade.position.name} on position, {controller.cascade.attitude.name} on attitude"
    return document(
        element(
            "fmiModelDescription",
            {
                "fmiVersion": "2.0",
                "modelName": f"Quadrotor controller: {laws}",
                "guid": guid,
                "description": " ".join(f"{line}." for line in heading(request, str)),
                "generationTool": "holdfast",
                "variableNamingConvention": "structured",
                "numberOfEventIndicators": 0,
            },
            [
                _co_simulation(sources),
                element("UnitDefinitions", {}, [_unit(unit) for unit in units_of(found)]),
                element("LogCategories", {}, [element("Category", {"name": "logStatusError"})]),
                element("DefaultExperiment", {"startTime": 0.0, "stepSize": controller.control_period}),
                element("ModelVariables", {}, [_variable(i, entry) for i, entry in enumerate(found)]),
                _structure(found),
            ],
        )
    )


def units_of(found: Sequence[Variable]) -> list[str]:
    """Return the units that occur, in the order of their first use."""
    return list(dict.fromkeys(entry.unit for entry in found))


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


def _variable(reference: int, entry: Variable) -> str:
    kind = {
        "input": {"causality": "input", "variability": "discrete"},
        "output": {"causality": "output", "variability": "discrete", "initial": "calculated"},
        "constant": {"causality": "local", "variability": "constant", "initial": "exact"},
    }[entry.kind]
    start = {} if entry.kind == "output" else {"start": entry.start}
    about = {"name": entry.name, "valueReference": reference, "description": entry.about}
    return element("ScalarVariable", about | kind, [element("Real", {"unit": entry.unit} | start)])


def _structure(found: Sequence[Variable]) -> str:
    """Return outputs and what is worked out at initialization; the outputs of a step depend on all inputs and on the past."""
    outputs = [i + 1 for i, entry in enumerate(found) if entry.kind == "output"]
    return element(
        "ModelStructure",
        {},
        [
            element("Outputs", {}, [element("Unknown", {"index": i}) for i in outputs]),
            element("InitialUnknowns", {}, [element("Unknown", {"index": i, "dependencies": ""}) for i in outputs]),
        ],
    )
