"""report.html: one offline page, from its opening paragraph to its provenance, figures included."""

import json
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

from plotly.offline import get_plotlyjs

from tuner.documents.loading import load
from tuner.documents.results import Results
from tuner.report.chart import Charts, Panel
from tuner.report.choice_section import choice_section
from tuner.report.explorer_data import explorer_data
from tuner.report.explorer_section import explorer_section
from tuner.report.gains_section import gains_table, study_lines
from tuner.report.outcome_table import outcome_table
from tuner.report.point_section import point_section
from tuner.report.prose import key_figures, paragraph
from tuner.report.provenance import air_table, definitions, resolved_text, run_facts
from tuner.report.trust_section import trust_section
from tuner.store.folder import put
from tuner.text.markup import Markup, described, element, join, safe

AIDS = {
    "outcome": "Values on scenarios that had no part in the choice, with 95 % intervals; angles in degrees. In the "
    "drawing the open square is the default, the filled diamond is tuned, a dashed line is a limit; every row has a scale of "
    "its own from zero.",
    "gains": "The recommended point. Open square: default; filled diamond: tuned. Gains are in the units of the study file, "
    "angles in rad; gains.json holds them with units, structure and origin, and tuner fly takes it.",
    "nearest": "The point nearest to feasible, which breaks limits: for study, not to be flown. Open square: default; filled "
    "diamond: nearest. Gains are in the units of the study file, angles in rad; infeasible.json holds them, and tuner export "
    "refuses it.",
}


def write_page(folder: Path) -> Path:
    """Write report.html into a results folder; StoreError where a file is missing, damaged or cannot be written."""
    return put_page(folder, page(load(folder)))


def put_page(folder: Path, content: str) -> Path:
    """Write report.html whole or not at all and return its path; StoreError where that cannot be done."""
    return put(folder, "report.html", content.encode())


def page(results: Results) -> str:
    """Return the page of a results folder."""
    sections = {
        "outcome": (f"Default against {results.shown_as}", _outcome(results)),
        "gains": ("What to fly" if results.feasible else "Nearest to feasible", _gains(results)),
        "front": ("Trade-off", explorer_section(results)),
        "point": ("The point picked", point_section(results)),
        "trust": ("Can it be trusted", trust_section(results)),
        "provenance": ("Provenance", _provenance(results)),
    }
    title = results.summary["title"]
    return Template(asset("tuning.html")).substitute(
        title=safe(title),
        ending=ending_aside(results.summary.get("ending", [])),
        description=element("p", results.resolved["description"]) if results.resolved.get("description") else "",
        paragraph=paragraph(results),
        figures=described(key_figures(results), class_="figures"),
        warnings=warnings_aside(results.summary["warnings"]),
        navigation=join(element("li", element("a", name, href=f"#{key}")) for key, (name, _) in sections.items()),
        sections=join(page_section(key, name, content) for key, (name, content) in sections.items()),
        data=in_script(explorer_data(results)),
        style="\n".join((asset("page.css"), asset("explorer.css"))),
        script=scripts(),
        plotly=get_plotlyjs(),
    )


def scripts() -> str:
    """Return the scripts of the page one after the other, in the order of their names."""
    found = files("tuner.report").joinpath("js").iterdir()
    return "\n".join(entry.read_text(encoding="utf-8") for entry in sorted(found, key=lambda entry: entry.name))


def asset(name: str) -> str:
    """Return the text of a file that comes with this package."""
    return files("tuner.report").joinpath(name).read_text(encoding="utf-8")


def embedded(charts: Charts) -> str:
    """Return the figures as JSON that can stand inside a script element: no "<", so nothing can close it."""
    return in_script({"charts": charts.charts, "shared": charts.shared})


def in_script(content: dict[str, Any]) -> str:
    """Return JSON that can stand inside a script element: no "<", so nothing can close it."""
    return json.dumps(content, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def page_section(key: str, name: str, content: Markup) -> Markup:
    """Return a section of a page under its heading."""
    return element("section", element("h2", name, id=f"{key}-title"), content, id=key, aria_labelledby=f"{key}-title")


def warnings_aside(warnings: list[str]) -> Markup:
    """Return what a reader must mind before believing the numbers, nothing where there is nothing."""
    if not warnings:
        return Markup()
    listed = element("ul", *[element("li", warning) for warning in warnings])
    return element(
        "aside", element("strong", "Mind this"), listed, class_="warnings", id="warnings", aria_label="Warnings"
    )


def ending_aside(ending: list[str]) -> Markup:
    """Return what a run that found nothing feasible says before all else, nothing for any other."""
    if not ending:
        return Markup()
    head, *others = ending
    listed = element("ul", *[element("li", text) for text in others]) if others else ""
    return element("aside", element("strong", head), listed, class_="warnings", id="ending", aria_label="How it ended")


def _outcome(results: Results) -> Markup:
    return join((_aid("outcome"), element("div", outcome_table(results), class_="wide"), choice_section(results)))


def _gains(results: Results) -> Markup:
    texts = (
        ("For the study file", "copy-study", study_lines(results), True),
        (f"All gains of the controller ({results.gains_name})", "copy-all", results.gains_text, False),
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
    actions = (
        element("button", f"Save {results.gains_name}", type="button", id="save-tuned"),
        element("button", f"Copy {results.gains_name}", type="button", id="copy-tuned"),
    )
    table = element("div", gains_table(results), class_="wide")
    return join(
        (_aid("gains" if results.feasible else "nearest"), table, element("div", *actions, class_="actions"), *copies)
    )


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
