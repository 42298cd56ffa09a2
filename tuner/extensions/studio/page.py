"""The page: one HTML with the report's style sheet, scripts and charts, and the studio's own scripts behind them."""

from dataclasses import replace
from functools import cache
from importlib.resources import files
from string import Template

from tuner.extensions.studio.front import AID, KEY
from tuner.extensions.studio.session import Session
from tuner.report.charts import fans
from tuner.report.charts.chart import Axis, Panel
from tuner.report.charts.loops import loop_panels
from tuner.report.charts.shaded import shaded_limits
from tuner.report.charts.web import frame
from tuner.report.page import asset
from tuner.text.markup import join, safe
from tuner.text.units import in_degrees

REPORT_SCRIPTS = (
    "01_elements.js", "02_numbers.js", "03_data.js", "04_store.js", "05_selection.js", "06_charts.js", "10_tips.js",
)  # fmt: skip
"""Scripts of the report that the page uses: elements, numbers, state, charts and tips."""


def page_text(session: Session, query: str = "") -> str:
    """Return the page of a session as HTML; query: end of the addresses of its requests."""
    responses, loops = blank_panels(session)
    return Template(studio_file("studio.html")).substitute(
        query=query,
        title=safe(session.study.title),
        about=safe(", ".join(f"{key} {value.rstrip('.')}" for key, value in session.study.about)),
        responses=join(map(frame, responses)),
        loops=join(map(frame, loops)),
        front=frame(Panel(KEY, "Trade-off", Axis(), Axis(), [], form="pair", aid=AID)),
    )


def blank_panels(session: Session) -> tuple[list[Panel], list[Panel]]:
    """Return the panels of responses and loops without marks."""
    signals = session.study.system.signals
    names = fans.shown_signals(list(signals))
    titles = [fans.title(name, in_degrees(signals[name]).unit) for name in names]
    forms = ["plot rotor" if fans.is_rotor(name) else "plot" for name in names]
    responses = [
        Panel(f"response-{k}", title, fans.TIME, Axis(), [], form=form)
        for k, (title, form) in enumerate(zip(titles, forms, strict=True))
    ]
    # Of the limits the words below the charts depend on, not their channels.
    limits = shaded_limits([(entry.label, entry.limit) for entry in session.study.requirements], ())
    loops = [replace(panel, marks=[], form="plot") for panel in loop_panels([], [], [], limits=limits)]
    return responses, loops


def studio_file(name: str) -> str:
    """Return the text of a file of the extension."""
    return files("tuner.extensions.studio").joinpath(name).read_text(encoding="utf-8")


@cache
def script() -> str:
    """Return all scripts, those of the report first."""
    reports = [asset(f"js/{name}") for name in REPORT_SCRIPTS]
    folder = files("tuner.extensions.studio").joinpath("js")
    mine = [entry.read_text(encoding="utf-8") for entry in sorted(folder.iterdir(), key=lambda entry: entry.name)]
    return "\n".join(['"use strict";', "(() => {", *reports, *mine, "})();"])


@cache
def styles() -> str:
    """Return the report's style sheet, and that of the studio behind it."""
    return f"{asset('page.css')}\n{studio_file('studio.css')}"
