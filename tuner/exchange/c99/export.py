"""The C99 bundle: controller, golden vectors, the program that compares them, Makefile and README."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from objectives.plant_system import PlantSystem
from plant.backends.c_code import REALS, Real
from plant.errors import UnknownNameError
from tuner.exchange.aboard import plant_rollback, rollback_request
from tuner.exchange.c99.golden import differs, entry_vectors, golden, golden_header, header_text
from tuner.exchange.c99.plant_golden import plant_golden
from tuner.exchange.c99.plant_sources import c_name, channel_lines, delays, plant_code, tuned_plant
from tuner.exchange.c99.sources import Code, c_sources, digest_of
from tuner.exchange.target import (
    Bundle,
    ExportBundle,
    ExportTarget,
    Option,
    PlantBundle,
    PlantRequest,
    Request,
)
from tuner.exchange.texts import c_comment, filled, markdown, tool
from tuner.exchange.writing import write_files

DELAYED = """\
These gains were tuned with a compute delay of one period, and the delay is in this code: a command
comes out one step after it was decided, as in the simulation. If your own loop is that late by itself, put
`state.pending` in force in place of the command."""
PROMPT = """\
None is in this code: these gains were tuned for a command that acts in the period it is decided in."""


PREFIX = "holdfast"
TUNED = "These gains were tuned by holdfast."
REAL = Option("real", "type of all numbers", ("float", "double"), "float")


def export(request: Request) -> Bundle:
    """Return the bundle of a quadrotor's controller, and that of the gains to go back to."""
    back, sentence = rollback_request(request)
    real = REALS[request.settings[REAL.name]]
    held = replace(request.controller, gains=as_held(request.controller.gains, real))
    return ExportBundle(files(request, TUNED), files(back, sentence), held, LOSSY[real.name], "C99")


def export_loops(request: PlantRequest) -> PlantBundle:
    """Return the bundle of a plant's controller, and that of the gains to go back to."""
    back, sentence = plant_rollback(request)
    real = REALS[request.settings[REAL.name]]
    held = replace(request.controller, gains=as_held(request.controller.gains, real))

    def files_of(part: PlantRequest, about: str) -> dict[str, bytes]:
        given = part.controller
        return plant_files(given.study.system, given.gains, real=real.name, digest=part.digest, sentence=about)

    return ExportBundle(files_of(request, TUNED), files_of(back, sentence), held, LOSSY[real.name], "C99")


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


def as_held(gains: Sequence[float], real: Real) -> tuple[float, ...]:
    """Return the numbers of that type nearest to gains."""
    return tuple(float(real.dtype(gain)) for gain in np.array(gains).tolist())


def files(request: Request, sentence: str) -> dict[str, bytes]:
    """Write the files for a controller; sentence: what its gains are."""
    controller, real = request.controller, REALS[request.settings[REAL.name]]
    code = c_sources(controller, real.name, PREFIX, request.digest)
    vectors = golden(controller, real)
    position, attitude = controller.cascade.position.name, controller.cascade.attitude.name
    words = {
        "p": PREFIX,
        "P": PREFIX.upper(),
        "digest": c_comment(request.digest),
        "airframe": c_comment(controller.airframe.name),
        "laws": f"position {position}, attitude {attitude}",
        "tool": tool(),
    }
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
    program = filled("c99", "test_golden.c", **words, differs=differs(real, words))
    return bundle_files(code, golden_header(vectors, real, PREFIX, words), program, readme, words)


def plant_files(
    system: PlantSystem,
    gains: Sequence[float],
    *,
    real: str = "float",
    name: str = "",
    digest: str = "",
    sentence: str = TUNED,
) -> dict[str, bytes]:
    """Write the files for a plant's loops.

    Args:
        system: The plant with its loops and its timing.
        gains: A row in the order of `records.paths` of the loop's Gains, such as angle.kp, angle.ki.
        real: Type of all numbers, "float" or "double".
        name: Before each name in the C, by default that of the plant.
        digest: Of the gains.json that the gains come from; by default of the gains' bits.
        sentence: About the gains.

    Returns:
        Content of each file, by name.

    Raises:
        InputError: The gains do not fit, or something has a name that C does not take.

    """
    if real not in REALS:
        raise UnknownNameError("type", real, REALS, key="real")
    tuned, kind, prefix = tuned_plant(system, gains), REALS[real], c_name(name or system.plant.name)
    digest = digest or digest_of(tuned.gains)
    code, vectors = plant_code(tuned, real, prefix, digest), plant_golden(tuned, kind)
    channels = channel_lines(system.plan)
    words = {
        "p": prefix,
        "P": prefix.upper(),
        "tool": tool(),
        "digest": c_comment(digest),
        "title": c_comment(system.plant.title),
        "what": c_comment(
            f"plant         {system.plant.name}; {'; '.join(' '.join(line.split()) for line in channels)}"
        ),
        **code.types,
    }
    readme = filled(
        "c99",
        "plant_README.md",
        **words | {"digest": markdown(digest), "title": markdown(system.plant.title)},
        real=real,
        channels="\n".join(f"| {line.partition(' ')[0]} | {line.partition(' ')[2].strip()} |" for line in channels),
        steps=len(vectors.inputs),
        period=f"{tuned.period:.9g}",
        delays=delays(tuned),
        sentence=markdown(sentence),
    )
    program = filled(
        "c99", "plant_test_golden.c", **words, differs=differs(kind, words), output=tuned.Measured._fields[0]
    )
    header = header_text(*entry_vectors("", vectors, kind, prefix), kind, words)
    return bundle_files(code, header, program, readme, words)


def export_plant(
    system: PlantSystem,
    gains: Sequence[float],
    folder: str | Path,
    *,
    real: str = "float",
    name: str = "",
) -> tuple[Path, ...]:
    """Write the controller of a plant's loops into a new folder, and return the files; arguments as of `plant_files`.

    Raises:
        InputError: The gains do not fit, or something has a name that C does not take.
        StoreError: The folder holds something already, or cannot be written.

    """
    files = plant_files(system, gains, real=real, name=name)
    write_files(Path(folder), files)
    return tuple(Path(folder) / each for each in files)


def bundle_files(code: Code, golden: str, program: str, readme: str, words: dict[str, str]) -> dict[str, bytes]:
    """Return the content of each file of a bundle, by name."""
    texts = {
        f"{code.name}.h": code.header,
        f"{code.name}.c": code.source,
        "golden.h": golden,
        "test_golden.c": program,
        "Makefile": filled("c99", "Makefile", **words),
        "README.md": readme,
    }
    return {name: text.encode() for name, text in texts.items()}


TARGET = ExportTarget(
    "c99",
    "C99 source with golden vectors, for any firmware",
    export,
    options=(REAL,),
    export_plant=export_loops,
)
