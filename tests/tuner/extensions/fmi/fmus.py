"""What the tests of the FMU share: requests, inputs of a real flight, the C99 code called directly."""

import ctypes
import json
import subprocess
from pathlib import Path

from plant.law_registry import law
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions
from tests.clients import program
from tuner.exchange.c99.quadrotor import c_sources
from tuner.exchange.target import Request
from tuner.extensions.processor_cost.inputs import step_row, typical_inputs
from tuner.gains import Controller

PERIOD = 0.002
DIGEST = "0123456789abcdef" * 4
STEP_INPUTS, STEP_OUTPUTS = 32, 8


def controller(attitude="hybrid", *, delay=False, period=PERIOD, factor=1.0) -> Controller:
    """Return the default gains times a factor."""
    cascade = close_cascade(law("ladrc"), law(attitude))
    gains = tuple(factor * gain for gain in default_row(cascade))
    return Controller(load("hummingbird"), cascade, ControlOptions(delay=delay), period, 0.001, gains)


def request(real="float", digest=DIGEST, **changes) -> Request:
    return Request(controller(**changes), digest, {"real": real})


def flight(of: Controller) -> list[list[float]]:
    """Return the inputs of 1000 steps."""
    rows = [list(map(float, step_row(instant))) for instant in typical_inputs(of)]
    assert len(rows) == 1000
    return rows


def write_inputs(path: Path, rows: list[list[float]]) -> Path:
    path.write_text(json.dumps(rows))
    return path


def c_outputs(of: Controller, rows: list[list[float]], real: str, folder: Path) -> list[list[str]]:
    """Return the outputs of the C99 code, called directly, as hexadecimal text: rotor thrusts, thrust, torque."""
    code = c_sources(of, real, "own")
    (folder / "own_controller.h").write_text(code.header)
    (folder / "own_controller.c").write_text(code.source)
    command = [
        program("gcc"),
        "-std=c99",
        "-O1",
        "-ffp-contract=off",
        "-fPIC",
        "-shared",
        "own_controller.c",
        "-o",
        "own.so",
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    library = ctypes.CDLL(str(folder / "own.so"))
    number = ctypes.c_float if real == "float" else ctypes.c_double
    state, out = ctypes.create_string_buffer(4096), (number * STEP_OUTPUTS)()
    references = [(number * 14)(*row[:14]) for row in rows]
    measurements = [(number * 18)(*row[14:]) for row in rows]
    assert library.own_init(state, measurements[0]) == 0
    found = []
    for reference, measurement in zip(references, measurements, strict=True):
        assert library.own_step(state, reference, measurement, out) == 0
        found.append([float(value).hex() for value in out])
    return found


# Steps an FMU through rows of inputs; HEAD is in front of every script that FMPy runs.
HEAD = """
import json, sys, tempfile
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

folder = extract(sys.argv[1])
about = read_model_description(sys.argv[1])
inputs = [v.valueReference for v in about.modelVariables if v.causality == "input"]
outputs = [v.valueReference for v in about.modelVariables if v.causality == "output"]
period = float(about.defaultExperiment.stepSize)


def instance(name, guid=about.guid):
    one = FMU2Slave(guid=guid, unzipDirectory=folder, instanceName=name,
                    modelIdentifier=about.coSimulation.modelIdentifier)
    one.instantiate()
    return one


def begin(one, row, start=0.0):
    one.setupExperiment(startTime=start)
    one.enterInitializationMode()
    one.setReal(inputs, row)
    one.exitInitializationMode()


def step(one, k, row, start=0.0):
    one.setReal(inputs, row)
    one.doStep(start + k * period, period)
    return [value.hex() for value in one.getReal(outputs)]


def refused(call, *arguments):
    try:
        call(*arguments)
    except Exception as error:
        return type(error).__name__
    return ""

rows = json.load(open(sys.argv[2])) if len(sys.argv) > 2 else []
"""
