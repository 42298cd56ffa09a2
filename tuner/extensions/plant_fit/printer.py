"""Printer of fitted plants."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console, unit_text
from tuner.extensions.plant_fit.document import OutputRow, PlantNumber, RivalRow, TransferFunctionRow
from tuner.text.numbers import estimate, per_cent, significant

if TYPE_CHECKING:
    from tuner.extensions.plant_fit.result import PlantFit


def print_plant_fit(fit: "PlantFit", console: Console) -> None:
    """Print numbers, rivals, noise and notes of each output."""
    document = fit.document
    for row in document.records:
        console.print(
            f"{row.file}: {row.samples:,} samples, {significant(row.duration, 3)} s, every {significant(row.period, 3)} s",
            markup=False,
        )
    for row in document.outputs:
        console.print(_numbers(row))
        console.print(_rivals(row))
        for each in row.transfer_functions:
            console.print(f"{row.output} / {each.input} = {transfer_text(each)}", markup=False)
        console.print(noise_text(row), markup=False)
        for note in row.notes:
            console.print(note, markup=False)
    console.warn(document.warnings)
    if document.file is not None:
        console.print(f"Written: {document.file}. Check it with: tuner check {document.file}", markup=False)


def _numbers(row: OutputRow) -> TerminalTable:
    table = TerminalTable(f"{row.output}: {row.structure}, fit {per_cent(max(row.fit, 0.0))}", keys=2)
    table.columns_of("input", "", "value", "95 % interval", "unit", left=("input", "", "unit"))
    for number in row.numbers:
        table.add_row(*number_cells(number), style=None if number.identified else "yellow")
    return table


def number_cells(number: PlantNumber) -> list[str]:
    """Return the texts of a number's row."""
    value, interval = (significant(number.value), "") if number.low is None or number.high is None else estimate(
        number.value, number.low, number.high
    )  # fmt: skip
    return [number.input, number.name, value, interval or "not identified", unit_text(number.unit)]


def _rivals(row: OutputRow) -> TerminalTable:
    table = TerminalTable("Structures", keys=1)
    table.columns_of("", "parameters", "fit", "on held-out blocks", "error over the best's", left=("",))
    for rival in row.rivals:
        table.add_row(*rival_cells(rival), style="bold" if rival.chosen else None)
    return table


def rival_cells(rival: RivalRow) -> list[str]:
    """Return the texts of a structure's row."""
    mark = " (chosen)" if rival.chosen else ""
    ratio = "1" if rival.ratio == 1.0 else f"{significant(rival.ratio, 3)} +- {significant(2.0 * rival.error, 1)}"
    shares = [per_cent(share) if share > 0.0 else "none" for share in (rival.fit, rival.held_out)]
    return [rival.structure + mark, str(rival.parameters), *shares, ratio]


def transfer_text(row: TransferFunctionRow) -> str:
    """Return a transfer function in a line."""
    above, below = (_polynomial(each) for each in (row.numerator, row.denominator))
    late = f" exp(-{significant(row.dead_time)} s)" if row.dead_time > 0.0 else ""
    return f"({above}) / ({below}){late}"


def _polynomial(coefficients: list[float]) -> str:
    text = ""
    degree = len(coefficients) - 1
    for power, value in zip(range(degree, -1, -1), coefficients, strict=True):
        if value == 0.0 and degree:
            continue
        size = "" if abs(value) == 1.0 and power else significant(abs(value))
        factor = {0: "", 1: "s"}.get(power, f"s^{power}")
        term = f"{size} {factor}".strip()
        sign = ("-" if value < 0.0 else "") if not text else (" - " if value < 0.0 else " + ")
        text += sign + term
    return text or "0"


def noise_text(row: OutputRow) -> str:
    """Return the noise of an output in a sentence."""
    noise, unit = row.noise, "" if row.unit == "1" else f" {row.unit}"
    parts = [f"white noise of {significant(noise.white, 3)}{unit} rms"]
    if noise.coloured > 0.0:
        parts.append(
            f"coloured noise of {significant(noise.coloured, 3)}{unit} rms with a correlation time of "
            f"{significant(noise.correlation_time, 3)} s"
        )
    number = "1 outlier is" if noise.outliers == 1 else f"{noise.outliers} outliers are"
    outliers = f"; {number} left out" if noise.outliers else ""
    return f"Noise of {row.output}: {' and '.join(parts)}{outliers}."
