"""Names and references of recorded signals, and what follows from them: errors and rates of angles."""

import tomllib
from collections.abc import Iterable

import numpy as np

from tuner.documents.comparison import Air, ComparedFolder, Trace
from tuner.report.charts.fans import ROTOR_UNIT, TITLES, is_rotor
from tuner.text.units import bracketed

AIR_TITLES = {
    "wind": "wind {}",
    "gust_rate": "gust rate {}",
    "acceleration": "injected acceleration {}",
    "angular_acceleration": "injected angular acceleration {}",
}
HORIZONTAL = ("x", "y")
# The kind of reference that holds attitude and height, and lets the vehicle drift.
DRIFTING = "level"


def signal_title(signal: str, unit: str) -> str:
    """Return the heading of a signal with its unit."""
    kind, _, end = signal.rpartition("_")
    if kind in AIR_TITLES:
        return bracketed(AIR_TITLES[kind].format(end), unit)
    return bracketed(TITLES.get(signal, signal), ROTOR_UNIT if is_rotor(signal) else unit)


def is_calm(air: Iterable[Air], signal: str) -> bool:
    """Say whether a component of the air is zero throughout all flights."""
    return not any(entry.value.any() for entry in air if entry.signal == signal)


def drifts(compared: ComparedFolder, scenario: str) -> bool:
    """Say whether the study file lets x and y of a scenario run free, so that there is no position to hold."""
    try:
        tables = tomllib.loads(compared.study_text).get("scenario", [])
        kinds = {table["name"]: table["reference"]["kind"] for table in tables}
    except (tomllib.TOMLDecodeError, KeyError, TypeError, AttributeError):
        return False
    return kinds.get(scenario) == DRIFTING


def asked_for(compared: ComparedFolder, scenario: str, signal: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Return time [s] and reference of a signal; None where contenders have different ones, as of roll under a position
    loop, or there is none.
    """
    if signal in HORIZONTAL and drifts(compared, scenario):
        return None
    traces = [entry for entry in compared.traces if (entry.signal, entry.scenario) == (signal, scenario)]
    if not traces or not np.isfinite(traces[0].reference).all():
        return None
    first = traces[0]
    same = all(np.array_equal(first.reference, entry.reference) for entry in traces)
    return (first.time, first.reference) if same else None


def error(trace: Trace) -> np.ndarray:
    """Return value minus reference (instants,), NaN where there is no reference."""
    return trace.value - trace.reference


def rate(trace: Trace) -> np.ndarray:
    """Return the rate of a signal (instants,) by central differences over its instants."""
    return np.gradient(trace.value, trace.time) if len(trace.time) > 1 else np.zeros_like(trace.value)
