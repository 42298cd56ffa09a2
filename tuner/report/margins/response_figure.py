"""Figure of the linear step and load responses of each loop over the amplitudes of its nonlinear terms."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plant.cascade import ATTITUDE_AXES
from tuner.analysis.margins.time_response import LinearResponses
from tuner.report.charts.paper import grid
from tuner.report.margins.loop_figures import BAND, RULE, legend, name_of, style_of

# Responses that differ by less than this at no time are one: the loop depends on no amplitude.
ALIKE = 1e-9


def response_figure(panels: dict[tuple[str, ...], LinearResponses], labels: tuple[str, ...]) -> Figure:
    """Steps of the set point above steps of the load; labels: of the amplitudes, one for loops that depend on none."""
    n = len(panels)
    figure, axes = grid(2 * n, n, 1.9)
    for j, (group, responses) in enumerate(panels.items()):
        unit = "rad per rad/s²" if group[0] in ATTITUDE_AXES else "m per m/s²"
        for ax, values in ((axes[j], responses.step), (axes[n + j], responses.load)):
            _draw(ax, responses.time, values, labels)
            ax.set_xlim(0.0, responses.time[-1])
        axes[j].axhline(1.0, **RULE)
        axes[n + j].axhline(0.0, **RULE)
        axes[j].set_title(name_of(group), fontweight="bold")
        axes[n + j].set_xlabel("time [s]")
        axes[n + j].set_title(unit, fontsize=7.5, loc="left")
        axes[j].set_ylim(-0.1, max(1.3, min(float(np.nanmax(np.append(responses.step, 1.0))) + 0.1, 3.0)))
        axes[j].tick_params(labelleft=j == 0)
    axes[0].set_ylabel("output after a\nunit step of the set point")
    axes[n].set_ylabel("output after a\nunit step of the load")
    legend(figure, axes)
    return figure


def _draw(ax: Axes, time: np.ndarray, values: np.ndarray, labels: tuple[str, ...]) -> None:
    """Draw the cases that are stable, and say which are not."""
    kept, last = np.isfinite(values).all(axis=1), len(values) - 1
    if not kept.all():
        words = "not stable" if not kept.any() else f"stable at {kept.sum()} of\n{last + 1} amplitudes"
        ax.text(0.97, 0.6, words, transform=ax.transAxes, ha="right", va="center", fontsize=7)
    if not kept.any():
        return
    if last == 0 or np.ptp(values[kept], axis=0).max(initial=0.0) < ALIKE:
        ax.plot(time, values[kept][0], **style_of(0, 1))
        return
    ax.fill_between(time, values[kept].min(axis=0), values[kept].max(axis=0), **BAND)
    for i in np.flatnonzero(kept):
        label = labels[i] if i in (0, last) else "amplitudes between"
        ax.plot(time, values[i], label=label, **style_of(int(i), len(values)))
