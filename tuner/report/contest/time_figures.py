"""Time responses for a paper, in the order of the figures 6 to 12 of Wu et al., Appl. Sci. 2025, 15(9), 5124.

Lines are flight 0, in the same air for all contenders; bands hold 5 to 95 % of many flights. A column is an airframe, a row
an axis. Positions are drawn of the first scenario that holds one, attitudes of the first scenario that holds nothing but
attitude, else of the first.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from tuner.documents.contest import Air, ComparedFolder, Trace
from tuner.documents.tables import Fan
from tuner.report.charts.look import INKS, Look
from tuner.report.charts.paper import grid
from tuner.report.contest.controls import looks_of
from tuner.report.contest.signals import asked_for, drifts, error, is_calm, rate, signal_title
from tuner.text.units import bracketed

POSITION, ATTITUDE = ("x", "y", "z"), ("roll", "pitch", "yaw")
# Kinds of disturbance in the order of preference: what is injected says more than the air it stands for.
LINEAR, ANGULAR = ("acceleration", "wind"), ("angular_acceleration", "gust_rate")
ROW = 1.45
# Marks along a line, so that it is known without colour where dashes run close together.
MARKS = 8
# How far beyond the lines bands are shown, as a share of what the lines span.
BEYOND = 0.6


class Kind(NamedTuple):
    """What is drawn of a signal: its values (instants,), its heading, and whether its fan can be drawn.

    offset: what the fan is above it: "none", "reference" or "no fan".
    """

    values: Callable[[Trace], np.ndarray]
    title: Callable[[Trace], str]
    offset: str


VALUE = Kind(lambda trace: trace.value, lambda trace: signal_title(trace.signal, trace.unit), "none")
ERROR = Kind(error, lambda trace: bracketed(f"error of {trace.signal}", trace.unit), "reference")
RATE = Kind(rate, lambda trace: bracketed(f"rate of {trace.signal}", f"{trace.unit}/s"), "no fan")


def position_disturbance(contest: ComparedFolder) -> Figure | None:
    """Return what pushes the vehicle in flight 0: injected accelerations, else the wind."""
    return _disturbance(contest, held_scenario(contest), LINEAR)


def attitude_disturbance(contest: ComparedFolder) -> Figure | None:
    """Return what turns the vehicle in flight 0: injected angular accelerations, else the rates of the gusts."""
    return _disturbance(contest, levelled_scenario(contest), ANGULAR)


def positions(contest: ComparedFolder) -> Figure | None:
    """Return positions with their reference."""
    return _responses(contest, held_scenario(contest), POSITION, VALUE)


def angles(contest: ComparedFolder) -> Figure | None:
    """Return attitude angles, with their reference where all contenders have the same."""
    return _responses(contest, levelled_scenario(contest), ATTITUDE, VALUE)


def position_errors(contest: ComparedFolder) -> Figure | None:
    """Return positions minus their reference."""
    return _responses(contest, held_scenario(contest), POSITION, ERROR)


def angle_errors(contest: ComparedFolder) -> Figure | None:
    """Return attitude angles minus what was asked of each contender, by the reference or by its own position loop."""
    return _responses(contest, levelled_scenario(contest), ATTITUDE, ERROR)


def angle_rates(contest: ComparedFolder) -> Figure | None:
    """Return the rates of the attitude angles, by differences of the recorded angles."""
    return _responses(contest, levelled_scenario(contest), ATTITUDE, RATE)


def held_scenario(contest: ComparedFolder) -> str | None:
    """Return the first scenario in which a position is held, None where there is none."""
    return next((name for name in contest.scenarios if not drifts(contest, name)), None)


def levelled_scenario(contest: ComparedFolder) -> str | None:
    """Return the first scenario in which nothing but the attitude is held, else the first, None where there is none."""
    level = [name for name in contest.scenarios if drifts(contest, name)]
    return next(iter([*level, *contest.scenarios]), None)


def _disturbance(contest: ComparedFolder, scenario: str | None, kinds: tuple[str, ...]) -> Figure | None:
    blown = [entry for entry in contest.air if entry.scenario == scenario]
    for kind in kinds:
        shown = [entry for entry in blown if entry.signal.rpartition("_")[0] == kind]
        if any(not is_calm(shown, entry.signal) for entry in shown):
            return _air(shown, str(scenario))
    return None


def _air(shown: list[Air], scenario: str) -> Figure:
    figure, axes = grid(len(shown), 1, ROW)
    for ax, entry in zip(axes, shown, strict=True):
        ax.plot(entry.time, entry.value, color=INKS["ink"], linewidth=0.7)
        ax.set_ylabel(
            signal_title(entry.signal, entry.unit).replace("angular acc", "angular\nacc").replace(" [", "\n[")
        )
    _time_axes(axes, 1, shown[0].time)
    _note(figure, f"scenario {scenario}, flight 0")
    return figure


def _responses(contest: ComparedFolder, scenario: str | None, signals: tuple[str, ...], kind: Kind) -> Figure | None:
    traces = [entry for entry in contest.traces if entry.scenario == scenario and entry.signal in signals]
    traces = [entry for entry in traces if entry.contender in contest.index and np.isfinite(kind.values(entry)).all()]
    present = [signal for signal in signals if any(entry.signal == signal for entry in traces)]
    if not present:
        return None
    columns = len(contest.airframes)
    figure, axes = grid(len(present) * columns, columns, ROW)
    for number, ax in enumerate(axes):
        signal, airframe = present[number // columns], contest.airframes[number % columns]
        names = [entry.name for entry in contest.contenders if entry.airframe == airframe]
        _panel(contest, ax, [entry for entry in traces if entry.signal == signal and entry.contender in names], kind)
    for ax, airframe in zip(axes[:columns], contest.airframes, strict=True):
        _legend(ax, airframe if columns > 1 else None)
    _time_axes(axes, columns, traces[0].time)
    _note(figure, f"scenario {scenario}, flight 0{_remarks(axes, kind, traces[0])}")
    return figure


def _panel(contest: ComparedFolder, ax: Axes, traces: list[Trace], kind: Kind) -> None:
    bands = []
    for number, trace in enumerate(traces):
        look = looks_of(contest)[trace.contender]
        fan = _fan(contest, trace, kind)
        if fan is not None:
            ax.fill_between(fan.time, fan.low, fan.high, color=look.ink, alpha=0.13, linewidth=0)
            bands.append((float(fan.low.min(axis=0)), float(fan.high.max(axis=0))))
        _line(ax, trace, kind, look, number)
    if not traces:
        return
    asked = asked_for(contest, traces[0].scenario, traces[0].signal)
    if asked is not None and kind is VALUE:
        ax.plot(*asked, linestyle=(0, (1, 1.5)), linewidth=0.9, color=INKS["ink"], zorder=2)
    ax.set_ylabel(kind.title(traces[0]))
    _frame(ax, bands)


def _line(ax: Axes, trace: Trace, kind: Kind, look: Look, number: int) -> None:
    every = max(1, len(trace.time) // MARKS)
    ax.plot(
        trace.time, kind.values(trace), color=look.ink, linestyle=look.linestyle, label=trace.contender, marker=look.marker,
        markersize=3, markerfacecolor="white" if look.hollow else look.ink, markeredgewidth=0.7, zorder=3,
        markevery=((2 * number + 1) * every // 6, every),
    )  # fmt: skip


def _frame(ax: Axes, bands: list[tuple[float, float]]) -> None:
    """Show all lines, and of the bands what is not far from them: a band far wider than flight 0 would press it flat."""
    values = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in ax.get_lines()])
    low, high = float(values.min(axis=0)), float(values.max(axis=0))
    room = BEYOND * (high - low) or 1.0
    bottom = max(min([low, *[band[0] for band in bands]]), low - room)
    top = min(max([high, *[band[1] for band in bands]]), high + room)
    ax.set_ylim(bottom - 0.05 * (top - bottom), top + 0.05 * (top - bottom))


def _fan(contest: ComparedFolder, trace: Trace, kind: Kind) -> Fan | None:
    """Return the band of a line, None where there is none: rates are not recorded, nor errors from differing references."""
    key = (trace.contender, trace.scenario, trace.signal)
    fan = next((entry for entry in contest.fans if (entry.point, entry.scenario, entry.signal) == key), None)
    if fan is None or kind.offset == "no fan":
        return None
    if kind.offset == "none":
        return fan
    if asked_for(contest, trace.scenario, trace.signal) is None:
        return None
    low, median, high = (edge - fan.reference for edge in (fan.low, fan.median, fan.high))
    return replace(fan, low=low, median=median, high=high)


def _legend(ax: Axes, airframe: str | None) -> None:
    """Put the legend of a column above its first panel, under the name of its airframe."""
    labels = ax.get_legend_handles_labels()[1]
    wide = sum(len(label) + 8 for label in labels) > (60 if airframe else 120)
    ncols = (2 if airframe else 4) if wide else len(labels) or 1
    place: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "borderaxespad": 0.2}
    size: dict[str, Any] = {"fontsize": 6.5, "handlelength": 2.6} if airframe else {"handlelength": 3.2}
    ax.legend(**place, **size, ncols=ncols, columnspacing=1.2, title=airframe, title_fontproperties={"size": 8})


def _time_axes(axes: list[Axes], columns: int, time: np.ndarray) -> None:
    """Give all panels the same time, and its numbers to the last row."""
    # The last instant stands a step before the end of the flight.
    end = float(time[-1] + (time[-1] - time[-2])) if len(time) > 1 else 1.0
    for number, ax in enumerate(axes):
        ax.set_xlim(0.0, end)
        ax.xaxis.set_major_locator(MaxNLocator(nbins=8, steps=[1, 2, 5, 10]))
        last = number >= len(axes) - columns
        ax.tick_params(axis="x", labelbottom=last)
        if last:
            ax.set_xlabel("time [s]")


def _remarks(axes: list[Axes], kind: Kind, trace: Trace) -> str:
    text = "; bands: 5–95 % of flights, which may leave the frame" if any(ax.collections for ax in axes) else ""
    if kind is RATE and len(trace.time) > 1:
        text += f"; by differences over {trace.time[1] - trace.time[0]:.3g} s"
    dotted = kind is VALUE and any(str(line.get_label()).startswith("_") for ax in axes for line in ax.get_lines())
    return text + ("; dotted: reference" if dotted else "")


def _note(figure: Figure, text: str) -> None:
    figure.supxlabel(text, fontsize=6.5, color=INKS["ink"])
