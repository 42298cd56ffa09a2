"""The C99 bundle of a plant of one's own: controller, golden vectors, the program that compares them, Makefile and README."""

import hashlib
from collections.abc import Sequence
from pathlib import Path

from objectives.plant_system import PlantSystem
from plant.backends.c_code import REALS
from plant.errors import UnknownNameError
from tuner.exchange.c99.golden import differs, entry_vectors, header_text
from tuner.exchange.c99.plant_golden import plant_golden
from tuner.exchange.c99.plant_sources import c_name, channel_lines, delays, plant_code, tuned_plant
from tuner.exchange.texts import c_comment, filled, markdown, tool
from tuner.exchange.writing import write_files


def export_plant(
    system: PlantSystem, gains: Sequence[float], folder: str | Path, *, real: str = "float", name: str = "", digest: str = ""
) -> tuple[Path, ...]:  # fmt: skip
    """Write the controller of a plant's loops in C99, and return the files.

    Args:
        system: The plant with its loops and its timing.
        gains: A row in the order of `records.paths` of the loop's Gains, such as angle.kp, angle.ki.
        folder: New folder, or an empty one.
        real: Type of all numbers, "float" or "double".
        name: Before each name in the C, by default that of the plant.
        digest: Of the gains.json that the gains come from; by default of the gains' bits.

    Raises:
        InputError: The gains do not fit, or something has a name that C does not take.
        StoreError: The folder holds something already, or cannot be written.

    """
    files = plant_files(system, gains, real=real, name=name, digest=digest)
    write_files(Path(folder), files)
    return tuple(Path(folder) / each for each in files)


def plant_files(
    system: PlantSystem, gains: Sequence[float], *, real: str = "float", name: str = "", digest: str = ""
) -> dict[str, bytes]:  # fmt: skip
    """Return the files of the bundle by name; arguments and errors as `export_plant` has them."""
    if real not in REALS:
        raise UnknownNameError("type", real, REALS, key="real")
    tuned, kind, prefix = tuned_plant(system, gains), REALS[real], c_name(name or system.plant.name)
    digest = digest or hashlib.sha256(" ".join(gain.hex() for gain in tuned.gains).encode()).hexdigest()
    code, vectors = plant_code(tuned, real, prefix, digest), plant_golden(tuned, kind)
    channels = channel_lines(system.plan)
    words = {
        "p": prefix, "P": prefix.upper(), "tool": tool(), "digest": c_comment(digest), "title": c_comment(system.plant.title),
        "what": c_comment(f"plant         {system.plant.name}; {'; '.join(' '.join(line.split()) for line in channels)}"),
        **code.types,
    }  # fmt: skip
    readme = filled(
        "c99", "plant_README.md", **words | {"digest": markdown(digest), "title": markdown(system.plant.title)}, real=real,
        channels="\n".join(f"| {line.partition(' ')[0]} | {line.partition(' ')[2].strip()} |" for line in channels),
        steps=len(vectors.inputs), period=f"{tuned.period:.9g}", delays=delays(tuned),
    )  # fmt: skip
    program = filled(
        "c99", "plant_test_golden.c", **words, differs=differs(kind, words), output=tuned.Measured._fields[0]
    )
    texts = {
        f"{prefix}_controller.h": code.header,
        f"{prefix}_controller.c": code.source,
        "golden.h": header_text(*entry_vectors("", vectors, kind, prefix), kind, words),
        "test_golden.c": program,
        "Makefile": filled("c99", "Makefile", **words),
        "README.md": readme,
    }
    return {each: text.encode() for each, text in texts.items()}
