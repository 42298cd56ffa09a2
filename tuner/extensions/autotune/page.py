"""The page of an autotune, index.html: its stages, the vehicle, the choice, the opinion and the first flights."""

from collections.abc import Sequence
from pathlib import Path

from tuner.documents.assessment import AssessmentDocument
from tuner.extensions.autotune.document import AutotuneDocument
from tuner.extensions.first_flights.approach_document import ApproachDocument
from tuner.extensions.identification.document import IdentificationDocument
from tuner.report.opinion_section import opinion_section
from tuner.report.page import Page, Section, titled_tables, wide_table
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import significant
from tuner.text.tables import Table

PAGES = (
    ("vehicle.html", "identification"), ("run/report.html", "search"), ("opinion/judge.md", "opinion"),
    ("confirmation/confirm.md", "flights in the firmware"), ("plan.html", "planned flight"),
)  # fmt: skip
"""Pages of stages below the folder."""


def autotune_page(document: AutotuneDocument, folder: Path, choice: Sequence[Table]) -> Page:
    """Return the page of a folder; stages that are not there have no section.

    choice: tables of the search's result.
    """
    links = [element("a", title, href=name) for name, title in PAGES if (folder / name).exists()]
    lines = [element("li", line) for line in (*document.commands, *[_stage_files(document)])]
    return Page(
        kind="autotune",
        title=f"From a log to {document.source}'s parameters",
        lead=element("p", document.sentence, class_="lead"),
        opening=join(
            (element("p", "Pages: ", join(element("span", link, " ") for link in links)), element("ul", *lines))
        ),
        sections=[
            Section("stages", "Stages", wide_table(stage_table(document))),
            Section("vehicle", "The vehicle", _vehicle(folder / "identification.json")),
            Section("search", "The choice", titled_tables(choice)),
            Section("opinion", "Present and tuned", _opinion(folder / "opinion" / "assessment.json")),
            Section("flights", "First flights", _flights(folder / "first_flights" / "approach.json")),
        ],
        data={},
    )


def stage_table(document: AutotuneDocument) -> Table:
    """Return a row for each stage."""
    rows = [[row.stage, row.state, row.sentence, row.folder] for row in document.stages]
    return Table("Stages", ("stage", "state", "result", "files"), rows, ("stage", "state", "result", "files"))


def _stage_files(document: AutotuneDocument) -> str:
    return f"Prior: {document.airframe}; logs: {', '.join(document.logs)}; parameters: {document.vehicle}."


def _vehicle(file: Path) -> Markup:
    """Return the identified numbers with their intervals."""
    if not file.exists():
        return Markup()
    fit = IdentificationDocument.read(file)
    rows = [
        [row.name, row.unit, significant(row.value), f"{significant(row.low)} to {significant(row.high)}", row.reason]
        for row in fit.numbers
    ]
    head = ("number", "unit", "value", "95 % interval", "not identified, for")
    return join((element("p", fit.verdict), wide_table(Table("Numbers", head, rows, head))))


def _opinion(file: Path) -> Markup:
    return opinion_section(AssessmentDocument.read(file)) if file.exists() else Markup()


def _flights(file: Path) -> Markup:
    """Return the steps of the approach."""
    if not file.exists():
        return Markup()
    document = ApproachDocument.read(file)
    rows = [
        [str(k), f"{100.0 * step.share:.0f} %", "-" if step.gain is None else f"{step.gain} x {step.factor:.2f}",
         "stable" if step.stable else "unstable", ", ".join(row.label for row in step.short) or "none", str(step.lost)]
        for k, step in enumerate(document.steps)
    ]  # fmt: skip
    head = ("step", "share", "largest change", "loops", "margins that fall short", "flights lost")
    return wide_table(Table("Steps", head, rows, head))
