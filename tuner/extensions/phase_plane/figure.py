"""The figure of phase planes: a panel for each loop."""

from collections.abc import Sequence

import numpy as np

from tuner.extensions.phase_plane.trajectories import Trajectories
from tuner.report.charts.chart import Axis, Line, Mark, Panel, Points
from tuner.report.charts.look import Look
from tuner.report.charts.sheet import FigureSpec
from tuner.text.units import bracketed, in_degrees

# Flights drawn beside the first one.
MAX_OTHERS = 15
FIRST, OTHERS = Look("tuned", width=1.4), Look("faint", width=0.7)
REST = Look("ink", "cross-thin", size=14)
# Heights of a panel [inch], and of one alone, which is as wide as two.
HEIGHT, HEIGHT_ALONE = 2.8, 4.2


def phase_sheet(loops: Sequence[Trajectories], scenario: str) -> FigureSpec:
    """Return a panel for each loop, the first flight on top."""
    panels = [_panel(each) for each in loops]
    height = HEIGHT_ALONE if len(panels) == 1 else HEIGHT
    return FigureSpec(panels, min(len(panels), 2), height, titled=True, note=f"scenario {scenario}")


def _panel(loop: Trajectories) -> Panel:
    unit, factor = in_degrees(loop.unit)
    count = min(len(loop.error), MAX_OTHERS + 1)
    marks: list[Mark] = [
        Line(
            look=OTHERS if i else FIRST,
            name="other flights" if i else "first flight",
            x=factor * loop.error[i],
            y=factor * loop.rate[i],
        )
        for i in reversed(range(count))
    ]
    marks.append(Points(look=REST, x=np.zeros(1), y=np.zeros(1)))
    rate = f"{unit}/s" if unit else "1/s"
    return Panel(
        loop.signal, loop.signal, Axis(bracketed("error", unit)), Axis(bracketed("rate of the error", rate)), marks
    )
