"""The answer to a setting: charts and tables as one document, from a pure function of session, request and flights."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from tuner.documents.tuning_tables import Loop
from tuner.extensions.studio.charts import margin_panels, response_panels
from tuner.extensions.studio.flights import STAGES, Flights
from tuner.extensions.studio.front import Front
from tuner.extensions.studio.loops import LoopCurves
from tuner.extensions.studio.messages import PageRequest
from tuner.extensions.studio.session import Session
from tuner.extensions.studio.tables import judged, loop_table, precision_note, summary
from tuner.report.charts.chart import Panel
from tuner.report.charts.shaded import ShadedLimit, shaded_limits
from tuner.report.charts.web import page_data

Document = dict[str, Any]


@dataclass(frozen=True, eq=False)
class Bench:
    """An opened study with its flights, loops and points of a run."""

    session: Session
    flights: Flights
    loops: LoopCurves
    front: Front

    @classmethod
    def of(cls, session: Session, threads: int | None = None) -> "Bench":
        """Return the bench of a session; threads: by default one for each core."""
        return cls(session, Flights(session.study, threads), LoopCurves(session), Front(session))

    @cached_property
    def limits(self) -> list[ShadedLimit]:
        """Limits that the charts shade."""
        given = [(entry.label, entry.limit) for entry in self.session.study.requirements]
        return shaded_limits(given, self.loops.channels)


def answer(bench: Bench, request: PageRequest, count: int) -> Document:
    """Return the answer to a request.

    count: flights of each scenario.

    Every number comes from the functions behind `tuner fly`, `tuner margins` and the table of `tuner run`.
    """
    session = bench.session
    # With the first flights the setting is compared with the default alone, because the hand still moves.
    others = request.settings[1:] if count > STAGES[0] else request.settings[1:2]
    rows = judged(session, bench.flights, [request.settings[0], *others], count)
    loops = _loops(bench, request, rests=count > STAGES[0])
    limits = [entry for entry in bench.limits if request.channel in (entry.channels or (request.channel,))]
    drawn = margin_panels(loops, _names(request), limits) if loops else []
    panels = [*_responses(bench, request, count), *drawn, *bench.front.panels(rows)]
    document: Document = {
        "number": request.number,
        "flights": count,
        "last": count >= STAGES[-1],
        "rows": rows,
        "others": [{"name": setting.name, "key": setting.key} for setting in others],
        "summary": summary(rows),
        "worst": loops["here"].case if loops else "",
        "note": precision_note(session, bench.flights, count),
        **page_data(panels),
    }
    if count >= STAGES[-1] and bench.loops.channels:
        document["loops"] = loop_table(bench.loops.margins(request.settings[0]))
    return document


def _responses(bench: Bench, request: PageRequest, count: int) -> list[Panel]:
    by_key = {each.key: bench.flights.fans(each.row, request.scenario, count) for each in request.settings}
    return response_panels(by_key, _names(request))


def _loops(bench: Bench, request: PageRequest, rests: bool) -> dict[str, Loop]:
    if not request.channel:
        return {}
    return {setting.key: bench.loops.curve(setting, request.channel, rests) for setting in request.settings}


def _names(request: PageRequest) -> dict[str, str]:
    return {setting.key: setting.name for setting in request.settings}


def opening(bench: Bench) -> Document:
    """Return the description of the study that the page begins with: gains, ranges, scenarios, loops."""
    session = bench.session
    words = session.study.variable_words
    default, start = (session.values(setting.row) for setting in (session.default, session.start))
    tuned = None if session.tuned is None else session.values(session.tuned.row)
    gains = [
        {
            "name": variable.name,
            "symbol": word.symbol,
            "meaning": word.meaning,
            "unit": "" if word.unit == "1" else word.unit,
            "low": variable.low,
            "high": variable.high,
            "scale": variable.scale,
            "step": variable.step,
            "default": default[variable.name],
            "tuned": None if tuned is None else tuned[variable.name],
            "start": start[variable.name],
        }
        for variable, word in zip(session.study.space.variables, words, strict=True)
    ]
    return {
        "title": session.study.title,
        "gains": gains,
        "tunedName": "" if session.tuned is None else session.tuned.name,
        "scenarios": [entry.spec.name for entry in session.study.scenarios],
        "channels": bench.loops.channels,
        "stages": list(STAGES),
        "pins": [{"name": pin.name, "values": session.values(pin.row)} for pin in session.pins],
        "noun": "flights" if session.has_rotors else "simulations",
        "points": {} if bench.front.run is None else bench.front.run.points(),
        "live": bench.front.run is not None and session.results is None,
    }
