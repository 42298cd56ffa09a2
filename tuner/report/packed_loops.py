"""Margins and loop transfer functions of every finalist for the page.

    channels     names of the loops; frequency [rad/s], packed
    quantities   [{name, label, unit, factor, decibel, meaning}], how stored values are shown
    points       {POINT: [{channel, stable, values: {QUANTITY: number or null}, case, curve or as}]}

A curve is all real parts, then all imaginary ones, packed; `as` names the channel whose curve is the same.
"""

from math import pi
from typing import Any

import numpy as np

from tuner.documents.results import Loop, Results
from tuner.report.packing import singles

# Name in margins.parquet, label, unit shown, factor to it, whether it is shown in dB, meaning.
QUANTITIES = (
    ("gain_up", "gain margin up", "dB", 1.0, True, "how far the loop gain may rise before the loop is unstable"),
    ("gain_down", "gain margin down", "dB", 1.0, True, "how far the loop gain may fall before the loop is unstable"),
    ("phase_margin", "phase margin", "°", 180.0 / pi, False, "least phase lag, or lead, that makes the loop unstable"),
    ("delay_margin", "delay margin", "ms", 1e3, False, "delay on top of what there is that makes the loop unstable"),
    ("ms", "Ms", "", 1.0, False, "peak of the sensitivity: how much the loop amplifies disturbances at worst"),
    ("mt", "Mt", "", 1.0, False, "peak of the complementary sensitivity: how much the reference is amplified at worst"),
    ("disk", "disk margin", "", 1.0, False, "size of the disk of simultaneous gain and phase changes that the loop bears"),
    ("bandwidth", "bandwidth", "rad/s", 1.0, False, "frequency up to which the reference is followed to within −3 dB"),
)  # fmt: skip


def packed_loops(results: Results) -> dict[str, Any] | None:
    """Return margins and curves of all points, None where the folder holds none."""
    if not results.loops:
        return None
    by_point: dict[str, list[Loop]] = {}
    for loop in results.loops:
        by_point.setdefault(loop.point, []).append(loop)
    keys = ("name", "label", "unit", "factor", "decibel", "meaning")
    return {
        "channels": list(dict.fromkeys(loop.channel for loop in results.loops)),
        "frequency": singles(results.loops[0].frequency),
        "quantities": [dict(zip(keys, entry, strict=True)) for entry in QUANTITIES],
        "points": {point: _loops(entries) for point, entries in by_point.items()},
    }


def _loops(entries: list[Loop]) -> list[dict[str, Any]]:
    rows, seen = [], []
    for loop in entries:
        row = {"channel": loop.channel, "stable": loop.stable, "case": loop.case}
        row["values"] = {name: loop.values.get(name) for name, *_ in QUANTITIES}
        same = next((other for other in seen if np.array_equal(other.response, loop.response)), None)
        if same is not None:
            row["as"] = same.channel
        else:
            row["curve"] = singles(np.concatenate([np.real(loop.response), np.imag(loop.response)]))
            seen.append(loop)
        rows.append(row)
    return rows
