"""Monte Carlo fans for the page, thinned so that the file stays small however many points there are.

    signals     [{name, title, range}], range: a common one for the rotors
    scenarios   [{name, time, references: {SIGNAL: series}, fans: {POINT: {flight, signals: [series or null]}}}]

A series is {scale: [low, step], packed, series: [names]}, see packing.py; references are those that all points share. All of a
scenario have its instants.
"""

from typing import Any

import numpy as np

from tuner.documents.results import Fan, Results
from tuner.report.packing import quantised, singles
from tuner.report.response_charts import is_rotor, thinned, title

# Bytes that all fans together may take in the page, and the instants of a fan: at most as many as a small figure has pixels.
BUDGET = 4.0e6
MOST, LEAST = 400, 60
# Bytes of an instant of one signal: four series in sixteen bits, in base64, and a fifth of some.
INSTANT = 4.4 * 2 * 4 / 3


def packed_responses(results: Results) -> dict[str, Any] | None:
    """Return the fans of as many points as there is room for, None where there are none."""
    if not results.fans:
        return None
    points = kept_points(results)
    most = instants(len(results.fans) * len(points) // len(results.flown_points))
    fans = [thinned(fan, most) for fan in results.fans if fan.point in points]
    names = sorted(dict.fromkeys(fan.signal for fan in fans), key=is_rotor)
    return {
        "signals": [_signal(name, fans) for name in names],
        "scenarios": [
            _scenario(name, names, [fan for fan in fans if fan.scenario == name]) for name in results.scenarios
        ],
    }


def instants(fans: int) -> int:
    """Return how many instants each of so many fans gets."""
    return int(np.clip(BUDGET / (INSTANT * max(fans, 1)), LEAST, MOST))


def kept_points(results: Results) -> set[str]:
    """Return the points whose fans fit in at least so few instants: default and tuned first, the others evenly spread."""
    points = results.flown_points
    each = LEAST * INSTANT * len(results.fans) / len(points)
    room = max(int(BUDGET / each), 2)
    if len(points) <= room:
        return set(points)
    others = points[2:]
    chosen = np.unique(np.linspace(0, len(others) - 1, room - 2).round().astype(int)) if room > 2 else []
    return {*points[:2], *(others[int(i)] for i in chosen)}


def _signal(name: str, fans: list[Fan]) -> dict[str, Any]:
    mine = [fan for fan in fans if fan.signal == name]
    return {"name": name, "title": title(mine[0]), "range": _common_range(fans) if is_rotor(name) else None}


def _common_range(fans: list[Fan]) -> list[float]:
    """Return one range for all rotors, so that they can be compared."""
    rotors = [fan for fan in fans if is_rotor(fan.signal)]
    series = [part for fan in rotors for part in (fan.low, fan.high, fan.worst) if part is not None]
    low, high = min(float(part.min()) for part in series), max(float(part.max()) for part in series)
    margin = 0.05 * (high - low) or 0.1
    return [low - margin, high + margin]


def _scenario(name: str, signals: list[str], fans: list[Fan]) -> dict[str, Any]:
    time = fans[0].time
    fans = [fan for fan in fans if len(fan.time) == len(time)]
    by_signal = {signal: [fan for fan in fans if fan.signal == signal] for signal in signals}
    shared = {signal: group[0].reference for signal, group in by_signal.items() if group and _agree(group)}
    found = {(fan.point, fan.signal): fan for fan in fans}
    points = list(dict.fromkeys(fan.point for fan in fans))
    return {
        "name": name,
        "time": singles(time),
        "references": {key: quantised(part).document() for key, part in shared.items() if np.isfinite(part).all()},
        "fans": {
            point: {
                "flight": next(fan.flight for fan in fans if fan.point == point),
                "signals": [_series(found.get((point, signal)), signal not in shared) for signal in signals],
            }
            for point in points
        },
    }


def _agree(group: list[Fan]) -> bool:
    return all(np.array_equal(fan.reference, group[0].reference, equal_nan=True) for fan in group)


def _series(fan: Fan | None, own_reference: bool) -> dict[str, Any] | None:
    if fan is None:
        return None
    parts = {"low": fan.low, "median": fan.median, "high": fan.high, "worst": fan.worst}
    if own_reference:
        parts["reference"] = fan.reference
    known = {name: part for name, part in parts.items() if part is not None and np.isfinite(part).all()}
    if not {"low", "median", "high"} <= set(known):
        return None
    return {**quantised(np.stack(list(known.values()))).document(), "series": list(known)}


def signals_of(results: Results) -> list[tuple[str, bool]]:
    """Return heading of each signal and whether it is a rotor's, in the order of the page."""
    first = {fan.signal: fan for fan in results.fans}
    return [(title(first[name]), is_rotor(name)) for name in sorted(dict.fromkeys(first), key=is_rotor)]
