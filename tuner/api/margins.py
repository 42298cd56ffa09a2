"""Known of gains without flying: stability margins, guarantees of theory."""

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cached_property
from math import cos, isfinite, sin
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from objectives.margins.curve import is_compiled
from objectives.margins.trim import Trim
from objectives.theory import THEOREMS, Setting, Theorem
from objectives.theory.disturbance_rate import worst_rates
from objectives.theory.guarantee import Guarantee, law_of, loop_of
from plant.loop import Timing
from plant.quadrotor.cascade import AXES
from plant.quadrotor.nominal import nominal
from plant.vectors import Vec3
from tuner.analysis.margins.readings import Loops, Subject
from tuner.analysis.responses import LIMITS, system_of, usual_scenario
from tuner.api.frames import Documented, figures, frame, shown
from tuner.api.gains import GainsLike, as_gains
from tuner.api.studies import StudyLike, tuning_study
from tuner.documents.margins import MarginsDocument
from tuner.gains import Controller
from tuner.search.watcher import Watcher
from tuner.store.document import DocumentPart
from tuner.store.folder import Folder
from tuner.study.guarantees import rate_from_observer

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure

SEED = 1
"""Root seed of the air where no study gives one, as in `fly`."""


@dataclass(frozen=True)
class Margins(Documented):
    """Stability margins of one controller.

    Attributes:
        document: What `tuner margins --json` prints.
        subject: The loops behind it.
        from_study: Whether the limits are those of a study.

    """

    document: MarginsDocument
    subject: Loops
    from_study: bool
    folder: Path | None = None

    @property
    def passed(self) -> bool:
        """Whether every hard limit is kept."""
        return bool(self.document.passed)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each loop, a column for each quantity; NaN where nothing limits one."""
        rows, units = [], {}
        for channel in self.document.channels:
            quantities = channel.quantities
            units |= {name: reading.unit for name, reading in quantities.items()}
            values = {name: reading.value for name, reading in quantities.items()}
            rows.append({"channel": channel.channel, "stable": channel.stable, **values})
        return frame(rows, "channel", units)

    @cached_property
    def requirements(self) -> "pd.DataFrame":
        """A row for each limit: value, limit, sense, whether it is hard, and whether it is kept."""
        return frame(self.document.requirements, "label")

    def figure(self, name: str = "bode") -> "Figure":
        """Draw the loops.

        Args:
            name: "bode", "nyquist" or "nichols".

        Returns:
            The figure, made without pyplot.

        Examples:
            >>> tuner.margins(gains).figure("nyquist").savefig("nyquist.png")

        """
        return figures("margins", self.subject).draw(name)

    def _repr_html_(self) -> str:
        verdict = "All limits are satisfied." if self.passed else "A limit is broken."
        return shown("Stability margins", [verdict], self.table)


def margins(
    gains: GainsLike,
    *,
    study: StudyLike | None = None,
    yaw: float = 0.0,
    speed: float = 0.0,
    wind: float = 0.0,
    hold_position: bool = True,
    certificates: bool = False,
    out: str | Path | None = None,
    watcher: Watcher | None = None,
) -> Margins:
    """Compute the stability margins of gains by loop, at the worst amplitude.

    Args:
        gains: Gains, a gains.json or a results folder; of a plant, name its code with `use` or give the study.
        study: Study whose [[margin]] tables are the limits, at hover and in the trims of its scenarios unless a steady flight is
            given; by default usual limits.
        yaw: Yaw in steady flight [rad].
        speed: Ground speed along the heading [m/s].
        wind: Steady wind towards east, the x axis of the world [m/s].
        hold_position: Whether the loops of x and y are closed.
        certificates: Whether to prove what can be proved, too.
        out: New folder for figures and margins.json.
        watcher: Callbacks that hear of compilation.

    Returns:
        The margins.

    Raises:
        InputError: There is no steady flight in this trim, or the study is about other laws.
        StoreError: The folder holds something already, or cannot be written.

    Examples:
        >>> found = tuner.margins(gains)
        >>> found.table.index.tolist()
        ['x', 'y', 'z', 'roll', 'pitch', 'yaw']

    """
    given, trim = as_gains(gains), trim_of(yaw, speed, wind, hold_position)
    folder = None if out is None else Folder.create(Path(out), inside="", empty=True)
    with folder or nullcontext():
        announce_compilation(watcher or Watcher())
        subject, document, from_study = given.judge_margins(trim, study, certificates)
        if folder is not None:
            document = write(document, subject, folder)
    return Margins(document, subject, from_study, None if folder is None else folder.path)


def trim_of(yaw: float, speed: float, wind: float, hold_position: bool) -> Trim:
    """Return a steady flight: yaw [rad], ground speed along the heading and wind towards east [m/s]."""
    return Trim(yaw, Vec3(speed * cos(yaw), speed * sin(yaw), 0.0), Vec3(wind, 0.0, 0.0), hold_position)


def announce_compilation(watcher: Watcher) -> None:
    """Tell that the first margins on a machine wait for the compiler."""
    if not is_compiled():
        watcher.on_message("Compiling the margins for this machine; once, some 10 s.")


def write(document: MarginsDocument, subject: Loops, folder: Folder) -> MarginsDocument:
    """Write the figures and margins.json, with tolerances to vehicle mismatch added."""
    from tuner.report.margin_figures import write_loop_figures, write_margin_figures

    if isinstance(subject, Subject):
        extents = [extent.row() for extent in write_margin_figures(subject, folder.path)]
        document = document.model_copy(update={"mismatch": extents})
    else:
        write_loop_figures(subject, folder.path)
    folder.write_json("margins.json", document)
    folder.written("*.png", "*.pdf")
    folder.seal()
    return document


class TheoremRow(DocumentPart):
    """A theorem on an axis; value null where infinite; holds: value over disturbance_rate, null for a bound."""

    axis: str
    law: str
    theorem: str
    quantity: str
    value: float | None
    unit: str
    disturbance_rate: float
    rate_unit: str
    holds: bool | None
    assumes: str
    source: str


class TheoryDocument(DocumentPart):
    """Guarantees of theory. level: quantile of the disturbance rates, which are given by axis [rad/s^3 or m/s^3]."""

    scenarios: list[str]
    level: float
    axes: list[str]
    rates: dict[str, float]
    theorems: list[TheoremRow]


@dataclass(frozen=True)
class Theory(Documented):
    """Guarantees of theory for one controller; document: as `tuner theory --json` prints it; control_period [s]."""

    document: TheoryDocument
    control_period: float

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each axis and theorem: value, disturbance rate, and whether the first exceeds the second."""
        return frame(self.document.theorems, ("axis", "theorem"))

    def _repr_html_(self) -> str:
        return shown("Guarantees of theory", (), self.table.reset_index())


def theory(gains: GainsLike, *, study: StudyLike | None = None, level: float = 0.99) -> Theory:
    """Evaluate the theorems for gains on each axis.

    The guarantees are against the disturbance rate of the air.

    Args:
        gains: Gains, or a gains.json.
        study: Study in whose scenarios the disturbance is measured; by default that of `fly`.
        level: Quantile of the measured disturbance rate.

    Returns:
        A row for each axis and theorem that speaks of its law.

    Raises:
        InputError: The gains or the study are wrong, or the gains are those of a plant of your own.

    Examples:
        >>> tuner.theory(gains).document.level
        0.99

    """
    controller = as_gains(gains).quadrotor(
        "holds gains of a plant of one's own, and theorems speak of a quadrotor's axes; `tuner margins` with --certificates "
        "tells what is proved of a plant"
    )
    if study is None:
        specs, seed = (usual_scenario(system_of(controller, LIMITS)),), SEED
    else:
        judging = tuning_study(study, "tuner theory --study")
        specs, seed = tuple(entry.spec for entry in judging.scenarios), judging.seed
    timing = Timing(controller.control_period, controller.plant_step)
    rates = worst_rates(specs, controller.airframe.vehicle, timing, seed, level)
    names = [spec.name for spec in specs]
    rows = theory_rows(controller, rates)
    document = TheoryDocument(scenarios=names, level=level, axes=list(AXES), rates=rates, theorems=rows)
    return Theory(document, timing.control_period)


def theory_rows(controller: Controller, rates: Mapping[str, float]) -> list[TheoremRow]:
    """Return a row for each axis and each applicable theorem.

    holds is None where there is nothing to hold.
    """
    knowledge = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
    rows = []
    for axis in AXES:
        law = law_of(controller.cascade, axis).name
        for theorem in THEOREMS.values():
            if theorem.speaks_of(law, rate_from_observer(knowledge, axis)):
                rows.append(theory_row(theorem, controller, axis, rates[axis]))
    return rows


def theory_row(theorem: Theorem, controller: Controller, axis: str, rate: float) -> TheoremRow:
    """Return the row of one theorem on one axis."""
    guarantee = Guarantee(theorem, controller.cascade, {axis: Setting(controller.control_period, rate)})
    value = float(guarantee.values(np.array([controller.gains]))[0, 0])
    loop = loop_of(axis)
    return TheoremRow(
        axis=axis,
        law=law_of(controller.cascade, axis).name,
        theorem=theorem.name,
        quantity=theorem.quantity,
        value=value if isfinite(value) else None,
        unit=theorem.unit_in(loop),
        disturbance_rate=rate,
        rate_unit="m/s^3" if loop == "position" else "rad/s^3",
        holds=value >= rate if theorem.sense == "min" else None,
        assumes=theorem.assumes,
        source=theorem.source,
    )
