"""Printers of checks without flights, and of verdicts on gains."""

import re
from collections.abc import Callable, Sequence
from math import degrees
from typing import TYPE_CHECKING, Any

from tuner.cli.tables import TerminalTable, wide_console
from tuner.cli.terminal import Console, bound_text, digits, unit_text, width
from tuner.documents.judgement import JudgedRow, JudgementDocument
from tuner.documents.parts import in_shown_units
from tuner.experiments.planning.study_preview import DefaultRow, StudyPreview, TrimRow, VehicleRow
from tuner.gains.sections import VERSIONS
from tuner.report.verdict_text import beside_limit
from tuner.search.names import CONVERGED
from tuner.text.sentences import counted

if TYPE_CHECKING:
    from tuner.api.checking import Checked, Judgement
    from tuner.gains.examining import Examined

Row = dict[str, Any]
FIGURES = (
    "title",
    "plant",
    "channels",
    "variables",
    "objectives",
    "constraints",
    "requirements",
    "search_flights",
    "digest",
)
NUMBER = re.compile(r"-?\d[\d.]*(?:e[-+]?\d+)?")
CASE = re.compile(r",? in the \w+ loop(?: with the rate (?:measured|from an observer))?(?: and \w+ = [^;,]*)?")
"""Case that a clause of a law's contract tried, in its message."""
STYLES = {"fail": "bold red", "not certain": "yellow", "target missed": "yellow"}


def print_checked(checked: "Checked", _: Console) -> None:
    """Print what a file holds."""
    if checked.examined is not None:
        print(f"{checked.examined.path}: valid: {sentence(checked.examined)}")
    elif "breaches" in checked.content:
        print_own(checked.content)
    elif type(checked.document) in PREVIEWS:
        PREVIEWS[type(checked.document)](checked.document)
    else:
        print_figures(figures_of(checked.content))


def figures_of(content: Row) -> Row:
    """Return the figures of a document without automatic limits; sentences cover these."""
    return {key: value for key, value in content.items() if key != "automatic_limits"}


def grouped_violations(breaches: Sequence[Row]) -> list[tuple[Row, int]]:
    """Return the first violation of each kind, with the number of others.

    Those of a kind differ in numbers and in the case that a clause tried.
    """
    kinds: dict[tuple[str, str, str], list[Row]] = {}
    for breach in breaches:
        message = NUMBER.sub("#", CASE.sub("", str(breach["message"])))
        kinds.setdefault((breach["place"], breach["part"], message), []).append(breach)
    return [(alike[0], len(alike) - 1) for alike in kinds.values()]


def print_own(content: Row) -> None:
    """Print the contract violations of user code, one a line, or none."""
    for first, others in grouped_violations(content["breaches"]):
        more = f" (and in {counted(others, 'more case')} alike; --json has all)" if others else ""
        print(": ".join(text for text in (first["place"], first["part"], first["message"]) if text) + more)
    if not content["breaches"]:
        print(
            f"{content['file']}: the {content['kind']} '{content['name']}' keeps its contract (digest {content['digest']})"
        )


def print_figures(figures: Row) -> None:
    """Print figures, a line each."""
    table = TerminalTable(box=None, show_header=False)
    table.add_column("", no_wrap=True)
    table.add_column("")
    for key, value in figures.items():
        table.add_row(key, shown(value))
    wide_console().print(table)


def shown(value: Any) -> str:
    """Return a figure as text: a list or a table with commas, a number with its unit."""
    if isinstance(value, dict) and "value" not in value:
        return ", ".join(
            f"{key} {entry:.4g}" if isinstance(entry, float) else f"{key} {entry}" for key, entry in value.items()
        )
    if isinstance(value, dict):
        return f"{value['value']:.4g}{unit_text(value['unit'], ' {}')}"
    return ", ".join(value) if isinstance(value, list) else str(value)


def sentence(examined: "Examined") -> str:
    """Say what a valid file holds."""
    document, given = examined.document, examined.given
    if "plant" in document:
        laws = ", ".join(f"{channel['law']} ({channel['name']})" for channel in document["channels"])
        loops = f"{laws} for plant {document['plant']['name']}"
        return f"{given['format']} {given['version']}, {loops}, {len(document['gains'])} gains"
    laws = f"{document['controller']['position']} / {document['controller']['attitude']}"
    words = [
        f"gainproof-gains {given['version']}",
        f"{laws} for airframe {document['airframe']['name']}",
        f"{len(document['gains'])} gains",
    ]
    if given["version"] not in VERSIONS:
        words.append(f"no hash and no numbers of the airframe before version {VERSIONS[0]}")
    else:
        words.append("hash ok" if "sha256" in given else f"no hash given (it would be {examined.digest})")
    return ", ".join(words)


def show_study(preview: StudyPreview) -> None:
    """Print what would fly and what is known of the default."""
    console = wide_console()
    table = TerminalTable(box=None, show_header=False)
    table.add_column("", no_wrap=True)
    table.add_column("")
    most = "at most " if preview.stop == CONVERGED else ""
    for key in FIGURES:
        if key in preview.model_fields_set:
            table.add_row(key, f"{most if key == 'search_flights' else ''}{shown(_figure(preview, key))}")
    if preview.vehicle is not None:
        table.add_row("vehicle", vehicle_text(preview.vehicle))
    table.add_row("plant step", preview.plant_step.words)
    for row in preview.trim:
        table.add_row("trim", trim_text(row))
    console.print(table)
    for text in preview.notes:
        console.print(text)
    if preview.default and not isinstance(preview.requirements, dict):
        console.print(default_table(preview.default))
    for text in preview.problems:
        console.print(f"Problem: {text}", style="red")
    console.warn(preview.warnings)


def _figure(preview: StudyPreview, key: str) -> Any:
    """Return a figure of a preview; requirements of a plant with limits and the default's values."""
    if key == "requirements" and isinstance(preview.requirements, dict):
        return [_requirement_text(in_shown_units(row)) for row in preview.default]
    return getattr(preview, key)


def _requirement_text(row: DefaultRow) -> str:
    return f"{row.label} {bound_text(row)}{unit_text(row.unit, ' {}')} (default {_cell(row)})"


PREVIEWS: dict[type, Callable[..., None]] = {StudyPreview: show_study}
"""Type of a preview -> what prints it; any other document is printed line by line."""


def vehicle_text(row: VehicleRow) -> str:
    """Return the vehicle in a line."""
    return (
        f"{row.name}, {row.mass.value:g} kg, thrust-to-weight {row.thrust_to_weight.value:.2f}, hovers at "
        f"{row.hover_speed.value:.0f} rad/s ({100.0 * row.hover_speed_share.value:.0f} % of the largest rotor speed)"
    )


def trim_text(row: TrimRow) -> str:
    """Return a trim in a line."""
    where = f"{row.scenario}: mean wind {row.wind:.3g} m/s"
    if row.tilt is None or row.margin is None:
        return f"{where}, no balance"
    tilt = f"tilt {degrees(row.tilt):.1f} deg, {degrees(row.margin):.1f} deg to the limit"
    return f"{where}, {tilt}, thrust {row.thrust:.2f} times the weight"


def default_table(rows: list[DefaultRow]) -> TerminalTable:
    """Return the default's margins and other known limits, loops across."""
    loops = list(dict.fromkeys(row.loop for row in rows if row.loop is not None))
    if any(row.state for row in rows):
        title = "The default gains, before any flight, each loop in its worst steady state"
    else:
        title = f"The default gains{' at hover' if loops else ''}, before any flight"
    table = TerminalTable(title, keys=1)
    table.add_column("", overflow="fold")
    for name in ("limit", *loops, *([] if all(row.loop for row in rows) else ["all"])):
        table.add_column(name, justify="right", no_wrap=True)
    shown = [in_shown_units(row) for row in rows]
    for label in dict.fromkeys(row.label for row in shown):
        mine = {row.loop: row for row in shown if row.label == label}
        first = next(iter(mine.values()))
        cells = [_cell(mine.get(loop)) for loop in (*loops, *([None] if len(table.columns) > 2 + len(loops) else []))]
        table.add_row(label, f"{bound_text(first)}{unit_text(first.unit, ' {}')}", *cells)
    return table


def _cell(row: DefaultRow | None) -> str:
    if row is None:
        return ""
    value = "no bound" if row.value is None else beside_limit(row.value, row)
    return value if row.is_satisfied else f"{value} {'!' if row.hard else '~'}"


def print_judgement(judgement: "Judgement", console: Console) -> None:
    """Print the table and the verdict."""
    document = judgement.document
    table = TerminalTable(f"{document.flights:,} flights of a stream of their own, 95 % intervals", keys=1)
    table.columns_of("", "limit", "value", "95 % interval", "unit", "verdict", left=("", "unit", "verdict"))
    for row in map(in_shown_units, document.rows):
        table.add_row(*cells(row), style=STYLES.get(row.verdict))
    console.print(table)
    console.print(judgement_text(document))


def cells(row: JudgedRow) -> list[str]:
    """Return the texts of one row."""
    limit = bound_text(row)
    unit = unit_text(row.unit)
    if row.low is None or row.high is None or row.value is None:
        value = "unbounded" if row.value is None else f"{row.value:.4g}"
        return [row.label, limit, value, "", unit, row.verdict]
    room = width(row)
    ends = f"{digits(row.low, room)} to {digits(row.high, room)}"
    if row.count is not None and not row.count.events:
        ends = f"{ends} ({row.count.words})"
    return [row.label, limit, digits(row.value, room), ends, unit, row.verdict]


def judgement_text(document: JudgementDocument) -> str:
    """Return the verdict in a sentence, with names of deciding rows."""
    named = {
        verdict: ", ".join(row.label for row in document.rows if row.verdict == verdict)
        for verdict in ("fail", "not certain")
    }
    if document.verdict == "fail":
        return f"FAIL: violated: {named['fail']}."
    if document.verdict == "not certain":
        return (
            f"PASS on these flights, but not certain: the interval of {named['not certain']} crosses the limit; more --seeds "
            "narrow it."
        )
    return "PASS: every limit is satisfied."
