"""Charts of settings laid over each other: the report's panels with a layer for each setting."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tuner.documents.tables import Fan
from tuner.documents.tuning_tables import Loop
from tuner.report.charts import fans
from tuner.report.charts.chart import Axis, Band, Disc, Mark, Panel
from tuner.report.charts.look import DEFAULT, TUNED, Look
from tuner.report.charts.loops import GAIN_SHOWN, axes_of, bode_marks, loop_panels, nyquist_marks

Array = np.ndarray
LOOKS = {
    "default": DEFAULT,
    "tuned": TUNED,
    "pin1": Look("c4", "triangle-up", dash=(9, 3, 2, 3), size=10),
    "pin2": Look("c6", "triangle-down", dash=(4, 2), size=10),
    "pin3": Look("c5", "hexagon", dash=(12, 3, 2, 2, 2, 3), size=10),
    "pin4": Look("c7", "x", dash=(14, 4), size=10),
    "here": Look("other", "circle", size=12, width=2.4),
}
"""Key of a setting -> its look, from back to front."""
FORBIDDEN = Look("bad", opacity=0.12)
"""Look of the part that a limit forbids."""
LOOP_AIDS = {
    "loop-gain": "Bars are gain margins; a bar that ends in the shaded part violates the limit.",
    "loop-phase": "Bars are phase margins; a bar that ends in the shaded part violates the limit.",
    "loop-nyquist": "The shaded disc is what the limit on Ms forbids.",
}
"""Key of a panel -> line on how to read it."""
MAX_INSTANTS = 200
"""Instants of a band; a chart of the page has hardly more pixels."""


def ordered(keys: Sequence[str]) -> list[int]:
    """Return the order in which settings are drawn: the one at hand last, on top."""
    places = list(LOOKS)
    return sorted(range(len(keys)), key=lambda i: places.index(keys[i]))


def response_panels(by_key: Mapping[str, Sequence[Fan]], names: Mapping[str, str]) -> list[Panel]:
    """Return a panel for each signal with the bands of all settings.

    Args:
        by_key: Fans of each setting by its key.
        names: Name of each setting by its key.
    """
    first = next(iter(by_key.values()))
    signals = fans.shown_signals([fan.signal for fan in first])
    return [_signal(k, signal, by_key, names) for k, signal in enumerate(signals)]


def _signal(k: int, signal: str, by_key: Mapping[str, Sequence[Fan]], names: Mapping[str, str]) -> Panel:
    mine = {key: next(fan for fan in every if fan.signal == signal) for key, every in by_key.items()}
    keys, marks = list(mine), list[Mark]()
    shared = fans.agree(list(mine.values()))
    for i in ordered(keys):
        key, fan = keys[i], fans.thinned(mine[keys[i]], MAX_INSTANTS)
        if not shared:
            marks += fans.reference(fan.time, fan.reference, {"layer": key})
        marks += fans.fan_marks(fan, LOOKS[key], names[key], {"layer": key})
    first = mine[keys[0]]
    if shared:
        marks += fans.reference(first.time, first.reference, {})
    form = "plot rotor" if fans.is_rotor(signal) else "plot"
    return Panel(f"response-{k}", fans.title(signal, first.unit), fans.TIME, Axis(""), marks, form=form, across=True)


def margin_panels(loops: Mapping[str, Loop], names: Mapping[str, str], limits: Mapping[str, float]) -> list[Panel]:
    """Return Bode and Nyquist of all settings, with shaded limits.

    Args:
        loops: Loop of each setting by its key.
        names: Name of each setting by its key.
        limits: Limits to shade, see `shaded_limits`.
    """
    axes = axes_of([(loop.frequency, loop.response) for loop in loops.values()])
    over, under, plane = list[Mark](), list[Mark](), list[Mark]()
    keys = list(loops)
    for i in ordered(keys):
        key, loop = keys[i], loops[keys[i]]
        show = {"layer": key}
        gain, phase = bode_marks(loop.frequency, loop.response, LOOKS[key], names[key], show)
        over, under = [*over, *gain], [*under, *phase]
        plane += nyquist_marks(loop.frequency, loop.response, LOOKS[key], names[key], show)
    across = np.array(axes.frequency.ends or (1e-3, 1e3))
    gain_marks, phase_marks = [*_gain_limit(across, limits), *over], [*_phase_limit(across, limits), *under]
    return as_plots(loop_panels(gain_marks, phase_marks, [*_peak_limit(limits), *plane], axes))


def as_plots(panels: Sequence[Panel]) -> list[Panel]:
    """Return panels of loops as the page has them."""
    return [replace(panel, form="plot", aid=LOOP_AIDS[panel.key]) for panel in panels]


def _gain_limit(across: Array, limits: Mapping[str, float]) -> list[Mark]:
    size = limits.get("gain_margin")
    if size is None:
        return []
    height = min(abs(size), GAIN_SHOWN[1])
    return [_forbidden(across, -height, height, f"gain margin below {size:g} dB")]


def _phase_limit(across: Array, limits: Mapping[str, float]) -> list[Mark]:
    size = limits.get("phase_margin")
    if size is None:
        return []
    return [_forbidden(across, -180.0 - size, -180.0 + size, f"phase margin below {size:g} deg")]


def _peak_limit(limits: Mapping[str, float]) -> list[Mark]:
    peak = limits.get("ms")
    if peak is None or peak <= 0.0:
        return []
    return [Disc(look=FORBIDDEN, name=f"Ms above {peak:g}", x=-1.0, y=0.0, radius=1.0 / peak, fill="filled")]


def _forbidden(across: Array, low: float, high: float, name: str) -> Band:
    ends = np.ones(len(across))
    return Band(look=FORBIDDEN, name=name, x=across, low=low * ends, high=high * ends)
