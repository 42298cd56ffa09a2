"""The page of a confirmation, confirm.md: rank correlation and gap of every metric, every finalist, what is rounded."""

from collections.abc import Sequence

from tuner.documents.confirmation import ConfirmationDocument, ConfirmedPoint, ConfirmedQuantity
from tuner.documents.parts import Estimate
from tuner.text.numbers import duration, estimate, fixed, significant
from tuner.text.units import after_number


def confirmation_page(document: ConfirmationDocument) -> str:
    """Return the page as Markdown."""
    parts = [
        f"# {document.title}: flown in {document.firmware}",
        " ".join(verdicts(document)),
        markdown_table(QUANTITY_HEADS, [quantity_cells(each) for each in document.quantities]),
        *[_points(document, i) for i in range(len(document.quantities))],
        "\n".join(f"- {note}" for note in document.notes),
        f"Flown with the exported file for {document.target_version}; SHA-256 of the program: `{document.program}`.",
    ]
    return "\n\n".join(parts) + "\n"


def verdicts(document: ConfirmationDocument) -> list[str]:
    """Return what was flown, and what is known of the firmware's repeatability, in sentences."""
    count, quantities = len(document.points), document.quantities
    there, here = (sum(getattr(point, name) for point in document.points) for name in ("lost_firmware", "lost_model"))
    flown = (
        f"{count} finalists, {document.flights} flights of each scenario, each in {document.firmware} and in our model "
        f"through the same air; lost: {there} in {document.firmware}, {here} in the model; {duration(document.seconds)}."
    )
    known = [each for each in quantities if each.jitter is not None]
    if not known:
        return [flown]
    same = all(each.jitter == 0.0 for each in known)
    largest = ", ".join(f"{each.label} {significant(each.jitter or 0.0)}" for each in known)
    told = "is the same to the last bit" if same else f"differs by up to: {largest}"
    return [flown, f"The first finalist flown a second time in the firmware {told}."]


QUANTITY_HEADS = ("metric", "rank correlation", "gap: firmware - model", "of the model's mean")


def quantity_cells(each: ConfirmedQuantity) -> list[str]:
    """Return the cells of a metric: label, correlation and gap with their intervals, the gap in percent."""
    value = each.correlation.value
    ranks = "-" if value is None else with_interval(each.correlation)
    relative = "-" if each.relative is None else f"{fixed(100.0 * each.relative, 2, signed=True)} %"
    return [each.label, ranks, f"{with_interval(each.gap)}{after_number(each.unit)}", relative]


def with_interval(value: Estimate) -> str:
    """Return a number with its interval."""
    return " ".join(estimate(*value.parts, signed=True))


POINT_HEADS = ("finalist", "firmware", "model", "gap")


def point_cells(point: ConfirmedPoint, i: int) -> list[str]:
    """Return the cells of a finalist for a metric."""
    value = point.values[i]
    return [point.point, significant(value.firmware), significant(value.model), with_interval(value.gap)]


def _points(document: ConfirmationDocument, i: int) -> str:
    each = document.quantities[i]
    heading = f"## {each.label}{after_number(each.unit)}\n\n{each.definition}"
    return f"{heading}\n\n{markdown_table(POINT_HEADS, [point_cells(point, i) for point in document.points])}"


def markdown_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown; cells are texts that may hold a bar."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
