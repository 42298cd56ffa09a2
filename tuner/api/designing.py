"""Design gains from requirements on the loops, before any search."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from objectives.margins.trim import Trim
from plant.errors import InputError
from plant.quadrotor.gains import gain_addresses
from tuner.analysis.margins.document import default_requirements, finite, margins_document
from tuner.analysis.margins.readings import subject_of
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import Gains, gains_of, gains_of_plant
from tuner.api.margins import announce_compilation
from tuner.api.studies import StudyLike, gains_study
from tuner.documents.comparison_document import BoundRow
from tuner.documents.margins import MarginsDocument
from tuner.documents.parts import NumberWithUnit, in_shown_units
from tuner.experiments.tuning.bounds import on_bounds
from tuner.experiments.tuning.guards.after import gains_on_bounds
from tuner.experiments.tuning.starts import design_row, study_designs, without_design
from tuner.extension import find
from tuner.gains import Controller
from tuner.gains.quantities import quantity
from tuner.gains.sections import Row
from tuner.report.verdict_text import beside_limit
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.document import DocumentPart, taken
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study, TuningStudy
from tuner.study.trim import holds_place
from tuner.text.numbers import MISSING
from tuner.text.sentences import bound_text, listing
from tuner.text.toml_text import shown as toml
from tuner.text.units import after_number

if TYPE_CHECKING:
    import pandas as pd

    from objectives.design.plant_design import ChannelDesign, ChannelTask
    from objectives.design.requirements import DesignRequirements


class DesignedAxis(DocumentPart):
    """Design of an axis; why: not, where it is not; load_rejection [s^-3]: null where it is not."""

    axis: str
    designed: bool
    why: str
    load_rejection: NumberWithUnit | None


class DesignedChannel(DocumentPart):
    """Design of a plant's channel; why: not, where it is not; ms, mt: peaks of its loop, null where infinite."""

    channel: str
    designed: bool
    why: str
    ms: float | None
    mt: float | None


@dataclass(frozen=True)
class Design(Documented):
    """Designed gains next to the default.

    Attributes:
        gains: The designed gains.
        default: The default gains of the study.
        loops: Design of each axis or channel: success or reason, and figures of its loop.
        margins: The documents of the margins of "default" and "design".
        warnings: Notes for the reader.
        toml: The [gains] table of a study of a plant that starts from the design; empty for a quadrotor.

    """

    gains: Gains
    default: Gains
    loops: Sequence[DesignedAxis | DesignedChannel]
    margins: dict[str, MarginsDocument]
    warnings: list[str]
    toml: str = ""

    @property
    def has_success(self) -> bool:
        """Whether an axis or a channel has designed gains."""
        return any(loop.designed for loop in self.loops)

    @property
    def document(self) -> Row:
        """Everything as data, as `tuner design --json` prints it."""
        return {
            "gains": self.gains.document,
            "design": [loop.content() for loop in self.loops],
            "margins": {name: margin.content() for name, margin in self.margins.items()},
            "warnings": self.warnings,
        }

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each gain: default, design, unit."""
        units = self.gains.units
        rows = [
            {"gain": address, "default": self.default[address], "design": value, "unit": units[address]}
            for address, value in self.gains.items()
        ]
        return frame(rows, "gain")

    def _repr_html_(self) -> str:
        return shown("Designed gains", self.warnings, self.table)


@dataclass(frozen=True)
class Proposal:
    """Gains that a method has for a plant's study.

    Attributes:
        row: The gains row (g,).
        channels: Design of each channel by name.
        notes: Notes for the reader.

    """

    row: np.ndarray
    channels: "Mapping[str, ChannelDesign]"
    notes: Sequence[str] = ()


def design(
    study: StudyLike,
    out: str | Path | None = None,
    *,
    method: str = "",
    time: float | None = None,
    watcher: Watcher | None = None,
) -> Design:
    """Design gains for a study's laws, with margins next to the default's.

    Args:
        study: A tuning study, of a plant of your own too, a file, or the name of a shipped study.
        out: A gains.json to write; it must not exist.
        method: Design rule for the channels of a plant, such as "simc"; by default loops are shaped within the study's limits.
        time: Closed-loop time [s] of a rule that has one; by default the rule's own.
        watcher: Callbacks that hear of compilation.

    Returns:
        The designed gains; axes and channels whose law has no design keep their defaults.

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
    given = gains_study(study, "tuner design")
    announce_compilation(watcher or default_watcher())
    made = design_by_rule(given, method, time) if method or time is not None else DESIGNERS[given.kind](given)
    return made if out is None else replace(made, gains=replace(made.gains, path=made.gains.write(out)))


def design_quadrotor(study: Study) -> Design:
    """Design the gains of a quadrotor's axes."""
    designs = study_designs(study)
    row = design_row(study, designs)
    axes = [
        DesignedAxis(
            axis=axis,
            designed=design.designed,
            why=design.why,
            load_rejection=NumberWithUnit(value=design.load_rejection, unit="s^-3") if design.designed else None,
        )
        for axis, design in designs.items()
    ]
    controllers = {"default": study.controller(study.default_row), "design": study.controller(row)}
    margins = {name: margins_in(study, controller) for name, controller in controllers.items()}
    gains = gains_of(controllers["design"], provenance_of(study, axes))
    warnings = [*without_design(designs), *differing(study, row), *gains_on_bounds(bounds_within(study, row))]
    return Design(gains, gains_of(controllers["default"], {}), axes, margins, warnings)


def design_plant(study: PlantStudy) -> Design:
    """Design the gains of a plant's channels for its study's limits."""
    # What designs takes two seconds to import.
    from objectives.design.plant_design import design_channels

    default = np.array(study.default_row, dtype=float)
    tasks = {name: task_of(study, name) for name in study.system.plan.names}
    return designed(study, Proposal(*design_channels(study.system, default, tasks, requirements_of(study))))


def design_by_rule(study: TuningStudy, method: str, time: float | None) -> Design:
    """Design the gains of a plant's channels by a rule."""
    if not method:
        raise InputError("needs a rule that has such a time: add --method simc, lambda or herbst", key="--time")
    rule = find("designs", "design method", method)
    if study.kind != PlantStudy.kind:
        raise InputError(
            "a rule designs channels of a plant, and this study is of a quadrotor; remove it", key="--method"
        )
    if time is not None and not (isfinite(time) and time > 0.0):
        raise InputError(f"given {time:g} s; allowed: a finite number above 0", key="--time")
    return designed(cast(PlantStudy, study), rule(study, time))


def designed(study: PlantStudy, proposal: Proposal) -> Design:
    """Return a method's gains and the default, with margins of both."""
    default, row = np.array(study.default_row, dtype=float), proposal.row
    loops = [
        DesignedChannel(channel=name, designed=each.designed, why=each.why, ms=finite(each.ms), mt=finite(each.mt))
        for name, each in proposal.channels.items()
    ]
    reasons = dict.fromkeys(each.why for each in loops if not each.designed)
    without = {why: [each.channel for each in loops if each.why == why and not each.designed] for why in reasons}
    lacking = [f"No design for {listing(names)}: {why}; the default gains stand in." for why, names in without.items()]
    gains = {"default": gains_of_plant(study, default), "design": gains_of_plant(study, row)}
    limits = study if study.table.margin else None
    margins = {name: each.judge_margins(Trim(), limits, False)[1] for name, each in gains.items()}
    at_ends = gains_on_bounds(bounds_within(study, row))
    warnings = [*lacking, *proposal.notes, *beyond_limits(margins["design"] if limits else None), *at_ends]
    return Design(gains["design"], gains["default"], loops, margins, warnings, gains_table(study, row))


def bounds_within(study: TuningStudy, row: np.ndarray) -> list[BoundRow]:
    """Return the designed gains at an end of their range.

    A gain beyond an end, such as an integral gain of 0 below a logarithmic range, was not stopped by it.
    """
    columns = [entry[0] for entry in study.space.columns]
    changed = {
        variable.name
        for variable, column in zip(study.space.variables, columns, strict=True)
        if row[column] != study.default_row[column]
    }
    return [
        entry
        for entry in on_bounds(study, row, np.empty((0, len(row))))
        if entry.variable in changed
        and (entry.value >= entry.bound if entry.end == "low" else entry.value <= entry.bound)
    ]


def beyond_limits(margins: MarginsDocument | None) -> list[str]:
    """Return a sentence on the limits that a design violates."""
    rows = [] if margins is None else [in_shown_units(row) for row in margins.requirements if not row.is_satisfied]
    if not rows:
        return []
    texts = [
        f"{row.label} is {MISSING if row.value is None else beside_limit(row.value, row)}{after_number(row.unit)}, "
        f"{bound_text(row.limit, row.sense)}"
        for row in rows
    ]
    return [
        f"The design violates limits of the study: {listing(texts)}. It shapes Ms and Mt alone; tune the rest by a search."
    ]


DESIGNERS: dict[str, Callable[[Any], Design]] = {Study.kind: design_quadrotor, PlantStudy.kind: design_plant}
"""Kind of study -> what designs its gains."""


def gains_table(study: PlantStudy, row: np.ndarray) -> str:
    """Return the [gains] table of a study that starts from a design: ranges as they are, with other defaults."""
    searched = {variable.name: variable for variable in study.space.variables}
    lines = ["[gains]"]
    for gain in study.system.gains:
        value, variable = float(f"{row[gain.column]:.6g}"), searched.get(gain.address)
        # A range on a logarithmic scale cannot reach a gain that is off.
        off = variable is not None and variable.scale == "log" and value <= 0.0
        ends = None if variable is None or off else (min(variable.low, value), max(variable.high, value))
        text = toml(value) if ends is None else f"{{ low = {ends[0]!r}, high = {ends[1]!r}, default = {value!r} }}"
        lines.append(f'"{gain.address}" = {text}')
    return "\n".join(lines)


def provenance_of(study: Study, axes: list[DesignedAxis]) -> Row:
    """Return the origin of a design for gains.json."""
    coded = [
        {**row.content(), "load_rejection": row.load_rejection and quantity(**row.load_rejection.content())}
        for row in axes
    ]
    return {"study": study.origin("design"), "design": coded}


def differing(study: Study, row: np.ndarray) -> list[str]:
    """Return a sentence on a design's gains outside the study's space.

    They differ from those of the nearest point of the space.
    """
    nearest = study.space.gains(study.space.point(row)[None])[0]
    off = [
        gain.address
        for gain in gain_addresses(study.system.cascade)
        if abs(nearest[gain.column] - row[gain.column]) > 1e-6 * abs(row[gain.column])
    ]
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
    """Return the task of a channel's design: ranges, loudest sensors, largest step, authority."""
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
    """Return the largest command of a channel either way from rest.

    It is in the channel's unit, infinite for no limit.
    """
    plan = study.system.plan
    channel = plan.channel(name)
    ends = [(channel.low, channel.high), *[(each.low, each.high) for each in plan.actuators if each.name == channel.to]]
    return min(0.5 * (high - low) for low, high in ends)
