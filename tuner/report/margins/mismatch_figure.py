"""Figure of the mismatch maps: where the loop stays stable, and where it keeps the limits too."""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from tuner.analysis.margins.mismatch import CRITERIA, REACH, Extent, Map
from tuner.report.charts.look import INKS
from tuner.report.charts.paper import grid
from tuner.report.margins.loop_figures import Style

TICKS = (0.25, 0.5, 0.7, 1.0, 1.4, 2.0, 4.0)
TITLES = {"mass": "mass", "inertia": "inertia", "thrust": "rotor thrust", "lag": "rotor lag"}
UNSTABLE: Style = {"facecolor": "#c9cfd4", "edgecolor": INKS["ink"], "hatch": "xxx", "linewidth": 0.0}
GROUNDED: Style = {"facecolor": "#ffffff", "edgecolor": INKS["faint"], "hatch": "...", "linewidth": 0.0}
BROKEN: Style = {"facecolor": "#eef0f2", "edgecolor": "#eef0f2"}
KEPT: Style = {"facecolor": "#a9d3c8", "edgecolor": INKS["front"]}


def mismatch_figure(maps: list[Map], extents: list[Extent]) -> Figure:
    """Maps side by side, above each how far its factors may go by themselves."""
    figure, axes = grid(len(maps), 2, 3.5)
    for ax, entry in zip(axes, maps, strict=True):
        _regions(ax, entry)
        _cross(ax, entry, extents)
        for name, axis in ((entry.across, ax.xaxis), (entry.up, ax.yaxis)):
            axis.set_label_text(f"{TITLES[name]}, actual over assumed")
            axis.set_major_locator(FixedLocator(TICKS))
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    handles = [
        Patch(label="limits kept", **KEPT),
        Patch(label="stable, a limit broken", facecolor=BROKEN["facecolor"], edgecolor=INKS["faint"]),
        Patch(label="not stable", **UNSTABLE),
        Patch(label="no steady flight", **GROUNDED),
    ]
    figure.legend(handles=handles, loc="outside upper center", ncols=4)
    return figure


def _regions(ax: Axes, entry: Map) -> None:
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.grid(False)
    grounded = np.isnan(entry.stability)
    ax.patch.set(**GROUNDED)
    fly = partial(ax.contourf, entry.x, entry.y)
    stability, limits = (np.ma.array(values, mask=grounded) for values in (entry.stability, entry.limits))
    fly(stability, levels=[-1e9, 1e9], colors=[BROKEN["facecolor"]])
    shaded = fly(stability, levels=[-1e9, 0.0], colors=[UNSTABLE["facecolor"]], hatches=[UNSTABLE["hatch"]])
    shaded.set_edgecolor(UNSTABLE["edgecolor"])
    shaded.set_linewidth(0.0)
    fly(limits, levels=[0.0, 1e9], colors=[KEPT["facecolor"]])
    for values, style in ((stability, "solid"), (limits, (0, (4, 2)))):
        if values.min(axis=None) < 0.0 < values.max(axis=None):
            ax.contour(entry.x, entry.y, values, levels=[0.0], colors=[INKS["ink"]], linewidths=1.2, linestyles=[style])
    ax.set_xlim(entry.x[0], entry.x[-1])
    ax.set_ylim(entry.y[0], entry.y[-1])


def _cross(ax: Axes, entry: Map, extents: list[Extent]) -> None:
    """The nominal vehicle, and how far each factor may go from it by itself, in words."""
    ax.plot([1.0], [1.0], "P", color=INKS["ink"], markersize=7, markeredgecolor="white")
    lines = []
    for factor in (entry.across, entry.up):
        stable, limits = (next(e for e in extents if (e.factor, e.criterion) == (factor, name)) for name in CRITERIA)
        lines.append(f"{TITLES[factor]} alone: stable from {_span(stable)}")
        broken = limits.low == limits.high == 1.0
        lines.append(f"{'limits broken from the start' if broken else f'limits kept from {_span(limits)}'}")
    ax.set_title("\n".join(lines), fontsize=7.5, loc="left")


def _span(extent: Extent) -> str:
    low = f"below {1.0 / REACH:g}" if extent.low is None else f"{extent.low:.2f}"
    high = f"above {REACH:g}" if extent.high is None else f"{extent.high:.2f}"
    return f"{low} to {high}"
