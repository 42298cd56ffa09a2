"""The air and the answer of every contender to it: flight 0 of each, in the same air, over the fans of many flights."""

from tuner.documents.contest import ComparedFolder, Trace
from tuner.report.charts import fans
from tuner.report.charts.chart import Axis, Line, Mark, Panel
from tuner.report.charts.look import Look, looks_of
from tuner.report.contest.signals import asked_for, is_calm, signal_title

AIR = Look("ink", width=1.0)


def response_panels(contest: ComparedFolder) -> list[Panel]:
    """Return a panel for every signal of air and vehicles, in the order of the files.

    Components of the air that are zero in every scenario are left out.
    """
    blown = [
        signal for signal in dict.fromkeys(entry.signal for entry in contest.air) if not is_calm(contest.air, signal)
    ]
    units = {entry.signal: entry.unit for entry in [*contest.fans, *contest.traces]}
    signals = sorted(units, key=fans.is_rotor)
    return [
        *[_air(contest, signal) for signal in blown],
        *[_signal(contest, signal, units[signal]) for signal in signals],
    ]


def _air(contest: ComparedFolder, signal: str) -> Panel:
    entries = [entry for entry in contest.air if entry.signal == signal]
    lines = [
        Line(look=AIR, x=entry.time, y=entry.value, tip="%{y:.3~g}", show={"scenario": entry.scenario})
        for entry in entries
        if entry.value.any()
    ]
    title = signal_title(signal, entries[0].unit)
    return Panel(f"response-{signal}", title, fans.TIME, Axis(""), lines, form="air", hides=True, across=True)


def _signal(contest: ComparedFolder, signal: str, unit: str) -> Panel:
    """Bands stand behind all lines."""
    style, marks = looks_of(contest), []
    for fan in contest.fans:
        if fan.signal == signal and fan.point in style:
            show = _show(contest, fan.point, fan.scenario)
            marks += fans.fan_marks(fans.thinned(fan), style[fan.point], f"{fan.point}, median", show, parts=True)
    marks.sort(key=lambda mark: isinstance(mark, Line))
    for scenario in contest.scenarios:
        reference = asked_for(contest, scenario, signal)
        marks += fans.reference(*reference, {"scenario": scenario}) if reference is not None else []
    marks += [
        _flight(contest, style[entry.contender], entry)
        for entry in contest.traces
        if entry.signal == signal and entry.contender in style
    ]
    form = "rotor" if fans.is_rotor(signal) else "axis"
    return Panel(f"response-{signal}", signal_title(signal, unit), fans.TIME, Axis(""), marks, form=form, across=True)


def _flight(contest: ComparedFolder, look: Look, entry: Trace) -> Mark:
    show = {**_show(contest, entry.contender, entry.scenario), "part": "flight"}
    return Line(name=entry.contender, look=look, x=entry.time, y=entry.value, tip="%{y:.3~g}", show=show)


def _show(contest: ComparedFolder, name: str, scenario: str) -> dict[str, str]:
    """Return when a mark of a contender is seen; its "point" is the airframe, where there is a choice of these."""
    show = {"scenario": scenario, "layer": contest.layer(name)}
    return show | ({"point": contest.contenders[contest.index[name]].flown} if len(contest.flown) > 1 else {})
