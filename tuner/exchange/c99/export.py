"""The C99 bundle: controller, golden vectors, the program that compares them, Makefile and README."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from objectives.plant_system import PlantSystem
from plant.backends.c_code import REALS, Real
from plant.errors import UnknownNameError
from tuner.exchange.aboard import plant_rollback, rollback_request
from tuner.exchange.c99.golden import differs, golden, golden_header
from tuner.exchange.c99.plant import c_name, channel_lines, delays, plant_program, tuned_plant
from tuner.exchange.c99.quadrotor import quadrotor_program
from tuner.exchange.c99.sources import Program, digest_of, write_code
from tuner.exchange.target import (
    Bundle,
    C,
    ExportBundle,
    ExportRequest,
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


Escape: TypeAlias = Callable[[str], str]
"""Writes a text into a language."""
PREFIX = "gainproof"
TUNED = "These gains were tuned by gainproof."
REAL = Option("real", "type of all numbers", ("float", "double"), "float")


def export(request: Request) -> Bundle:
    """Return the bundle of a quadrotor's controller and of its rollback."""
    return _bundle(request, *rollback_request(request), files)


def export_loops(request: PlantRequest) -> PlantBundle:
    """Return the bundle of a plant's controller and of its rollback."""

    def files_of(part: PlantRequest, about: str) -> dict[str, bytes]:
        real, given = part.settings[REAL.name], part.controller
        return plant_files(given.study.system, given.gains, real=real, digest=part.digest, sentence=about)

    return _bundle(request, *plant_rollback(request), files_of)


def _bundle(
    request: ExportRequest[C],
    back: ExportRequest[C],
    sentence: str,
    files_of: Callable[[ExportRequest[C], str], dict[str, bytes]],
) -> ExportBundle[C]:
    real = REALS[request.settings[REAL.name]]
    held = replace(request.controller, gains=as_held(request.controller.gains, real))
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
    controller, airframe = request.controller, request.controller.airframe
    position, attitude = controller.cascade.position.name, controller.cascade.attitude.name
    laws = f"position {position}, attitude {attitude}"

    def words(text: Escape) -> dict[str, object]:
        name = text(airframe.name)
        return {
            "airframe": name,
            "laws": laws,
            "what": f"airframe      {name}, laws {laws}",
            "mass": f"{airframe.vehicle.mass:g}",
            "position": position,
            "attitude": attitude,
            "period": f"{controller.control_period:g}",
            "delay": DELAYED if controller.options.delay else PROMPT,
        }

    real = REALS[request.settings[REAL.name]]
    return bundle_files(quadrotor_program(controller), words, real, PREFIX, request.digest, sentence)


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
        digest: Digest of the gains.json that the gains come from; by default of the gains' bits.
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
    lines = channel_lines(system.plan)

    def words(text: Escape) -> dict[str, object]:
        what = f"plant         {system.plant.name}; {'; '.join(' '.join(line.split()) for line in lines)}"
        return {
            "what": text(what),
            "output": tuned.Measured._fields[0],
            "channels": "\n".join(f"| {line.partition(' ')[0]} | {line.partition(' ')[2].strip()} |" for line in lines),
            "period": f"{tuned.period:.9g}",
            "delays": delays(tuned),
        }

    return bundle_files(plant_program(tuned), words, kind, prefix, digest, sentence)


def export_plant(
    system: PlantSystem,
    gains: Sequence[float],
    folder: str | Path,
    *,
    real: str = "float",
    name: str = "",
) -> tuple[Path, ...]:
    """Write a plant's controller into a new folder, and return the files.

    Arguments are as of `plant_files`.

    Raises:
        InputError: The gains do not fit, or something has a name that C does not take.
        StoreError: The folder holds something already, or cannot be written.
    """
    files = plant_files(system, gains, real=real, name=name)
    write_files(Path(folder), files)
    return tuple(Path(folder) / each for each in files)


def bundle_files(
    program: Program,
    words_in: Callable[[Escape], dict[str, object]],
    real: Real,
    prefix: str,
    digest: str,
    sentence: str,
) -> dict[str, bytes]:
    """Return the content of each file of a bundle, by name.

    Args:
        program: The controller.
        words_in: Return the words of its templates in a language.
        real: Type of all numbers.
        prefix: Prefix in front of all names.
        digest: Digest of the gains.
        sentence: About the gains.
    """
    code, vectors = write_code(program, real.name, prefix, digest), golden(program, real)

    def words(text: Escape) -> dict[str, object]:
        named = {"p": prefix, "P": prefix.upper(), "tool": tool(), "real": real.name, **code.types}
        return {**named, "digest": text(digest), "title": text(program.title), **words_in(text)}

    in_c, kind = words(c_comment), program.templates
    about = {"sentence": markdown(sentence), **{f"{name}s": len(each.inputs) for name, each in vectors.items()}}
    texts = {
        f"{code.name}.h": code.header,
        f"{code.name}.c": code.source,
        "golden.h": golden_header(vectors, real, prefix, in_c),
        "test_golden.c": filled("tuner.exchange.c99", f"{kind}test_golden.c", **in_c, differs=differs(real, in_c)),
        "Makefile": filled("tuner.exchange.c99", "Makefile", **in_c),
        "README.md": filled("tuner.exchange.c99", f"{kind}README.md", **words(markdown), **about),
    }
    return {name: text.encode() for name, text in texts.items()}


TARGET = ExportTarget(
    "c99",
    "C99 source with golden vectors, for any firmware",
    export,
    options=(REAL,),
    export_plant=export_loops,
)
