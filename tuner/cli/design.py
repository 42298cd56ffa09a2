"""`tuner design`: gains from requirements on the loops, before any search, beside the defaults."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from objectives.margins.quantities import REPORTED
from objectives.margins.trim import Trim
from plant.errors import StoreError
from plant.gains import gain_addresses
from tuner.analysis.margins.document import default_requirements, margins_document
from tuner.analysis.margins.readings import subject_of
from tuner.cli.margins import announce_compilation, heading, mark, marks_of, reading
from tuner.cli.tables import Table, say_files
from tuner.cli.terminal import Console
from tuner.experiments.tuning.starts import design_row, study_designs, without_design
from tuner.gains import Controller, to_document
from tuner.gains.document import seed_entry
from tuner.gains.ucum import quantity
from tuner.study import load_study
from tuner.study.margins import holds_place
from tuner.study.study import Study

Row = dict[str, Any]


def design_command(path: Path, out: Path, as_json: bool) -> None:
    """Design, write gains.json and print both controllers' margins."""
    if out.exists():
        raise StoreError(f"{out} exists already and was not touched; choose another file with --out")
    study = load_study(path)
    designs = study_designs(study)
    row = design_row(study, designs)
    controllers = {
        name: controller_for(study, gains) for name, gains in (("default", study.default_row), ("design", row))
    }
    warnings = [*without_design(designs), *differing(study, row)]
    axes = [
        {
            "axis": axis, "designed": found.designed, "why": found.why,
            "load_rejection": {"value": found.load_rejection, "unit": "s^-3"} if found.designed else None,
        }
        for axis, found in designs.items()
    ]  # fmt: skip
    announce_compilation()
    margins = {name: judged(study, controller) for name, controller in controllers.items()}
    document = to_document(controllers["design"], provenance_of(study, axes))
    write(out, document)
    if as_json:
        result = {"gains": document, "design": axes, "margins": margins, "warnings": warnings}
        print(json.dumps(result, indent=2, allow_nan=False))
        return
    console = Console()
    console.print(gains_table(controllers))
    console.print(margins_table(margins))
    for warning in warnings:
        console.print(f"Warning: {warning}", style="yellow", highlight=False)
    say_files(console, Gains=out)


def provenance_of(study: Study, axes: list[Row]) -> Row:
    """Return what gains.json says of the origin of a design."""
    origin = {
        "name": study.path.name, "title": study.title, "seed": seed_entry(study.seed), "digest": study.digest(),
        "point": "design",
    }  # fmt: skip
    coded = [{**row, "load_rejection": row["load_rejection"] and quantity(**row["load_rejection"])} for row in axes]
    return {"study": origin, "design": coded}


def controller_for(study: Study, gains: np.ndarray) -> Controller:
    """Return a controller of a study with a gains row."""
    system = study.system
    timing = system.timing
    row = tuple(float(gain) for gain in gains)
    return Controller(
        study.airframe, system.cascade, study.options, timing.control_period, timing.plant_step, row, study.vehicle
    )


def differing(study: Study, row: np.ndarray) -> list[str]:
    """Return a sentence on what the nearest point of the study's space cannot take from a design."""
    nearest = study.space.gains(study.space.point(row)[None])[0]
    off = [
        gain.address for gain in gain_addresses(study.system.cascade)
        if abs(nearest[gain.column] - row[gain.column]) > 1e-6 * abs(row[gain.column])
    ]  # fmt: skip
    if not off:
        return []
    return [
        f"A search of this study starts from the nearest point that it can reach, which has other values of {', '.join(off)}."
    ]


def judged(study: Study, controller: Controller) -> Row:
    """Return the margins of a controller as `tuner margins` has them; in attitude mode where all scenarios fly in it."""
    specs = tuple(entry.spec for entry in study.scenarios)
    subject = subject_of(controller, Trim(hold=holds_place(specs, study.system.timing)))
    return margins_document(subject, default_requirements(subject))


def write(path: Path, document: Row) -> None:
    """Write the file; what is there is never overwritten."""
    text = json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise StoreError(f"{path} exists already and was not touched; choose another file with --out") from None
    except OSError as error:
        raise StoreError(f"{path} cannot be written ({error.strerror})") from None


def gains_table(controllers: dict[str, Controller]) -> Table:
    """Return the gains of default and design, axis by axis."""
    table = Table("Gains")
    table.add_column("gain", no_wrap=True)
    for name in controllers:
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("unit", no_wrap=True)
    first = next(iter(controllers.values()))
    for gain in gain_addresses(first.cascade):
        table.add_row(gain.address, *[f"{c.gains[gain.column]:.4g}" for c in controllers.values()], gain.unit)
    return table


def margins_table(margins: dict[str, Row]) -> Table:
    """Return default over design in each loop; broken limits are marked with !, missed targets with ~."""
    default, design = margins["default"], margins["design"]
    table = Table("Margins: default, then design", keys=2)
    table.add_column("", no_wrap=True)
    table.add_column("", no_wrap=True)
    for channel in default["channels"]:
        table.add_column(channel["channel"], justify="right", no_wrap=True)
    marks = {name: marks_of(document["requirements"]) for name, document in margins.items()}
    for name in REPORTED:
        for who, document in (("default", default), ("design", design)):
            cells = [
                mark(reading(c["quantities"][name], name), marks[who].get((c["channel"], name)))
                for c in document["channels"]
            ]  # fmt: skip
            table.add_row(heading(name) if who == "default" else "", who, *cells)
    return table
