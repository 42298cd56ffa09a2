"""What the air did and how every contender answered: flight 0 of each, in the same air, over the fans of many flights."""

from html import escape
from typing import Any

import numpy as np

from tuner.documents.contest import Contest
from tuner.documents.look import plotly_line
from tuner.documents.results import Fan
from tuner.report.chart import Charts, Panel, Trace, axis, layout, listed
from tuner.report.contest.signals import asked_for, is_calm, signal_title
from tuner.report.response_charts import is_rotor, thinned

REFERENCE = {"width": 1.3, "dash": "2px,3px", "color": "@muted"}


def add_responses(contest: Contest, charts: Charts) -> list[Panel]:
    """Add a figure for every signal of air and vehicles and return their panels, in the order of the files.

    Components of the air that are zero in every scenario are left out.
    """
    blown = [
        signal for signal in dict.fromkeys(entry.signal for entry in contest.air) if not is_calm(contest.air, signal)
    ]
    panels = [_air(contest, charts, signal) for signal in blown]
    units = {entry.signal: entry.unit for entry in [*contest.fans, *contest.traces]}
    for signal in sorted(units, key=is_rotor):
        traces = [*_bands(contest, charts, signal), *_references(contest, signal), *_flights(contest, charts, signal)]
        name = f"response-{signal}"
        charts.add(name, traces, layout(axis("time [s]"), axis(""), hovermode="x"))
        panels.append(Panel(name, "rotor" if is_rotor(signal) else "axis", signal_title(signal, units[signal])))
    return panels


def _air(contest: Contest, charts: Charts, signal: str) -> Panel:
    entries = [entry for entry in contest.air if entry.signal == signal]
    traces = [
        {
            "type": "scatter", "mode": "lines", "x": _shared(charts, f"air-time/{entry.scenario}", entry.time),
            "y": listed(entry.value), "line": {"width": 1, "color": "@ink"}, "meta": {"scenario": entry.scenario},
            "hovertemplate": "%{y:.3~g}<extra></extra>",
        }
        for entry in entries
        if entry.value.any()
    ]  # fmt: skip
    # Where the air of the chosen scenario has no such component, the figure is not shown.
    charts.add(f"response-{signal}", traces, layout(axis("time [s]"), axis(""), hovermode="x", meta={"hides": True}))
    return Panel(f"response-{signal}", "air", signal_title(signal, entries[0].unit))


def _bands(contest: Contest, charts: Charts, signal: str) -> list[Trace]:
    """Return bands and medians of all contenders; the two edges of a band stay neighbours, bands behind all lines."""
    fans = [thinned(fan) for fan in contest.fans if fan.signal == signal and fan.point in contest.look]
    return [edge for fan in fans for edge in _band(contest, charts, fan)] + [
        _median(contest, charts, fan) for fan in fans
    ]


def _band(contest: Contest, charts: Charts, fan: Fan) -> list[Trace]:
    times = _shared(charts, f"fan-time/{fan.scenario}", fan.time)
    meta = {**_meta(contest, fan.point, fan.scenario), "also": "band"}
    edge = {"type": "scatter", "mode": "lines", "x": times, "line": {"width": 0}, "hoverinfo": "skip", "meta": meta}
    fill = f"{contest.look[fan.point].variable}/0.15"
    return [{**edge, "y": listed(fan.low)}, {**edge, "y": listed(fan.high), "fill": "tonexty", "fillcolor": fill}]


def _median(contest: Contest, charts: Charts, fan: Fan) -> Trace:
    return {
        "type": "scatter", "mode": "lines", "x": _shared(charts, f"fan-time/{fan.scenario}", fan.time),
        "y": listed(fan.median), "line": plotly_line(contest.look[fan.point], 1.1),
        "meta": {**_meta(contest, fan.point, fan.scenario), "also": "median"},
        "hovertemplate": f"{escape(fan.point)}, median: %{{y:.3~g}}<extra></extra>",
    }  # fmt: skip


def _flights(contest: Contest, charts: Charts, signal: str) -> list[Trace]:
    return [
        {
            "type": "scatter", "mode": "lines", "x": _shared(charts, f"time/{entry.scenario}", entry.time),
            "y": listed(entry.value), "line": plotly_line(contest.look[entry.contender]),
            "meta": {**_meta(contest, entry.contender, entry.scenario), "also": "flight"},
            "hovertemplate": f"{escape(entry.contender)}: %{{y:.3~g}}<extra></extra>",
        }
        for entry in contest.traces
        if entry.signal == signal and entry.contender in contest.look
    ]  # fmt: skip


def _references(contest: Contest, signal: str) -> list[Trace]:
    """Return the reference of each scenario; where contenders have different ones, or none, there is none."""
    traces = []
    for scenario in contest.scenarios:
        asked = asked_for(contest, scenario, signal)
        if asked is not None:
            shown = {
                "type": "scatter",
                "mode": "lines",
                "x": listed(asked[0]),
                "y": listed(asked[1]),
                "line": REFERENCE,
            }
            text = "reference: %{y:.3~g}<extra></extra>"
            traces.append({**shown, "meta": {"scenario": scenario}, "hovertemplate": text})
    return traces


def _meta(contest: Contest, name: str, scenario: str) -> dict[str, Any]:
    """Return when a trace of a contender is visible; "point" is what page.js calls the choice of the airframe."""
    airframe = contest.contenders[contest.index[name]].airframe
    meta = {"scenario": scenario, "layer": contest.layer(name)}
    return meta | ({"point": airframe} if len(contest.airframes) > 1 else {})


def _shared(charts: Charts, name: str, values: np.ndarray) -> str:
    """Return the shared array of times; all signals of a scenario have the same, or the array gets a name of its own."""
    times = listed(values)
    while charts.shared.get(name, times) != times:
        name += "+"
    return charts.share(name, times)
