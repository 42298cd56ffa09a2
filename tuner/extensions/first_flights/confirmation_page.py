"""The page of a confirmation, confirm.md: rank correlation and gap of every metric, every finalist, what is rounded."""

from tuner.documents.parts import Estimate
from tuner.extensions.first_flights.confirmation_document import ConfirmationDocument, ConfirmedQuantity
from tuner.text.numbers import duration, estimate, fixed, significant
from tuner.text.tables import Table
from tuner.text.units import after_number


def confirmation_page(document: ConfirmationDocument) -> str:
    """Return the page as Markdown."""
    parts = [
        f"# {document.title}: flown in {document.firmware}",
        " ".join(verdicts(document)),
        quantity_table(document).markdown,
        *[_points(document, i) for i in range(len(document.quantities))],
        "\n".join(f"- {note}" for note in document.notes),
        f"Flown with the exported file for {document.target_version}; SHA-256 of the program: `{document.program}`.",
    ]
    return "\n\n".join(parts) + "\n"


def verdicts(document: ConfirmationDocument) -> list[str]:
    """Return the flights made and the firmware's repeatability, in sentences."""
    count, quantities = len(document.points), document.quantities
    lost_firmware, lost_model = (
        sum(getattr(point, name) for point in document.points) for name in ("lost_firmware", "lost_model")
    )
    flown = (
        f"{count} finalists, {document.flights} flights of each scenario, each in {document.firmware} and in our model "
        f"through the same air; lost: {lost_firmware} in {document.firmware}, {lost_model} in the model; "
        f"{duration(document.seconds)}."
    )
    repeated = [each for each in quantities if each.jitter is not None]
    if not repeated:
        return [flown]
    same = all(each.jitter == 0.0 for each in repeated)
    largest = ", ".join(f"{each.label} {significant(each.jitter or 0.0)}" for each in repeated)
    difference = "is the same to the last bit" if same else f"differs by up to: {largest}"
    return [flown, f"The first finalist flown a second time in the firmware {difference}."]


def quantity_table(document: ConfirmationDocument) -> Table:
    """Return a row for each metric: correlation and gap with their intervals, the gap in percent."""
    head = ("metric", "rank correlation", "gap: firmware - model", "of the model's mean")
    rows = [_quantity_row(quantity) for quantity in document.quantities]
    return Table(f"{document.firmware} and the model", head, rows, head[:1])


def point_table(document: ConfirmationDocument, i: int) -> Table:
    """Return a row for each finalist with its values of a metric."""
    quantity, head = document.quantities[i], ("finalist", "firmware", "model", "gap")
    rows = [
        [point.point, significant(value.firmware), significant(value.model), with_interval(value.gap)]
        for point in document.points
        for value in [point.values[i]]
    ]
    return Table(f"{quantity.label}{after_number(quantity.unit)}", head, rows, head[:1])


def with_interval(value: Estimate) -> str:
    """Return a number with its interval."""
    return " ".join(estimate(*value.parts, signed=True))


def _quantity_row(row: ConfirmedQuantity) -> list[str]:
    ranks = "-" if row.correlation.value is None else with_interval(row.correlation)
    relative = "-" if row.relative is None else f"{fixed(100.0 * row.relative, 2, signed=True)} %"
    return [row.label, ranks, f"{with_interval(row.gap)}{after_number(row.unit)}", relative]


def _points(document: ConfirmationDocument, i: int) -> str:
    table = point_table(document, i)
    return f"## {table.title}\n\n{document.quantities[i].definition}\n\n{table.markdown}"
