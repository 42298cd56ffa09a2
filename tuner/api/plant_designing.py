"""Design gains of a plant's channels from limits on their loops, before any search."""

from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tuner.analysis.margins.document import default_requirements, plant_margins_document
from tuner.analysis.margins.readings import plant_subject
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import write_new
from tuner.documents.margins import MarginsDocument
from tuner.gains.plant_document import plant_gains_document
from tuner.study.plant_study import PlantStudy
from tuner.text.toml_text import shown as toml

if TYPE_CHECKING:
    import pandas as pd

    from objectives.design.plant_design import ChannelDesign, ChannelTask
    from objectives.design.requirements import DesignRequirements

Array = np.ndarray


@dataclass(frozen=True)
class PlantDesign(Documented):
    """Designed gains of a plant beside the default.

    Attributes:
        study: The study of the plant.
        default: Gains row (g,) of the study.
        row: The designed one.
        channels: For each channel whether it was designed, why not, and the peaks of its loop.
        margins: The documents of the margins of "default" and "design".
        path: The gains.json that was written, None for none.

    """

    study: PlantStudy
    default: Array
    row: Array
    channels: "dict[str, ChannelDesign]"
    margins: dict[str, MarginsDocument]
    path: Path | None = None

    @property
    def gains(self) -> dict[str, Any]:
        """Content of gains.json."""
        return plant_gains_document(self.study.system, self.row, self.study.code_digest)

    @property
    def document(self) -> dict[str, Any]:
        """Everything as data, as `tuner design --json` prints it."""
        design = [
            {
                "channel": name,
                "designed": found.designed,
                "why": found.why,
                "ms": finite(found.ms),
                "mt": finite(found.mt),
            }
            for name, found in self.channels.items()
        ]
        margins = {name: found.content() for name, found in self.margins.items()}
        return {"gains": self.gains, "design": design, "margins": margins, "warnings": self.warnings}

    @property
    def warnings(self) -> list[str]:
        """A sentence for each channel that keeps its default."""
        return [
            f"No design for {name}: {found.why}; the default gains stand in."
            for name, found in self.channels.items() if not found.designed
        ]  # fmt: skip

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each gain: default, design, unit."""
        rows = [
            {"gain": g.address, "default": self.default[g.column], "design": self.row[g.column], "unit": g.unit}
            for g in self.study.system.gains
        ]  # fmt: skip
        return frame(rows, "gain")

    @property
    def toml(self) -> str:
        """The [gains] table of a study that starts from the design: ranges as they are, with other defaults."""
        searched = {variable.name: variable for variable in self.study.space.variables}
        lines = ["[gains]"]
        for gain in self.study.system.gains:
            value, variable = float(f"{self.row[gain.column]:.6g}"), searched.get(gain.address)
            ends = None if variable is None else (min(variable.low, value), max(variable.high, value))
            text = toml(value) if ends is None else f"{{ low = {ends[0]!r}, high = {ends[1]!r}, default = {value!r} }}"
            lines.append(f'"{gain.address}" = {text}')
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return shown("Designed gains", self.warnings, self.table)


def design_plant(study: PlantStudy, out: Path | None) -> PlantDesign:
    """Design the gains of a plant's channels for the limits of its study, and compare their margins with the default's."""
    # What designs takes two seconds to import.
    from objectives.design.plant_design import design_channels

    default = np.array(study.default_row, dtype=float)
    tasks = {name: task_of(study, name) for name in study.system.plan.names}
    row, channels = design_channels(study.system, default, tasks, requirements_of(study))
    margins = {name: margins_at(study, gains) for name, gains in (("default", default), ("design", row))}
    found = PlantDesign(study, default, row, channels, margins)
    return found if out is None else PlantDesign(study, default, row, channels, margins, write_new(out, found.gains))


def requirements_of(study: PlantStudy) -> "DesignRequirements":
    """Return the peaks that every loop keeps: the study's limits on ms and mt, else the usual ones."""
    from objectives.design.requirements import DesignRequirements

    usual = DesignRequirements()
    limits = {
        name: min((table.max for table in study.table.margin if table.quantity == name and table.max), default=inf)
        for name in ("ms", "mt")
    }
    ms, mt = (limit if isfinite(limit) else getattr(usual, name) for name, limit in limits.items())
    return DesignRequirements(ms=ms, mt=mt)


def task_of(study: PlantStudy, name: str) -> "ChannelTask":
    """Return what a channel's design has to know: ranges, the loudest sensors, the largest step, and what the input can do."""
    from objectives.design.plant_design import ChannelTask

    channel = study.system.plan.channel(name)
    low, high = (study.space.gains(np.full((1, len(study.space.variables)), end))[0] for end in (0.0, 1.0))
    specs = [entry.spec for entry in study.scenarios]
    noise = tuple(
        max((spec.sensors[output].rms for spec in specs if output in spec.sensors), default=0.0)
        for output in (channel.output, channel.rate_output)
    )
    steps = [spec.references[name].step for spec in specs if name in spec.references]
    step = max((abs(after - before) for before, after, _ in steps), default=0.0)
    return ChannelTask(channel, low, high, (noise[0], noise[1]), step, authority(study, name))


def authority(study: PlantStudy, name: str) -> float:
    """Return the largest command that a channel may ask for either way from rest [its unit], infinite for no limit."""
    plan = study.system.plan
    channel = plan.channel(name)
    ends = [(channel.low, channel.high), *[(each.low, each.high) for each in plan.actuators if each.name == channel.to]]
    return min(0.5 * (high - low) for low, high in ends)


def margins_at(study: PlantStudy, row: Array) -> MarginsDocument:
    """Return the margins of a gains row with the usual limits."""
    subject = plant_subject(study.system, row)
    return plant_margins_document(subject, default_requirements(subject))


def finite(value: float) -> float | None:
    """Return a number, None where it is infinite."""
    return value if isfinite(value) else None
