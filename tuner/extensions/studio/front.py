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
AIDS = {
    "ended": "Points of the run on held-out flights, the setting as a circle. A click takes the gains of a point.",
    "growing": "Candidates of the run on search flights, the setting as a circle on held-out ones. A click takes their gains.",
    "none": "No run yet: the place of the setting alone.",
}
"""State of the run -> line on how to read the chart."""


class Front:
    """Points of a run in the first two objectives.

    Args:
        session: The opened study.
    """

    def __init__(self, session: Session) -> None:
        self.run = None if session.folder is None else RunFolder(session.folder, session.study)
        self._drawn: tuple[RunFolder | None, int, bool] | None = None
        self._panel = Panel(KEY, "", Axis(), Axis(), [])

    def panels(self, rows: Sequence[Mapping[str, Any]]) -> list[Panel]:
        """Return the panel of the trade-off; rows: of the table, whose first objectives place the setting at hand."""
        objectives = [row for row in rows if row["kind"] == "objective"][:2]
        base = self._base(objectives)
        x, *y = (np.array([np.nan if row["value"] is None else row["value"]]) for row in objectives)
        height = y[0] if y else np.ones(1)
        place = Points(
            name="here", look=LOOKS["here"], x=x, y=height, hover=["the setting at hand"], show={"layer": "here"}
        )
        return [
            Panel(KEY, "Trade-off", base.x, base.y, [*base.marks, place], form="pair", aid=base.aid, rows=base.rows)
        ]

    def _base(self, objectives: Sequence[Mapping[str, Any]]) -> Panel:
        """Return the panel without the setting at hand."""
        run = self.run
        state = (run, 0 if run is None else len(run.generations()), run is not None and run.has_ended)
        if state != self._drawn:
            results = None if run is None else run.results
            self._panel = ended(results) if results is not None else self._growing(objectives)
            self._drawn = state
        return self._panel

    def _growing(self, objectives: Sequence[Mapping[str, Any]]) -> Panel:
        titles = [bracketed(row["name"], row["unit"]) for row in objectives]
        generations = [] if self.run is None else self.run.generations()
        aid = AIDS["growing" if generations else "none"]
        if len(titles) == 1:
            values = [each.values[:, :1] for each in generations]
            spread = np.linspace(0.0, -1.0, sum(map(len, values))) if values else np.zeros(0)
            columns = [np.concatenate([*values, np.zeros((0, 1))])[:, 0], spread]
            axes = [span_of(columns[:1], LOG_FACTOR).axis(titles[0]) if values else Axis(titles[0]), row_axis(["", ""])]
        else:
            columns = [np.concatenate([*[each.values[:, i] for each in generations], np.zeros(0)]) for i in range(2)]
            axes = [Axis(title) for title in titles]
        names = [name for each in generations for name in each.names]
        feasible = np.concatenate([*[each.feasible for each in generations], np.zeros(0, dtype=bool)])
        marks: list[Mark] = []
        for layer, mask in (("infeasible", ~feasible), ("searched", feasible)):
            rows = np.flatnonzero(mask & np.isfinite(columns[0]) & np.isfinite(columns[1]))[-MAX_CANDIDATES:]
            labels = [names[i] for i in rows]
            look = LAYERS[layer][1]._replace(size=7)
            marks.append(
                Points(
                    name=LAYERS[layer][0],
                    look=look,
                    x=columns[0][rows],
                    y=columns[1][rows],
                    labels=labels,
                    hover=labels,
                )
            )
        return Panel(KEY, "", axes[0], axes[1], marks, aid=aid, rows=len(titles) == 1)


def ended(results: TuningFolder) -> Panel:
    """Return the panel of a run that has ended."""
    panel = front_panels(results)[0]
    marks = [
        Points(**{**vars(mark), "hover": list(mark.labels)}) if isinstance(mark, Points) and len(mark.labels) else mark
        for mark in panel.marks
    ]
    return Panel(KEY, "", panel.x, panel.y, marks, aid=AIDS["ended"], rows=panel.rows)
