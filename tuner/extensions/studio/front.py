"""The trade-off: points of a run, which may still grow, and the place of the setting at hand among them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tuner.documents.tuning import TuningFolder
from tuner.extensions.studio.charts import LOOKS
from tuner.extensions.studio.run_folder import MAX_CANDIDATES, RunFolder
from tuner.extensions.studio.session import Session
from tuner.report.charts.chart import Axis, Mark, Panel, Points, row_axis, span_of
from tuner.report.charts.front import LAYERS, LOG_FACTOR, front_panels
from tuner.text.units import bracketed

KEY = "front"
"""Id of the chart."""
AID = "Points of a run, and the setting as a circle. A click takes the gains of a point."
"""Line on how to read the chart."""


class Front:
    """Points of a run in the first two objectives."""

    def __init__(self, session: Session) -> None:
        self.run = None if session.folder is None else RunFolder(session.folder, session.study)
        self._n_objectives = len(session.study.objectives)
        self._drawn: tuple[RunFolder, int, bool] | None = None
        self._panel = Panel(KEY, "", Axis(), Axis(), [])

    def panels(self, rows: Sequence[Mapping[str, Any]]) -> list[Panel]:
        """Return the panel of the trade-off, none without a run.

        rows: of the table, whose first objectives place the setting at hand.
        """
        if self.run is None:
            return []
        objectives = [row for row in rows if row["kind"] == "objective"][:2]
        base = self._base(self.run, objectives)
        x, *y = (np.array([np.nan if row["value"] is None else row["value"]]) for row in objectives)
        height = y[0] if y else np.full(1, 0.45)
        hover, show = ["the setting at hand"], {"layer": "here"}
        place = Points(name="here", look=LOOKS["here"], x=x, y=height, hover=hover, show=show)
        axes = stretched(base.x, x), base.y if base.rows else stretched(base.y, height)
        return [Panel(KEY, "Trade-off", *axes, [*base.marks, place], form="pair", rows=base.rows)]

    def _base(self, run: RunFolder, objectives: Sequence[Mapping[str, Any]]) -> Panel:
        """Return the panel without the setting at hand."""
        state = (run, len(run.generations()), run.has_ended)
        if state != self._drawn:
            results = run.results
            self._panel = ended(results) if results is not None else self._growing(run, objectives)
            self._drawn = state
        return self._panel

    def _growing(self, run: RunFolder, objectives: Sequence[Mapping[str, Any]]) -> Panel:
        titles = [bracketed(row["name"], row["unit"]) for row in objectives]
        generations = run.generations()
        every = np.concatenate([*[each.values for each in generations], np.zeros((0, self._n_objectives))])
        feasible = np.concatenate([*[each.feasible for each in generations], np.zeros(0, dtype=bool)])
        is_ranking = len(titles) == 1
        columns = [every[:, 0], np.linspace(0.0, -1.0, len(every)) if is_ranking else every[:, 1]]
        # A lost flight costs more than any other: its candidates would press all others into a corner.
        shown = [column[feasible] if feasible.any() else column for column in columns]
        axes = [
            span_of([part], LOG_FACTOR).axis(title) if len(part) else Axis(title)
            for title, part in zip(titles, shown, strict=False)
        ]
        axes += [row_axis(["", ""])] if is_ranking else []
        names = [name for each in generations for name in each.names]
        marks: list[Mark] = []
        for layer, mask in (("infeasible", ~feasible), ("searched", feasible)):
            rows = np.flatnonzero(mask & np.isfinite(columns[0]) & np.isfinite(columns[1]))[-MAX_CANDIDATES:]
            labels = [names[i] for i in rows]
            name, look = LAYERS[layer][0], LAYERS[layer][1]._replace(size=7)
            x, y = (column[rows] for column in columns)
            marks.append(Points(name=name, look=look, x=x, y=y, labels=labels, hover=labels))
        return Panel(KEY, "", axes[0], axes[1], marks, rows=is_ranking)


def ended(results: TuningFolder) -> Panel:
    """Return the panel of a run that has ended."""
    panel = front_panels(results)[0]
    marks = [
        Points(**{**vars(mark), "hover": list(mark.labels)}) if isinstance(mark, Points) and len(mark.labels) else mark
        for mark in panel.marks
    ]
    return Panel(KEY, "", panel.x, panel.y, marks, rows=panel.rows)


def stretched(axis: Axis, values: np.ndarray) -> Axis:
    """Return an axis that holds further values (n,) too."""
    finite = values[np.isfinite(values)]
    if axis.low is None or axis.high is None or not len(finite):
        return axis
    return axis._replace(low=min(axis.low, float(finite.min())), high=max(axis.high, float(finite.max())))
