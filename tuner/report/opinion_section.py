"""The opinion in the page of a run: its sentence, and tables of flights, margins, rules and changed gains."""

from math import degrees

from objectives.margins.quantities import QUANTITIES
from tuner.documents.assessment import AssessmentDocument, LoopFigures
from tuner.report.page import titled_tables
from tuner.text.markup import Markup, element, join
from tuner.text.numbers import per_cent, plus, significant
from tuner.text.tables import Table
from tuner.text.units import after_number

NONE = "-"
SHOWN = {"ms": "Ms", "gain_up": "gain up [dB]", "gain_down": "gain down [dB]", "phase_margin": "phase [deg]"}


def opinion_text(document: AssessmentDocument) -> str:
    """Return the sentence on tuned gains against the present ones."""
    assert document.before is not None, "a run is judged against present gains"
    return f"Against the present gains, {document.before.file}, in the flights of `tuner judge`: {document.sentence}"


def opinion_section(document: AssessmentDocument) -> Markup:
    """Return the verdict in a sentence, and its tables."""
    return join((element("p", document.sentence), titled_tables(assessment_tables(document))))


def assessment_tables(document: AssessmentDocument, violated: bool = False) -> list[Table]:
    """Return the tables: flights, margins, rules, changed gains; those without rows are left out.

    violated: of the rules those that are violated alone.
    """
    tables = [metric_table(document), loop_table(document), rule_table(document, violated), change_table(document)]
    return [table for table in tables if table.rows]


def metric_table(document: AssessmentDocument) -> Table:
    """Return the risks over the flights, before and after; of one file alone its values."""
    if document.before is None:
        values = [[f"{row.label}{bracketed_unit(row.unit)}", significant(row.after)] for row in document.metrics]
        return Table("Flights", ("metric", "value"), values, ("metric",))
    head = ("metric", "before", "after", "change, 95 % interval", "verdict")
    rows = []
    for row in document.metrics:
        change = NONE
        if row.difference is not None:
            value, low, high = map(per_cent, row.difference)
            change = f"{plus(row.difference.value)}{value} [{low}, {high}]"
        before = NONE if row.before is None else significant(row.before)
        rows.append(
            [f"{row.label}{bracketed_unit(row.unit)}", before, significant(row.after), change, row.verdict or NONE]
        )
    return Table("Flights", head, rows, (head[0], "verdict"))


def bracketed_unit(unit: str) -> str:
    """Return a unit in brackets, "" without one."""
    return "" if unit == "1" else f" [{unit}]"


def loop_table(document: AssessmentDocument) -> Table:
    """Return the margins of each loop, before and after."""
    head = ("loop", "", *SHOWN.values())
    rows = []
    for loop in document.loops:
        states = {"before": loop.before, "after": loop.after}
        for name, figures in states.items():
            if figures is not None:
                rows.append([loop.channel, name, *_cells(figures)])
    return Table("Margins of the loops at hover, filters included", head, rows, head[:2])


def rule_table(document: AssessmentDocument, violated: bool) -> Table:
    """Return the rules of the firmware's tools."""
    head = ("rule of the firmware's tools", "axis", "value", "limit", "verdict", "source")
    rows = [
        [
            row.rule,
            row.axis,
            f"{significant(row.value, 3)}{after_number(row.unit)}",
            f"{row.sense} {row.limit:g}{after_number(row.unit)}",
            row.verdict,
            row.source,
        ]
        for row in document.rules
        if not violated or row.verdict == "violated"
    ]
    return Table("Violated rules" if violated else "Rules", head, rows, (head[0], "axis", "verdict", "source"))


def change_table(document: AssessmentDocument) -> Table:
    """Return the changed gains with their ratio."""
    head = ("changed gain", "before", "after", "ratio", "unit")
    rows = [
        [
            row.name,
            NONE if row.before is None else significant(row.before),
            significant(row.after),
            NONE if row.ratio is None else significant(row.ratio, 3),
            row.unit,
        ]
        for row in document.changes
    ]
    return Table("Changed gains", head, rows, (head[0], "unit"))


def _cells(figures: LoopFigures) -> list[str]:
    if not figures.stable:
        return ["unstable", *[NONE] * (len(SHOWN) - 1)]
    gains = [
        None if value is None else QUANTITIES["gain_up"].shown(value) for value in (figures.gain_up, figures.gain_down)
    ]
    phase = None if figures.phase_margin is None else degrees(figures.phase_margin)
    return [significant(figures.ms, 3), *(significant(value, 3) for value in (*gains, phase))]
