"""report.html: one offline page, from its opening paragraph to its provenance, figures included."""

import json
from importlib.resources import files
from pathlib import Path
from string import Template

from plotly.offline import get_plotlyjs

from plant.errors import StoreError
from tuner.report.chart import Charts, Panel
from tuner.report.choice_section import choice_section
from tuner.report.controls import layer_switches, response_choices
from tuner.report.front_charts import add_front
from tuner.report.gains_section import all_gains, gains_table, study_lines
from tuner.report.loading import load
from tuner.report.markup import Markup, described, element, join, safe
from tuner.report.outcome_table import outcome_table
from tuner.report.progress_charts import add_progress
from tuner.report.prose import key_figures, paragraph
from tuner.report.provenance import air_table, definitions, resolved_text, run_facts
from tuner.report.response_charts import add_responses
from tuner.report.results import Results

AIDS = {
    "outcome": "Values on scenarios that had no part in the choice, with 95 % intervals; angles in degrees. In the "
    "drawing the open square is the default, the filled diamond is tuned, a dashed line is a limit; every row has a scale of "
    "its own from zero.",
    "gains": "Open square: default; filled diamond: tuned. Gains are in the units of the study file, angles in rad.",
    "front": "Down and to the left is better. Point at a mark for its gains, drag to zoom, double-click to zoom out.",
    "lines": "One line a point; below 1 is better than the default in that objective.",
    "ranking": "Best on top; to the left is better. Point at a mark for its gains.",
    "responses": "Line: median over flights; band: 5 to 95 % of them; fine dashes: reference, for roll and pitch the "
    "mean of what the position loop asks for. Zooming one figure in time zooms all.",
    "progress": "Hypervolume is the share of the box between zero and 1.1 times the default's values that the front "
    "dominates: once it is level, more generations find little.",
}


def write_page(folder: Path) -> Path:
    """Write report.html into a results folder; StoreError where a file is missing, damaged or cannot be written."""
    return write_aside(folder / "report.html", page(load(folder)))


def write_aside(file: Path, content: str) -> Path:
    """Write a page aside first and then rename it, and return its path; StoreError where that cannot be done."""
    aside = file.with_name(f".{file.name}.part")
    try:
        aside.write_text(content, encoding="utf-8")
        aside.replace(file)
    except OSError as error:
        aside.unlink(missing_ok=True)
        raise StoreError(f"{file} cannot be written ({error.strerror})") from error
    return file


def page(results: Results) -> str:
    """Return the page of a results folder."""
    charts = Charts()
    sections = {
        "outcome": ("Default against tuned", _outcome(results)),
        "gains": ("Tuned gains", _gains(results)),
        "front": ("Trade-off", _front(results, charts)),
        "responses": ("Responses", _responses(results, charts)),
        "progress": ("Search", _progress(results, charts)),
        "provenance": ("Provenance", _provenance(results)),
    }
    title = results.summary["title"]
    return Template(asset("page.html")).substitute(
        kind="tuning report",
        title=safe(title),
        description=element("p", results.resolved["description"]) if results.resolved.get("description") else "",
        paragraph=paragraph(results),
        figures=described(key_figures(results), class_="figures"),
        warnings=warnings_aside(results.summary["warnings"]),
        navigation=join(element("li", element("a", name, href=f"#{key}")) for key, (name, _) in sections.items()),
        sections=join(page_section(key, name, content) for key, (name, content) in sections.items()),
        data=embedded(charts),
        style=asset("page.css"),
        script=asset("page.js"),
        plotly=get_plotlyjs(),
    )


def asset(name: str) -> str:
    """Return the text of a file that comes with this package."""
    return files("tuner.report").joinpath(name).read_text(encoding="utf-8")


def embedded(charts: Charts) -> str:
    """Return the figures as JSON that can stand inside a script element: no "<", so nothing can close it."""
    content = {"charts": charts.charts, "shared": charts.shared}
    return json.dumps(content, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def page_section(key: str, name: str, content: Markup) -> Markup:
    """Return a section of a page under its heading."""
    return element("section", element("h2", name, id=f"{key}-title"), content, id=key, aria_labelledby=f"{key}-title")


def warnings_aside(warnings: list[str]) -> Markup:
    """Return what a reader must mind before believing the numbers, nothing where there is nothing."""
    if not warnings:
        return Markup()
    listed = element("ul", *[element("li", warning) for warning in warnings])
    return element("aside", element("strong", "Mind this"), listed, class_="warnings", aria_label="Warnings")


def _outcome(results: Results) -> Markup:
    return join((_aid("outcome"), element("div", outcome_table(results), class_="wide"), choice_section(results)))


def _gains(results: Results) -> Markup:
    texts = (
        ("For the study file", "copy-study", study_lines(results), True),
        ("All gains of the controller (gains.json)", "copy-all", all_gains(results), False),
    )
    copies = [
        element(
            "details",
            element("summary", name),
            element("button", "Copy", type="button", data_copy=key),
            element("pre", text, id=key, tabindex="0"),
            open=opened,
        )
        for name, key, text, opened in texts
    ]
    return join((_aid("gains"), element("div", gains_table(results), class_="wide"), *copies))


def _front(results: Results, charts: Charts) -> Markup:
    panels = add_front(results, charts)
    count = len(results.objectives)
    aid = _aid("ranking") if count == 1 else _aid("front")
    lines = _aid("lines") if count > 3 else Markup()
    return join((aid, lines, layer_switches(charts), grid(panels, f"front-grid objectives-{min(count, 4)}")))


def _responses(results: Results, charts: Charts) -> Markup:
    panels = add_responses(results, charts)
    if not panels:
        text = "This folder holds no recorded responses (responses.parquet is missing or empty)."
        return element("p", text, class_="note")
    grids = [grid([entry for entry in panels if entry.form == form], f"{form}-grid") for form in ("axis", "rotor")]
    return join((_aid("responses"), response_choices(results), *grids))


def _progress(results: Results, charts: Charts) -> Markup:
    return join((_aid("progress"), grid(add_progress(results, charts), "progress-grid")))


def _provenance(results: Results) -> Markup:
    files_shown = (("Study file as given", results.study), ("Every value, defaults included", resolved_text(results)))
    return join(
        (
            run_facts(results),
            element("h3", "Air"),
            element("div", air_table(results), class_="wide"),
            element("h3", "What the words mean"),
            definitions(results),
            *[element("details", element("summary", name), element("pre", text, tabindex="0"))
              for name, text in files_shown],
        )
    )  # fmt: skip


def grid(panels: list[Panel], name: str) -> Markup:
    """Return figures side by side; name: the classes of the grid."""
    return element("div", *[_figure(panel) for panel in panels], class_=f"grid {name}")


def _figure(panel: Panel) -> Markup:
    drawn = element("div", id=panel.name, class_="chart", role="img", aria_label=panel.title)
    # The axes of a pair say what its heading would.
    caption = element("figcaption", panel.title, class_="hidden" if panel.form == "pair" else False)
    return element("figure", caption, drawn, class_=panel.form)


def _aid(key: str) -> Markup:
    return element("p", AIDS[key], class_="aid")
