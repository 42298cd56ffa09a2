"""Bode, Nyquist and Nichols figures of each loop over the amplitudes of its nonlinear terms."""

from math import ceil
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from objectives.margins.period import CHANNELS
from tuner.analysis.margins.curves import Curves
from tuner.analysis.margins.limits import LIMITS
from tuner.analysis.margins.readings import Subject
from tuner.report.charts.look import INKS
from tuner.report.charts.paper import grid

Array = np.ndarray
Style = dict[str, Any]

# How the first case (small signals), the last (steepest slope) and those between are drawn.
FIRST: Style = {"color": INKS["tuned"], "linestyle": "solid", "linewidth": 1.3, "zorder": 3.0}
LAST: Style = {"color": INKS["default"], "linestyle": (0, (4, 2)), "linewidth": 1.3, "zorder": 2.9}
BETWEEN: Style = {"color": INKS["faint"], "linestyle": "solid", "linewidth": 0.5, "zorder": 2.8}
BAND: Style = {"color": INKS["faint"], "alpha": 0.25, "linewidth": 0.0}
RULE: Style = {"color": INKS["ink"], "linewidth": 0.6, "linestyle": (0, (1, 1.5))}
# Entries side by side in a legend.
MOST_COLUMNS = 4
# Part of the plane that Nyquist and Nichols curves are shown in.
NYQUIST = ((-3.2, 1.2), (-2.2, 2.2))
NICHOLS = ((-300.0, -60.0), (-30.0, 30.0))
GAIN_SHOWN, PHASE_SHOWN = (-60.0, 60.0), (-630.0, 90.0)


def name_of(group: tuple[str, ...]) -> str:
    """Return the title of a panel."""
    return " and ".join(group)


def label_of(curves: Curves, i: int) -> str | None:
    """Return the legend's words of a case."""
    last = len(curves.labels) - 1
    if last == 0:
        return None
    return curves.labels[i] if i in (0, last) else "amplitudes between" if i == 1 else None


def style_of(i: int, count: int) -> Style:
    """Return how case i of so many is drawn."""
    return FIRST if i == 0 else LAST if i == count - 1 else BETWEEN


def legend(figure: Figure, axes: list[Axes]) -> None:
    """Put one legend for all axes above the figure, each label once."""
    found = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    if found:
        figure.legend(
            found.values(),
            found.keys(),
            loc="outside upper center",
            ncols=len(found) if len(found) <= MOST_COLUMNS else ceil(len(found) / 2),
        )


def bode_figure(subject: Subject, panels: dict[tuple[str, ...], Curves]) -> Figure:
    """Gain above phase for each loop, with the crossings that its margins are met at."""
    figure, axes = grid(2 * len(panels), len(panels), 2.1)
    n, shown = len(panels), _phase_shown(panels)
    for j, (group, curves) in enumerate(panels.items()):
        gain, phase = axes[j], axes[n + j]
        for ax, values in ((gain, curves.gain), (phase, curves.phase)):
            ax.fill_between(curves.frequency, values.min(axis=0), values.max(axis=0), **BAND)
            for i in range(len(values)):
                ax.semilogx(curves.frequency, values[i], label=label_of(curves, i), **style_of(i, len(values)))
            ax.set_xlim(curves.frequency[0], curves.frequency[-1])
        _crossings(subject, group[0], gain, phase)
        gain.set_title(name_of(group), fontweight="bold")
        gain.set_ylim(GAIN_SHOWN)
        phase.set_ylim(shown)
        phase.set_yticks(np.arange(shown[0], shown[1] + 1.0, 90.0))
        gain.axhline(0.0, **RULE)
        phase.axhline(-180.0, **RULE)
        gain.tick_params(labelbottom=False)
        phase.set_xlabel("frequency [rad/s]")
        for ax in (gain, phase):
            ax.tick_params(labelleft=j == 0)
    axes[0].set_ylabel("gain of L [dB]")
    axes[n].set_ylabel("phase of L [deg]")
    legend(figure, axes)
    return figure


def _phase_shown(panels: dict[tuple[str, ...], Curves]) -> tuple[float, float]:
    """Right angles between which all phases lie, no more of them than is worth it."""
    low = min(float(curves.phase.min(axis=None)) for curves in panels.values())
    high = max(float(curves.phase.max(axis=None)) for curves in panels.values())
    return max(90.0 * np.floor(low / 90.0), PHASE_SHOWN[0]), min(90.0 * np.ceil(high / 90.0), PHASE_SHOWN[1])


def _crossings(subject: Subject, channel: str, gain: Axes, phase: Axes) -> None:
    """Lines at the frequencies where the worst gain and phase margins are met."""
    i = CHANNELS.index(channel)
    marks = (
        ("gain margins met here", (subject.margins.gain_up, subject.margins.gain_down), (0, (3, 1, 1, 1))),
        ("phase margin met here", (subject.margins.phase,), (0, (6, 2))),
    )
    for label, worsts, dashes in marks:
        for worst in worsts:
            if worst.frequency[0, i] > 0.0:
                for ax in (gain, phase):
                    ax.axvline(worst.frequency[0, i], color=INKS["ink"], linewidth=0.7, linestyle=dashes, label=label)


def nyquist_figure(subject: Subject, panels: dict[tuple[str, ...], Curves]) -> Figure:
    """The curve of each loop, the circle of the largest Ms allowed, and the disk that its disk margin keeps free."""
    figure, axes = grid(len(panels), 2, 3.3)
    for ax, (group, curves) in zip(axes, panels.items(), strict=True):
        _forbidden(ax)
        _free_disk(subject, group[0], ax)
        for i in range(len(curves.loop)):
            loop = curves.loop[i]
            ax.plot(loop.real, loop.imag, label=label_of(curves, i), **style_of(i, len(curves.loop)))
        ax.plot([-1.0], [0.0], "+", color=INKS["ink"], markersize=9, markeredgewidth=1.4)
        ax.set_title(name_of(group), fontweight="bold")
        ax.set_xlim(NYQUIST[0])
        ax.set_ylim(NYQUIST[1])
        ax.set_aspect("equal")
        ax.set_xlabel("Re L")
        ax.set_ylabel("Im L")
    legend(figure, axes)
    return figure


def largest_peak() -> float:
    """Return the largest Ms that is allowed."""
    return next(limit.limit for limit in LIMITS if limit.quantity == "ms")


def _forbidden(ax: Axes) -> None:
    peak = largest_peak()
    ax.add_patch(
        Circle(
            (-1.0, 0.0), 1.0 / peak, facecolor="none", edgecolor=INKS["ink"], hatch="////", linewidth=0.8, alpha=0.6,
            label=f"Ms > {peak:g}",
        )
    )  # fmt: skip


def disk_circle(low: float, high: float) -> tuple[float, float]:
    """Centre and radius of the disk of L that factors of the gain from `low` to `high` keep free, from -1/low to -1/high."""
    far, near = -1.0 / low, -1.0 / high
    return 0.5 * (far + near), 0.5 * (near - far)


def _free_disk(subject: Subject, channel: str, ax: Axes) -> None:
    i, found = CHANNELS.index(channel), subject.margins.disk_range
    low, high = float(found.low[0, i]), float(found.high[0, i])
    if 0.0 < low < 1.0:
        centre, radius = disk_circle(low, high)
        ax.add_patch(
            Circle(
                (centre, 0.0), radius, facecolor=INKS["front"], edgecolor=INKS["front"], alpha=0.3,
                linestyle=(0, (3, 1, 1, 1)), label="disk margin, kept free",
            )
        )  # fmt: skip


def nichols_figure(subject: Subject, panels: dict[tuple[str, ...], Curves]) -> Figure:
    """Gain over phase of each loop, with the region of too large a sensitivity."""
    figure, axes = grid(len(panels), 2, 2.7)
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    peak = largest_peak()
    edge = -1.0 + np.exp(1j * angle) / peak
    edge_phase = np.degrees(np.mod(np.angle(edge), 2.0 * np.pi)) - 360.0
    for ax, (group, curves) in zip(axes, panels.items(), strict=True):
        ax.fill(
            edge_phase, 20.0 * np.log10(np.abs(edge)), facecolor="none", edgecolor=INKS["ink"], hatch="////", alpha=0.6,
            linewidth=0.8, label=f"Ms > {peak:g}",
        )  # fmt: skip
        for i in range(len(curves.loop)):
            phase, style = curves.phase[i], style_of(i, len(curves.loop))
            ax.plot(phase, curves.gain[i], label=label_of(curves, i), **style)
        ax.plot([-180.0], [0.0], "+", color=INKS["ink"], markersize=9, markeredgewidth=1.4)
        ax.set_title(name_of(group), fontweight="bold")
        ax.set_xlim(NICHOLS[0])
        ax.set_ylim(NICHOLS[1])
        ax.set_xticks(np.arange(-300.0, -59.0, 30.0))
        ax.set_xlabel("phase of L [deg]")
        ax.set_ylabel("gain of L [dB]")
    legend(figure, axes)
    return figure
