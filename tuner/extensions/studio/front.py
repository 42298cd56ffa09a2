"""The trade-off: points of a run, and the place of the setting at hand among them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tuner.extensions.studio.charts import LOOKS
from tuner.extensions.studio.session import Session
from tuner.report.charts.chart import Axis, Mark, Panel, Points, row_axis
from tuner.report.charts.front import front_panels
from tuner.text.units import bracketed, in_degrees

KEY = "front"
"""Id of the chart."""


class Front:
    """Points of a run in the first two objectives, and the setting at hand.

    Args:
        session: The opened study.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._panel: Panel | None = None

    def panels(self, rows: Sequence[Mapping[str, Any]]) -> list[Panel]:
        """Return the panel of the trade-off; rows: of the table, whose first objectives place the setting at hand."""
        objectives = [row for row in rows if row["kind"] == "objective"][:2]
        base = self._base(objectives)
        places = [np.array([np.nan if row["value"] is None else row["value"]]) for row in objectives]
        marks: list[Mark] = list(base.marks)
        if len(places) == 2:
            marks.append(Points(name="here", look=LOOKS["here"], x=places[0], y=places[1], hover=["here"], edge=True))
        else:
            marks.append(Points(name="here", look=LOOKS["here"], x=places[0], y=np.array([1.0]), hover=["here"]))
        return [Panel(KEY, "Trade-off", base.x, base.y, marks, form="pair", aid=base.aid, rows=base.rows)]

    def _base(self, objectives: Sequence[Mapping[str, Any]]) -> Panel:
        """Return the panel without the setting at hand."""
        if self._panel is None:
            self._panel = self._recorded() or self._empty(objectives)
        return self._panel

    def _recorded(self) -> Panel | None:
        results = self._session.results
        if results is None:
            return None
        panel = front_panels(results)[0]
        aid = "Points of the run on held-out flights. A click takes a point's gains."
        return Panel(KEY, "", panel.x, panel.y, panel.marks, aid=aid, rows=panel.rows)

    def _empty(self, objectives: Sequence[Mapping[str, Any]]) -> Panel:
        titles = [bracketed(row["name"], in_degrees(row["unit"]).unit) for row in objectives]
        aid = "No run yet: the place of the setting alone."
        if len(titles) == 1:
            return Panel(KEY, "", Axis(titles[0]), row_axis(["", "here"]), [], aid=aid, rows=True)
        return Panel(KEY, "", Axis(titles[0]), Axis(titles[1]), [], aid=aid)
