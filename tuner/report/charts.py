"""The data of the page's charts: plain JSON that page.js turns into Plotly figures in the reader's colours."""

from typing import Any

import numpy as np

from tuner.report.figures import axis_range
from tuner.report.numbers import compact
from tuner.report.results import DEFAULT, TUNED, Fan, Results
from tuner.report.units import bracketed

# Candidates drawn behind the front at most; more only slow the page.
MOST_CANDIDATES = 3000


def chart_data(results: Results) -> dict[str, Any]:
    """Return everything that page.js draws."""
    return {
        "objectives": [
            {"label": entry.label, "axis": bracketed(entry.label, entry.unit), **_range(results, i)}
            for i, entry in enumerate(results.objectives)
        ],
        "candidates": candidates(results),
        "front": front(results),
        "history": {
            "flights": results.history.flights.tolist(),
            "hypervolume": rounded(results.history.hypervolume),
            "feasible": rounded(results.history.feasible_share),
        },
        "fans": [fan_data(fan) for fan in results.fans],
        "points": [{"name": name, "role": results.front.role(name)} for name in results.flown_points],
        "scenarios": results.scenarios,
    }


def rounded(values: np.ndarray) -> list[float | None]:
    """Return numbers with five digits, None where they are not finite."""
    return [compact(float(value)) for value in np.ravel(values)]


def _range(results: Results, column: int) -> dict[str, Any]:
    low, high, scale = axis_range(results.front, column)
    return {"low": low, "high": high, "scale": scale}


def candidates(results: Results) -> dict[str, Any]:
    """Return what the search tried, thinned evenly where it is much."""
    tried = results.candidates
    keep = np.unique(np.linspace(0, len(tried.number) - 1, MOST_CANDIDATES).astype(int))
    return {
        "values": [rounded(tried.values[keep, i]) for i in range(tried.values.shape[1])],
        "feasible": tried.feasible[keep].tolist(),
        "number": tried.number[keep].tolist(),
    }


def front(results: Results) -> list[dict[str, Any]]:
    """Return the points flown on held-out scenarios, with gains for the hover text."""
    entries = results.front
    return [
        {
            "name": name,
            "role": entries.roles[k],
            "best": bool(entries.non_dominated[k]),
            "feasible": bool(entries.feasible[k]),
            "value": rounded(entries.held_out[k]),
            "low": rounded(entries.low[k]),
            "high": rounded(entries.high[k]),
            "search": rounded(entries.search[k]),
            "gains": [
                f"{variable.name} = {float(gain):.4g} {variable.unit if variable.unit != '1' else ''}".strip()
                for variable, gain in zip(results.variables, entries.gains[k], strict=True)
            ],
        }
        for k, name in enumerate(entries.points)
    ]


def fan_data(fan: Fan) -> dict[str, Any]:
    """Return one fan."""
    return {
        "point": fan.point, "scenario": fan.scenario, "signal": fan.signal, "axis": bracketed(fan.signal, fan.unit),
        "time": rounded(fan.time), "reference": rounded(fan.reference), "low": rounded(fan.low),
        "median": rounded(fan.median), "high": rounded(fan.high),
    }  # fmt: skip


def role_title(role: str) -> str:
    """Return what a role is called on the page."""
    return {DEFAULT: "default gains", TUNED: "tuned"}.get(role, "finalist")
