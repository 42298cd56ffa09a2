"""Time responses for a paper, in the order of the figures 6 to 12 of Wu et al., Appl. Sci. 2025, 15(9), 5124.

Lines are flight 0, in the same air for all contenders; bands hold 5 to 95 % of many flights. A column is an airframe, a row
an axis. Positions are drawn of the first scenario that holds one, attitudes of the first scenario that holds nothing but
attitude, else of the first.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tuner.documents.comparison import Air, ComparedFolder, Trace
from tuner.documents.tables import Fan
from tuner.report.charts.chart import Axis, Band, Line, Mark, Panel
from tuner.report.charts.look import REFERENCE, Look, looks_of
from tuner.report.charts.paper import Figure, figure_of
from tuner.report.comparison.signals import asked_for, drifts, error, is_calm, rate, signal_title
from tuner.text.units import bracketed

POSITION, ATTITUDE = ("x", "y", "z"), ("roll", "pitch", "yaw")
# Kinds of disturbance in the order of preference: what is injected says more than the air it stands for.
LINEAR, ANGULAR = ("acceleration", "wind"), ("angular_acceleration", "gust_rate")
AIR, OPACITY = Look("ink", width=1.1), 0.13
ROW = 1.45
# Marks along a line, so that it is known without colour where dashes run close together.
MARKS = 8
# How far beyond the lines bands are shown, as a share of what the lines span.
BEYOND = 0.6


class Kind(NamedTuple):
    """Form in which a signal is drawn: its values (instants,), its heading, and whether its fan can be drawn.

    offset: what the fan is above it: "none", "reference" or "no fan".
    """

    values: Callable[[Trace], np.ndarray]
    title: Callable[[Trace], str]
    offset: str


VALUE = Kind(lambda trace: trace.value, lambda trace: signal_title(trace.signal, trace.unit), "none")
ERROR = Kind(error, lambda trace: bracketed(f"error of {trace.signal}", trace.unit), "reference")
RATE = Kind(rate, lambda trace: bracketed(f"rate of {trace.signal}", f"{trace.unit}/s"), "no fan")


def position_disturbance(compared: ComparedFolder) -> Figure | None:
    """Return the disturbing accelerations of flight 0: injected ones, else the wind."""
    return _disturbance(compared, held_scenario(compared), LINEAR)


def attitude_disturbance(compared: ComparedFolder) -> Figure | None:
    """Return the disturbing rotations of flight 0: injected angular accelerations, else the rates of the gusts."""
    return _disturbance(compared, levelled_scenario(compared), ANGULAR)


def positions(compared: ComparedFolder) -> Figure | None:
    """Return positions with their reference."""
    return _responses(compared, held_scenario(compared), POSITION, VALUE)


def angles(compared: ComparedFolder) -> Figure | None:
    """Return attitude angles, with their reference where all contenders have the same."""
    return _responses(compared, levelled_scenario(compared), ATTITUDE, VALUE)


def position_errors(compared: ComparedFolder) -> Figure | None:
    """Return positions minus their reference."""
    return _responses(compared, held_scenario(compared), POSITION, ERROR)


def angle_errors(compared: ComparedFolder) -> Figure | None:
    """Return attitude angles minus what was asked of each contender, by the reference or by its own position loop."""
    return _responses(compared, levelled_scenario(compared), ATTITUDE, ERROR)


def channels(compared: ComparedFolder) -> Figure | None:
    """Return the outputs and commands of a plant of the user's own, each of them a signal; None where a quadrotor flew."""
    if any(entry.plant is None for entry in compared.contenders):
        return None
    signals = tuple(dict.fromkeys(entry.signal for entry in compared.traces))
    return _responses(compared, next(iter(compared.scenarios), None), signals, VALUE)


def angle_rates(compared: ComparedFolder) -> Figure | None:
    """Return the rates of the attitude angles, by differences of the recorded angles."""
    return _responses(compared, levelled_scenario(compared), ATTITUDE, RATE)


def held_scenario(compared: ComparedFolder) -> str | None:
    """Return the first scenario in which a position is held, None where there is none."""
    return next((name for name in compared.scenarios if not drifts(compared, name)), None)


def levelled_scenario(compared: ComparedFolder) -> str | None:
    """Return the first scenario in which nothing but the attitude is held, else the first, None where there is none."""
    level = [name for name in compared.scenarios if drifts(compared, name)]
    return next(iter([*level, *compared.scenarios]), None)


def _disturbance(compared: ComparedFolder, scenario: str | None, kinds: tuple[str, ...]) -> Figure | None:
    blown = [entry for entry in compared.air if entry.scenario == scenario]
    for kind in kinds:
        shown = [entry for entry in blown if entry.signal.rpartition("_")[0] == kind]
        if any(not is_calm(shown, entry.signal) for entry in shown):
            return _air(shown, str(scenario))
    return None


def _air(shown: Sequence[Air], scenario: str) -> Figure:
    panels = []
    for entry in shown:
        # The names of injected accelerations are longer than a panel is high.
        title = signal_title(entry.signal, entry.unit).replace("angular acc", "angular\nacc").replace(" [", "\n[")
        marks = [Line(look=AIR, x=entry.time, y=entry.value)]
        panels.append(Panel("", "", _time(entry.time, entry is shown[-1]), Axis(title), marks))
    return figure_of(panels, 1, ROW, note=f"scenario {scenario}, flight 0")


def _responses(compared: ComparedFolder, scenario: str | None, signals: tuple[str, ...], kind: Kind) -> Figure | None:
    traces = [entry for entry in compared.traces if entry.scenario == scenario and entry.signal in signals]
    traces = [entry for entry in traces if entry.contender in compared.index and np.isfinite(kind.values(entry)).all()]
    present = [signal for signal in signals if any(entry.signal == signal for entry in traces)]
    if not present:
        return None
    airframes, panels = compared.flown, []
    for signal in present:
        for airframe in airframes:
            names = [entry.name for entry in compared.contenders if entry.flown == airframe]
            mine = [entry for entry in traces if entry.signal == signal and entry.contender in names]
            panel = _panel(compared, mine, kind, _time(traces[0].time, signal == present[-1]))
            first = signal == present[0]
            panels.append(replace(panel, title=airframe if len(airframes) > 1 else "", legend=first))
    note = f"scenario {scenario}, flight 0{_remarks(panels, kind, traces[0])}"
    return figure_of(panels, len(airframes), ROW, note=note)


def _panel(compared: ComparedFolder, traces: Sequence[Trace], kind: Kind, x: Axis) -> Panel:
    bands: list[Band] = []
    lines: list[Line] = []
    for number, trace in enumerate(traces):
        look, every = looks_of(compared)[trace.contender], max(1, len(trace.time) // MARKS)
        fan = _fan(compared, trace, kind)
        if fan is not None:
            bands.append(Band(look=look._replace(opacity=OPACITY), x=fan.time, low=fan.low, high=fan.high))
        marked = slice((2 * number + 1) * every // 6, None, every)
        lines.append(Line(name=trace.contender, look=look, x=trace.time, y=kind.values(trace), marked=marked))
    if not traces:
        return Panel("", "", x, Axis(""), [])
    reference = asked_for(compared, traces[0].scenario, traces[0].signal)
    if reference is not None and kind is VALUE:
        lines.append(Line(look=REFERENCE, x=reference[0], y=reference[1]))
    y = Axis(kind.title(traces[0]), *_frame(lines, bands))
    return Panel("", "", x, y, [*bands, *lines])


def _frame(lines: Sequence[Line], bands: Sequence[Band]) -> tuple[float, float]:
    """Return the ends that show all lines, and of the bands what is near: one far wider than flight 0 would press it flat."""
    values = np.concatenate([line.y for line in lines])
    low, high = float(values.min(axis=0)), float(values.max(axis=0))
    room = BEYOND * (high - low) or 1.0
    bottom = max(min([low, *[float(band.low.min(axis=0)) for band in bands]]), low - room)
    top = min(max([high, *[float(band.high.max(axis=0)) for band in bands]]), high + room)
    air = 0.05 * (top - bottom)
    return bottom - air, top + air


def _fan(compared: ComparedFolder, trace: Trace, kind: Kind) -> Fan | None:
    """Return the band of a line, None where there is none: rates are not recorded, nor errors from differing references."""
    key = (trace.contender, trace.scenario, trace.signal)
    fan = next((entry for entry in compared.fans if (entry.point, entry.scenario, entry.signal) == key), None)
    if fan is None or kind.offset == "no fan":
        return None
    if kind.offset == "none":
        return fan
    if asked_for(compared, trace.scenario, trace.signal) is None:
        return None
    low, median, high = (edge - fan.reference for edge in (fan.low, fan.median, fan.high))
    return replace(fan, low=low, median=median, high=high)


def _time(time: np.ndarray, last: bool) -> Axis:
    """Return the axis of time; the last row of panels shows its numbers for all."""
    # The last instant stands a step before the end of the flight.
    end = float(time[-1] + (time[-1] - time[-2])) if len(time) > 1 else 1.0
    return Axis("time [s]", 0.0, end, bare=not last)


def _remarks(panels: Sequence[Panel], kind: Kind, trace: Trace) -> str:
    marks: list[Mark] = [mark for panel in panels for mark in panel.marks]
    text = "; bands: 5–95 % of flights, which may leave the frame" if any(isinstance(m, Band) for m in marks) else ""
    if kind is RATE and len(trace.time) > 1:
        text += f"; by differences over {trace.time[1] - trace.time[0]:.3g} s"
    return text + ("; dotted: reference" if any(mark.look == REFERENCE for mark in marks) else "")
