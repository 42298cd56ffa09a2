"""Margins and loop transfer functions of every finalist for the page.

    channels     names of the loops; frequency [rad/s], packed
    quantities   [{name, label, unit, factor, decibel, meaning}], how stored values are shown
    points       {POINT: [{channel, stable, values: {QUANTITY: number or null}, case, curve or as}]}

A curve is all real parts, then all imaginary ones, packed; `as` names the channel whose curve is the same.
"""

from typing import Any

import numpy as np

from objectives.margins.quantities import QUANTITIES
from objectives.scales import DECIBEL
from tuner.documents.loading_finalists import LOOP_MARGINS
from tuner.documents.results import Loop, Results
from tuner.report.packing import singles


def packed_loops(results: Results) -> dict[str, Any] | None:
    """Return margins and curves of all points, None where the folder holds none."""
    if not results.loops:
        return None
    by_point: dict[str, list[Loop]] = {}
    for loop in results.loops:
        by_point.setdefault(loop.point, []).append(loop)
    return {
        "channels": list(dict.fromkeys(loop.channel for loop in results.loops)),
        "frequency": singles(results.loops[0].frequency),
        "quantities": [_quantity(name) for name in LOOP_MARGINS],
        "points": {point: _loops(entries) for point, entries in by_point.items()},
    }


def _quantity(name: str) -> dict[str, Any]:
    """Return how the page shows a margin quantity: in dB, or by a factor."""
    entry = QUANTITIES[name]
    decibel = entry.scale is DECIBEL
    unit = {"1": "", "deg": "°"}.get(entry.shown_unit, entry.shown_unit)
    factor = 1.0 if decibel else float(entry.shown(1.0))
    about = {"unit": unit, "factor": factor, "decibel": decibel, "meaning": entry.meaning}
    return {"name": name, "label": entry.label, **about}


def _loops(entries: list[Loop]) -> list[dict[str, Any]]:
    rows, seen = [], []
    for loop in entries:
        row = {"channel": loop.channel, "stable": loop.stable, "case": loop.case}
        row["values"] = {name: loop.values.get(name) for name in LOOP_MARGINS}
        same = next((other for other in seen if np.array_equal(other.response, loop.response)), None)
        if same is not None:
            row["as"] = same.channel
        else:
            row["curve"] = singles(np.concatenate([np.real(loop.response), np.imag(loop.response)]))
            seen.append(loop)
        rows.append(row)
    return rows
