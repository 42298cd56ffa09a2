"""The C99 bundle: controller, golden vectors, the program that compares them, Makefile and README."""

from dataclasses import replace

import numpy as np

from plant.backends.c_code import REALS, Real
from tuner.exchange.aboard import rollback_request
from tuner.exchange.c99.golden import golden, golden_header, golden_program
from tuner.exchange.c99.sources import c_sources
from tuner.exchange.target import Bundle, ExportTarget, Option, Request
from tuner.exchange.texts import c_comment, filled, markdown, tool
from tuner.gains import Controller

DELAYED = """\
These gains were tuned with a compute delay of one period, and the delay is in this code: a command
comes out one step after it was decided, as in the simulation. If your own loop is that late by itself, put
`state.pending` in force in place of the command."""
PROMPT = """\
None is in this code: these gains were tuned for a command that acts in the period it is decided in."""


PREFIX = "holdfast"
REAL = Option("real", "type of all numbers", ("float", "double"), "float")


def export(request: Request) -> Bundle:
    """Write the bundle, and that of the gains to go back to."""
    back, sentence = rollback_request(request)
    real = REALS[request.settings[REAL.name]]
    return Bundle(
        files(request, "These gains were tuned by holdfast."),
        files(back, sentence),
        held(request.controller, real),
        LOSSY[real.name],
        "C99",
    )


LOSSY = {
    "float": (
        "Every number is a float: constants are worked out in double precision and rounded once, to 6e-8 of their size, and "
        "every operation rounds to as much; far from the origin, positions are then known to 6e-8 of their size.",
    ),
    "double": (
        "Every number is a double, as in the simulator; a Cortex-M4F works these out in software, in some fifty times as many "
        "instructions.",
    ),
}


def held(controller: Controller, real: Real) -> Controller:
    """Return the controller whose gains are the numbers of that type nearest to the given ones."""
    return replace(controller, gains=tuple(float(real.dtype(gain)) for gain in np.array(controller.gains).tolist()))


def files(request: Request, sentence: str) -> dict[str, bytes]:
    """Write the files for a controller; sentence: what its gains are."""
    controller, real = request.controller, REALS[request.settings[REAL.name]]
    code = c_sources(controller, real.name, PREFIX, request.digest)
    vectors = golden(controller, real)
    position, attitude = controller.cascade.position.name, controller.cascade.attitude.name
    words = {
        "p": PREFIX, "P": PREFIX.upper(), "digest": c_comment(request.digest), "airframe": c_comment(controller.airframe.name),
        "laws": f"position {position}, attitude {attitude}", "tool": tool(),
    }  # fmt: skip
    readme = filled(
        "c99",
        "README.md",
        **words | {"digest": markdown(request.digest), "airframe": markdown(controller.airframe.name)},
        title=markdown(controller.airframe.title),
        sentence=markdown(sentence),
        mass=f"{controller.airframe.vehicle.mass:g}",
        position=position,
        attitude=attitude,
        period=f"{controller.control_period:g}",
        real=real.name,
        steps=len(vectors.step.inputs),
        attitude_steps=len(vectors.attitude_step.inputs),
        delay=DELAYED if controller.options.delay else PROMPT,
    )
    texts = {
        f"{code.name}.h": code.header,
        f"{code.name}.c": code.source,
        "golden.h": golden_header(vectors, real, PREFIX, words),
        "test_golden.c": golden_program(real, words),
        "Makefile": filled("c99", "Makefile", **words),
        "README.md": readme,
    }
    return {name: text.encode() for name, text in texts.items()}


TARGET = ExportTarget(
    "c99",
    "C99 source with golden vectors, for any firmware",
    export,
    options=(REAL,),
)
