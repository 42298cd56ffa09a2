"""Plants of one's own, from a module or a notebook's cell: their loops as a system that is flown, judged and exported."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from objectives.plant_system import PlantSystem
from plant.errors import InputError
from plant.input_files import read_input, read_input_text
from plant.laws import LAWS
from plant.model.plan import Actuator, Channel, plan_loop
from plant.model.plant_model import plant_from
from tuner.api.frames import Documented
from tuner.exchange.c99.plant_export import export_plant
from tuner.store.advice import RECORD
from tuner.store.inputs import read_record
from tuner.study.kinds import load_any, of_another_kind
from tuner.study.plant_study import PlantStudy, plant_timing
from tuner.study.tuned_loops import read_plant_row

__all__ = ["LAWS", "Actuator", "Channel", "PlantSystem", "export_plant", "plant_system"]


def plant_system(
    names: Mapping[str, Any],
    name: str,
    channels: Sequence[Channel],
    actuators: Sequence[Actuator] = (),
    *,
    control_period: float,
    plant_step: float | None = None,
) -> PlantSystem:
    """Close the loops of the plant that names describe, as a study would; `make_study` makes a study of tables beside them.

    Args:
        names: State, Input, Parameters, Output, derivative and output, such as `globals()` of a notebook.
        name: Of the plant.
        channels: Its loops.
        actuators: Limits, rate, delay and lag of its inputs.
        control_period: [s].
        plant_step: [s], by default the longest that is accurate at rest.

    Raises:
        InputError: The plant or its loops do not fit together; the message has the line.

    """
    plant = plant_from(names, name, str(names.get("__file__", "")))
    plan = plan_loop(plant, channels, actuators)
    timing = plant_timing(plant, plan.actuators, plant.parameters, control_period, plant_step)
    return PlantSystem(plant, plan, plant.parameters, timing)


C99, PRECISION = "c99", "precision"
PRECISIONS = ("float", "double")


@dataclass(frozen=True)
class ExportedPlant(Documented):
    """Controller of a plant in C99. folder: of the files; precision: "float" or "double"."""

    folder: Path
    files: tuple[str, ...]
    precision: str

    @property
    def passed(self) -> bool:
        """True: the C computes what flew, so nothing is rounded but the numbers themselves."""
        return True

    @property
    def document(self) -> dict[str, Any]:
        """Everything as data."""
        return {"folder": str(self.folder), "files": list(self.files), "precision": self.precision}


def study_of(gains: Path) -> PlantStudy:
    """Return the study of the results folder that a plant's gains.json lies in.

    Raises InputError where it lies in none, or where the code of the plant, which the folder may not run, has not been named.
    """
    home = gains.resolve().parent
    if not (home / RECORD).exists():
        raise InputError(
            f"lies in no results folder, whose {RECORD} names the study; give that of a results folder", file=gains
        )
    study = load_any(home / read_record(home).study)
    if not isinstance(study, PlantStudy):
        raise of_another_kind(study.kind, study.path, "gains of a plant of one's own")
    return study


def export_run(gains: Path, target: str, folder: Path | None, options: Mapping[str, str], force: bool) -> ExportedPlant:
    """Write the controller of a run of a plant, whose gains.json is given, in C99.

    Raises InputError where the file is of no results folder, the target is another, nothing was feasible, or the code of the
    plant is not named, for its folder may not run it.
    """
    if target != C99:
        raise InputError(f"given {target}; plants of one's own are written in {C99}: --to {C99}", key="--to")
    for name, value in options.items():
        if name != PRECISION or value not in PRECISIONS:
            raise InputError(f"given {name} = {value}; allowed: {PRECISION} = {' or '.join(PRECISIONS)}", key="--set")
    document, home = json.loads(read_input_text(gains)), gains.resolve().parent
    study = study_of(gains)
    if not (force or document.get("study", {}).get("feasible", True)):
        raise InputError("nothing in this run was feasible; --force writes these gains all the same", file=gains)
    row = read_plant_row(gains, study.system).tolist()
    precision, out = str(options.get(PRECISION, "float")), folder or home / "export" / C99
    digest = hashlib.sha256(read_input(gains)).hexdigest()
    files = export_plant(study.system, row, out, real=precision, digest=digest)
    return ExportedPlant(out, tuple(file.name for file in files), precision)
