"""The air and the answer of every contender to it: flight 0 of each, in the same air, over the fans of many flights."""

from tuner.documents.comparison import ComparedFolder, Trace
from tuner.report.charts import fans
from tuner.report.charts.chart import Axis, Line, Mark, Panel
from tuner.report.charts.look import Look, looks_of
from tuner.report.comparison.signals import asked_for, is_calm, signal_title

AIR = Look("ink", width=1.0)


def response_panels(compared: ComparedFolder) -> list[Panel]:
    """Return a panel for every signal of air and vehicles, in the order of the files.

    Components of the air that are zero in every scenario are left out.
    """
    blown = [
        signal for signal in dict.fromkeys(entry.signal for entry in compared.air) if not is_calm(compared.air, signal)
    ]
    units = {entry.signal: entry.unit for entry in [*compared.fans, *compared.traces]}
    signals = sorted(units, key=fans.is_rotor)
    return [
        *[_air(compared, signal) for signal in blown],
        *[_signal(compared, signal, units[signal]) for signal in signals],
    ]


def _air(compared: ComparedFolder, signal: str) -> Panel:
    entries = [entry for entry in compared.air if entry.signal == signal]
    lines = [
        Line(look=AIR, x=entry.time, y=entry.value, tip="%{y:.3~g}", show={"scenario": entry.scenario})
        for entry in entries
        if entry.value.any()
    ]
    title = signal_title(signal, entries[0].unit)
    return Panel(f"response-{signal}", title, fans.TIME, Axis(""), lines, form="air", hides=True, across=True)


def _signal(compared: ComparedFolder, signal: str, unit: str) -> Panel:
    """Bands stand behind all lines."""
    style, marks = looks_of(compared), []
    for fan in compared.fans:
        if fan.signal == signal and fan.point in style:
            show = _show(compared, fan.point, fan.scenario)
            marks += fans.fan_marks(fans.thinned(fan), style[fan.point], f"{fan.point}, median", show, parts=True)
    marks.sort(key=lambda mark: isinstance(mark, Line))
    for scenario in compared.scenarios:
        reference = asked_for(compared, scenario, signal)
        marks += fans.reference(*reference, {"scenario": scenario}) if reference is not None else []
    marks += [
        _flight(compared, style[entry.contender], entry)
        for entry in compared.traces
        if entry.signal == signal and entry.contender in style
    ]
    form = "rotor" if fans.is_rotor(signal) else "axis"
    return Panel(f"response-{signal}", signal_title(signal, unit), fans.TIME, Axis(""), marks, form=form, across=True)


def _flight(compared: ComparedFolder, look: Look, entry: Trace) -> Mark:
    show = {**_show(compared, entry.contender, entry.scenario), "part": "flight"}
    return Line(name=entry.contender, look=look, x=entry.time, y=entry.value, tip="%{y:.3~g}", show=show)


def _show(compared: ComparedFolder, name: str, scenario: str) -> dict[str, str]:
    """Return when a mark of a contender is seen; its "point" is the airframe, where there is a choice of these."""
    show = {"scenario": scenario, "layer": compared.layer(name)}
    return show | ({"point": compared.contenders[compared.index[name]].flown} if len(compared.flown) > 1 else {})
