"""Charts of settings laid over each other: the report's panels with a layer for each setting."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from tuner.documents.tables import Fan
from tuner.documents.tuning_tables import Loop
from tuner.report.charts import fans
from tuner.report.charts.chart import Axis, Mark, Panel
from tuner.report.charts.look import DEFAULT, PINS, TUNED, Look
from tuner.report.charts.loops import axes_of, bode_marks, loop_panels, nyquist_marks
from tuner.report.charts.shaded import ShadedLimit

LOOKS = {
    "default": DEFAULT,
    "tuned": TUNED,
    **{f"pin{number}": look for number, look in enumerate(PINS, 1)},
    "here": Look("other", "circle", size=12, width=2.4),
}
"""Key of a setting -> its look, from back to front."""
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


def margin_panels(loops: Mapping[str, Loop], names: Mapping[str, str], limits: Sequence[ShadedLimit]) -> list[Panel]:
    """Return Bode and Nyquist of all settings, with shaded limits.

    Args:
        loops: Loop of each setting by its key.
        names: Name of each setting by its key.
        limits: Limits on the channel, see `shaded_limits`.
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
    return [replace(panel, form="plot") for panel in loop_panels(over, under, plane, axes, limits)]
