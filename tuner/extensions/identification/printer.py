"""Printers of identified airframes and of checks of logs."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import FLY_AIRFRAME, Console, unit_text
from tuner.extensions.identification.document import IdentificationDocument, IdentifiedNumber, LogRow
from tuner.text.numbers import estimate, per_cent, significant

if TYPE_CHECKING:
    from tuner.extensions.identification.api import Identification, LogCheck


def print_identification(identification: "Identification", console: Console) -> None:
    """Print the numbers with intervals, the prediction, both regressions and the verdict."""
    document = identification.document
    for row in document.logs:
        console.print(log_text(row))
    table = TerminalTable("95 % intervals", keys=1)
    table.columns_of("", "value", "95 % interval", "prior", "unit", "", left=("", "unit"))
    for row in (*document.numbers, *document.curve):
        table.add_row(*number_cells(row), style=None if row.identified else "yellow")
    console.print(table)
    if document.prediction:
        console.print(prediction_table(document))
    console.print(regression_text(document))
    console.warn(document.warnings)
    console.print(document.verdict)
    if document.file is not None:
        console.print(FLY_AIRFRAME.format(document.file))


def print_log_check(checked: "LogCheck", console: Console) -> None:
    """Print each log and what is wrong with it."""
    for row in checked.document.logs:
        console.print(log_text(row))
        for finding in checked.document.findings:
            if finding.file == row.file:
                console.print(
                    f"  {finding.severity}: {finding.text}",
                    style="bold red" if finding.severity == "useless" else "yellow",
                )
    console.print("The logs can be used." if checked.usable else "A log is of no use as it stands.")


def log_text(row: LogRow) -> str:
    """Return a log in a line."""
    lost = f", {row.lost:,} samples lost" if row.lost else ""
    return f"{row.file}: {row.kind}, {row.begin:.1f} to {row.end:.1f} s, {row.rate:.0f} samples a second{lost}"


def number_cells(row: IdentifiedNumber) -> list[str]:
    """Return the texts of a number's row."""
    value, interval = estimate(row.value, row.low, row.high)
    return [row.name, value, interval, significant(row.prior, 3), unit_text(row.unit), row.reason]


def prediction_table(document: IdentificationDocument) -> TerminalTable:
    """Return the prediction of windows that the fit did not see."""
    table = TerminalTable(f"Prediction over {document.horizon:g} s on windows kept from the fit", keys=1)
    table.columns_of("", "explained", "RMS error", "unit", "in 95 % band", "up to", left=("", "unit"))
    for row in document.prediction:
        table.add_row(
            row.output,
            "hardly moved" if row.is_quiet else per_cent(max(row.explained, 0.0)),
            significant(row.error, 3),
            row.unit,
            per_cent(row.covered),
            f"{row.reach:.0f} Hz",
        )
    return table


def regression_text(document: IdentificationDocument) -> str:
    """Return the inertias of both regressions in a sentence."""
    pairs = [
        f"I{row.axis} {significant(row.acceleration_on_torque)} and {significant(row.torque_on_acceleration)}"
        for row in document.regressions
    ]
    return f"Least squares of acceleration on torque, and of torque on acceleration: {', '.join(pairs)} kg m2."
