"""Design gains from requirements on the loops, before any search."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.margins.trim import Trim
from plant.gains import gain_addresses
from tuner.analysis.margins.document import default_requirements, margins_document
from tuner.analysis.margins.readings import subject_of
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import Gains, gains_of, taken
from tuner.api.margins import announce_compilation
from tuner.api.plant_designing import PlantDesign, design_plant
from tuner.api.studies import StudyLike, gains_study
from tuner.documents.margins import MarginsDocument
from tuner.documents.parts import NumberWithUnit
from tuner.experiments.tuning.starts import design_row, study_designs, without_design
from tuner.gains import Controller
from tuner.gains.quantities import quantity
from tuner.search.watcher import Watcher
from tuner.store.document import DocumentPart
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study
from tuner.study.trim import holds_place

if TYPE_CHECKING:
    import pandas as pd

Row = dict[str, Any]


class DesignedAxis(DocumentPart):
    """Design of an axis; why: not, where it is not; load_rejection [s^-3]: null where it is not."""

    axis: str
    designed: bool
    why: str
    load_rejection: NumberWithUnit | None


@dataclass(frozen=True)
class Design(Documented):
    """Designed gains beside the default.

    Attributes:
        gains: The designed gains.
        default: The default gains of the study.
        axes: For each axis whether it was designed, why not, and how well it rejects load.
        margins: The documents of the margins of "default" and "design".
        warnings: What a reader must know.

    """

    gains: Gains
    default: Gains
    axes: list[DesignedAxis]
    margins: dict[str, MarginsDocument]
    warnings: list[str]

    @property
    def document(self) -> Row:
        """Everything as data, as `tuner design --json` prints it."""
        return {
            "gains": self.gains.document, "design": [axis.content() for axis in self.axes],
            "margins": {name: found.content() for name, found in self.margins.items()}, "warnings": self.warnings,
        }  # fmt: skip

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each gain: default, design, unit."""
        default, design = self.default.controller, self.gains.controller
        rows = [
            {"gain": g.address, "default": default.gains[g.column], "design": design.gains[g.column], "unit": g.unit}
            for g in gain_addresses(design.cascade)
        ]  # fmt: skip
        return frame(rows, "gain")

    def _repr_html_(self) -> str:
        return shown("Designed gains", self.warnings, self.table)


def design(study: StudyLike, out: str | Path | None = None, *, watcher: Watcher | None = None) -> Design | PlantDesign:
    """Design gains for a study's laws, and compare their margins with the default's.

    Args:
        study: A tuning study, a file, or the name of a shipped study.
        out: A gains.json to write; it must not exist.
        watcher: Callbacks that hear of compilation.

    Returns:
        The designed gains; axes whose law has no design keep their defaults. Of a plant of your own a `PlantDesign`.

    Raises:
        InputError: The study is wrong, or of another kind.
        StoreError: The file exists already, or cannot be written.

    Examples:
        >>> designed = tuner.design(study)
        >>> designed.table.loc["roll.k2", "unit"]
        's^-1'

    """
    if out is not None and Path(out).exists():
        raise taken(Path(out))
    asked = gains_study(study, "tuner design")
    if isinstance(asked, PlantStudy):
        announce_compilation(watcher or Watcher())
        return design_plant(asked, None if out is None else Path(out))
    assert isinstance(asked, Study)
    designs = study_designs(asked)
    row = design_row(asked, designs)
    axes = [
        DesignedAxis(
            axis=axis, designed=found.designed, why=found.why,
            load_rejection=NumberWithUnit(value=found.load_rejection, unit="s^-3") if found.designed else None,
        )
        for axis, found in designs.items()
    ]  # fmt: skip
    announce_compilation(watcher or Watcher())
    controllers = {"default": asked.controller(asked.default_row), "design": asked.controller(row)}
    margins = {name: margins_in(asked, controller) for name, controller in controllers.items()}
    gains = gains_of(controllers["design"], provenance_of(asked, axes))
    if out is not None:
        gains = replace(gains, path=gains.write(out))
    default, warnings = gains_of(controllers["default"], {}), [*without_design(designs), *differing(asked, row)]
    return Design(gains, default, axes, margins, warnings)


def provenance_of(study: Study, axes: list[DesignedAxis]) -> Row:
    """Return what gains.json says of the origin of a design."""
    coded = [
        {**row.content(), "load_rejection": row.load_rejection and quantity(**row.load_rejection.content())}
        for row in axes
    ]
    return {"study": study.origin("design"), "design": coded}


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


def margins_in(study: Study, controller: Controller) -> MarginsDocument:
    """Return the margins of a controller as `tuner margins` has them; in attitude mode where all scenarios fly in it."""
    specs = tuple(entry.spec for entry in study.scenarios)
    subject = subject_of(controller, Trim(hold=holds_place(specs, study.system.timing)))
    return margins_document(subject, default_requirements(subject))
