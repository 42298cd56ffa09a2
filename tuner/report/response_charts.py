"""Monte Carlo fans of every axis and rotor: one small figure a signal, of which page.js shows the chosen points."""

from itertools import groupby

import numpy as np

from tuner.report.chart import COLOURS, DASHES, Charts, Panel, Trace, axis, layout, listed
from tuner.report.results import DEFAULT, Fan, Results
from tuner.report.units import bracketed

TITLES = {
    **{axis: f"position {axis}" for axis in "xyz"},
    **{angle: f"{angle} angle" for angle in ("roll", "pitch", "yaw")},
    **{f"rotor{i}": f"rotor {i}" for i in range(1, 5)},
}
ROTOR_UNIT = "hover thrust"
# Instants drawn of a fan at most; the width of a small figure in pixels.
MOST_INSTANTS = 400


def title(fan: Fan) -> str:
    """Return the heading of a signal with its unit."""
    unit = ROTOR_UNIT if is_rotor(fan.signal) else fan.unit
    return bracketed(TITLES.get(fan.signal, fan.signal), unit)


def is_rotor(signal: str) -> bool:
    """Say whether a signal is a rotor command, in hover thrusts, and not an axis."""
    return signal.startswith("rotor")


def add_responses(results: Results, charts: Charts) -> list[Panel]:
    """Add a figure for every signal and return their panels, axes first; none where there are no responses."""
    fans = [thinned(fan) for fan in results.fans]
    by_signal = {fan.signal: [other for other in fans if other.signal == fan.signal] for fan in fans}
    order = sorted(by_signal, key=is_rotor)
    panels = []
    for signal in order:
        shown = by_signal[signal]
        # The default behind all others, and all bands behind all lines.
        shown = sorted(shown, key=lambda fan: results.front.role(fan.point) != DEFAULT)
        traces = [edge for fan in shown for edge in _band(results, charts, fan)]
        traces += _references(results, charts, shown)
        traces += [_median(results, charts, fan) for fan in shown]
        span = _common_range(fans) if is_rotor(signal) else {}
        name = f"response-{signal}"
        charts.add(name, traces, layout(axis("time [s]"), axis("", **span), hovermode="x"))
        panels.append(Panel(name, "rotor" if is_rotor(signal) else "axis", title(shown[0])))
    return panels


def thinned(fan: Fan) -> Fan:
    """Return a fan with at most `MOST_INSTANTS` instants; the band keeps the extremes of the instants left out."""
    step = -(-len(fan.time) // MOST_INSTANTS)
    if step <= 1:
        return fan
    starts = np.arange(0, len(fan.time), step)
    return Fan(
        fan.point, fan.scenario, fan.signal, fan.unit, fan.time[starts], fan.reference[starts],
        np.minimum.reduceat(fan.low, starts), fan.median[starts], np.maximum.reduceat(fan.high, starts),
    )  # fmt: skip


def role_of(results: Results, point: str) -> str:
    """Return the kind of a point with responses: "default", "tuned" or "other"."""
    return results.front.role(point) or "other"


def _band(results: Results, charts: Charts, fan: Fan) -> list[Trace]:
    """Return lower and upper edge, filled in between; they must stay neighbours."""
    low, high = _edges(charts, fan)
    fill = f"{COLOURS[role_of(results, fan.point)]}/0.2"
    edge = {**_line(charts, fan), "line": {"width": 0}, "hoverinfo": "skip"}
    return [{**edge, "y": low}, {**edge, "y": high, "fill": "tonexty", "fillcolor": fill}]


def _median(results: Results, charts: Charts, fan: Fan) -> Trace:
    role = role_of(results, fan.point)
    return {
        **_line(charts, fan),
        "y": listed(fan.median),
        "line": {"width": 1.8, "color": COLOURS[role], "dash": DASHES[role]},
        "customdata": {"zip": list(_edges(charts, fan))},
        "hovertemplate": f"{fan.point if role == 'other' else role}: %{{y:.3~f}} "
        "[%{customdata[0]:.3~f}, %{customdata[1]:.3~f}]<extra></extra>",
    }


def _line(charts: Charts, fan: Fan) -> Trace:
    meta = {"point": fan.point, "scenario": fan.scenario}
    return {"type": "scatter", "mode": "lines", "x": _time(charts, fan), "meta": meta}


def _edges(charts: Charts, fan: Fan) -> tuple[str, str]:
    key = f"{fan.scenario}/{fan.point}/{fan.signal}"
    return charts.share(f"{key}/low", listed(fan.low)), charts.share(f"{key}/high", listed(fan.high))


def _references(results: Results, charts: Charts, fans: list[Fan]) -> list[Trace]:
    """Return the references as dashed lines: one for all points of a scenario where they agree, else one a point."""
    traces = []
    for _, group in groupby(sorted(fans, key=lambda fan: fan.scenario), key=lambda fan: fan.scenario):
        same = list(group)
        common = all(np.array_equal(fan.reference, same[0].reference, equal_nan=True) for fan in same)
        for fan in same[:1] if common else same:
            if np.isfinite(fan.reference).any():
                colour = "@muted" if common else f"{COLOURS[role_of(results, fan.point)]}/0.75"
                line = _line(charts, fan)
                look = {"width": 1.3, "dash": "2px,3px", "color": colour}
                template = "reference: %{y:.3~f}<extra></extra>"
                meta = {"scenario": fan.scenario} if common else line["meta"]
                shown = {"y": listed(fan.reference), "line": look, "hovertemplate": template, "meta": meta}
                traces.append({**line, **shown})
    return traces


def _time(charts: Charts, fan: Fan) -> str:
    """Return the shared array of times of a fan; all fans of a scenario have the same."""
    values = listed(fan.time)
    name = f"time/{fan.scenario}"
    if charts.shared.get(name, values) != values:
        name = f"time/{fan.scenario}/{fan.point}/{fan.signal}"
    return charts.share(name, values)


def _common_range(fans: list[Fan]) -> dict[str, list[float]]:
    """Return one range for all rotors, so that they can be compared."""
    rotors = [fan for fan in fans if is_rotor(fan.signal)]
    low, high = min(float(fan.low.min()) for fan in rotors), max(float(fan.high.max()) for fan in rotors)
    margin = 0.05 * (high - low) or 0.1
    return {"range": [low - margin, high + margin]}
