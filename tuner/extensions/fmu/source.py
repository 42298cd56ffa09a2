"""FMUs as a source of plants: named by the user, read for a study, and described without one."""

from functools import partial
from pathlib import Path
from typing import Any

from plant.model.plant_model import PlantRecords
from tuner.extensions.fmu.archive import open_archive
from tuner.extensions.fmu.description import INPUT, OUTPUT, PARAMETER
from tuner.extensions.fmu.fmu_model import looked_at, read_fmu
from tuner.extensions.fmu.system import FmuSystem
from tuner.study.own_code import PlantSource, SystemMaker
from tuner.study.plant_schema import PlantTable


def read(file: Path, table: PlantTable, study: Path) -> tuple[PlantRecords, str, SystemMaker]:
    """Return plant, digest and system class of a study's FMU."""
    plant = read_fmu(file, table.disturbances, table.states, table.units, study)
    return plant, plant.interface.digest, partial(FmuSystem, patience=table.patience)


def describe(file: Path) -> dict[str, Any]:
    """Return the names in an FMU, of which nothing runs.

    Raises InputError where it cannot be used on this machine.
    """
    archive, description = looked_at(file)
    by_reference = {each.reference: each for each in reversed(description.variables)}
    groups = {
        f"{role}s": {each.name: each.unit or "(no unit)" for each in description.variables if each.role == role}
        for role in (INPUT, OUTPUT, PARAMETER)
    }
    states = [by_reference[reference].name for reference in description.states if reference in by_reference]
    return {
        "kind": "fmu",
        "file": str(file),
        "title": description.title or description.model,
        "fmi": description.version,
        **groups,
        "states": states,
        "directional_derivatives": "yes" if description.directional else "no",
        "digest": archive.digest,
    }


SOURCE = PlantSource(open_archive, read, describe)
