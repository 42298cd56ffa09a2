"""Printer of the way to tuned gains: its steps, what to look at in the log of each, and the way back."""

from math import pi
from typing import TYPE_CHECKING

from objectives.margins.quantities import QUANTITIES
from tuner.cli.tables import TerminalTable
from tuner.cli.terminal import Console
from tuner.documents.margins import ChannelMargins, LimitRow
from tuner.extensions.first_flights.approach_document import Expected, StepOfApproach
from tuner.text.sentences import BOUNDS

if TYPE_CHECKING:
    from tuner.extensions.first_flights.approach_api import Approach

MARGINS = ("phase_margin", "gain_up", "ms")
"""Margins in the table, each in the worst loop."""


def print_approach(made: "Approach", console: Console) -> None:
    """Print the steps, their flights' metrics, insufficient margins and the procedure."""
    document = made.document
    for k, step in enumerate(document.steps):
        if step.lost:
            console.print(
                f"Step {k}: {step.lost} of {document.flights} flights lost in {document.scenario}; do not fly it."
            )
    console.print(steps_table(document.steps))
    console.print(expected_table(document.steps, f"{document.scenario}, {document.flights} flights"))
    for k, step in enumerate(document.steps):
        for row in step.short:
            console.print(f"Step {k}: {said_of(row)}")
        if not step.stable:
            console.print(f"Step {k} is not stable.")
    for sentence in (*document.notes, *advice(made)):
        console.print(sentence)


def steps_table(steps: list[StepOfApproach]) -> TerminalTable:
    """Return a row for each step: its largest change, its worst margins, and where it would ring first."""
    table = TerminalTable("Steps, margins of the worst loop", keys=1)
    heads = [f"{QUANTITIES[name].short} [{QUANTITIES[name].shown_unit}]".replace(" [1]", "") for name in MARGINS]
    table.columns_of("step", "largest change", *heads, "rings first", left=("step", "largest change", "rings first"))
    for k, step in enumerate(steps):
        worst = [worst_of(step, name) for name in MARGINS]
        table.add_row(name_of(k, steps), change_of(step), *[text_of(*each) for each in worst], ring_of(step))
    return table


def name_of(k: int, steps: list[StepOfApproach]) -> str:
    """Return the name of a step."""
    return f"{k}, flies now" if k == 0 else f"{k}, tuned" if k == len(steps) - 1 else str(k)


def change_of(step: StepOfApproach) -> str:
    """Return the gain that changes most, and its factor."""
    return "" if step.gain is None else f"{step.gain}, factor {step.factor:.2f}"


def worst_of(step: StepOfApproach, name: str) -> tuple[str, float | None, ChannelMargins]:
    """Return the worst margin of all loops in the unit of files.

    None where nothing limits any loop.
    """
    least = QUANTITIES[name].sense == "min"
    limited = [each for each in step.channels if each.quantities[name].value is not None]
    loop = (min if least else max)(limited or step.channels, key=lambda each: each.quantities[name].value or 0.0)
    return name, loop.quantities[name].value, loop


def text_of(name: str, value: float | None, loop: ChannelMargins) -> str:
    """Return a margin with the loop that it is of."""
    quantity = QUANTITIES[name]
    return "-" if value is None else f"{quantity.shown(value):.{quantity.digits}f} {loop.channel}"


def ring_of(step: StepOfApproach) -> str:
    """Return loop and frequency at which too much gain would show first."""
    _, value, loop = worst_of(step, "gain_up")
    met = loop.quantities["gain_up"].frequency
    return "-" if value is None or met is None else f"{loop.channel} at {met.value / (2.0 * pi):.3g} Hz"


def expected_table(steps: list[StepOfApproach], where: str) -> TerminalTable:
    """Return the measurements of completed flights of each step: median, and the range of 90 % of them."""
    table = TerminalTable(f"Expected: {where}, median and 90 % of them", keys=1)
    table.columns_of("step", *[f"{each.metric} [{each.unit}]".replace(" [1]", "") for each in steps[0].expected])
    for k, step in enumerate(steps):
        cells = [range_of(each) for each in step.expected]
        table.add_row(str(k), *cells)
    return table


def range_of(row: Expected) -> str:
    """Return the median of a measurement with the range of 90 %."""
    return "-" if row.median is None else f"{row.median:.3g} [{row.low:.3g}, {row.high:.3g}]"


def said_of(row: LimitRow) -> str:
    """Return a limit that a step falls short of, in a sentence."""
    quantity = QUANTITIES[row.quantity or ""]
    value = "none" if row.value is None else f"{quantity.to_limit(row.value):.4g}"
    return (
        f"{row.label} is {value}, {BOUNDS[row.sense]} {quantity.to_limit(row.limit):.4g} {quantity.limit_unit} is allowed: "
        "the limit, or the worse of both ends. Take more steps, or gains between which it does not fall."
    )


def advice(made: "Approach") -> list[str]:
    """Return instructions to fly the steps and to go back."""
    last = len(made.gains) - 1
    lines = [
        f"Fly steps 1 to {last} in turn, each in calm air first: hover, then a small step in every axis.",
        "Look at the spectrum of the rates: a peak that grows at the frequency where a loop rings says that its gain is too "
        "high. Look at errors and travel: outside the range above, the vehicle is not the one that was simulated.",
        "Go back by one step at any of these; step 0 is what flies now.",
    ]
    return [*lines, f"Gains of every step: {made.folder}/step0 to step{last}"] if made.folder else lines
