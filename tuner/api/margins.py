"""Known of gains without flying: stability margins."""

from contextlib import nullcontext
from dataclasses import dataclass
from functools import cached_property
from math import cos, sin
from pathlib import Path
from typing import TYPE_CHECKING

from objectives.margins.curve import is_compiled
from objectives.margins.trim import Trim
from plant.vectors import Vec3
from tuner.analysis.margins.readings import Loops, Subject
from tuner.api.frames import Documented, figures, frame, shown
from tuner.api.gains import GainsLike, as_gains
from tuner.api.studies import StudyLike
from tuner.documents.margins import MarginsDocument
from tuner.report.views import loops_view
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.folder import Folder

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure


@dataclass(frozen=True)
class Margins(Documented):
    """Stability margins of one controller.

    Attributes:
        document: Output of `tuner margins --json`.
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
        verdict = "All limits are satisfied." if self.passed else "A limit is violated."
        return shown("Stability margins", [verdict], loops_view(self.document))


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
        announce_compilation(watcher or default_watcher())
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
