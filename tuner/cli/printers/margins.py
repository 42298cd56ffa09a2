"""Printers of margins, of a controller or a default and a design."""

from collections.abc import Sequence
from math import degrees
from typing import TYPE_CHECKING

from rich.text import Text

from objectives.margins.quantities import QUANTITIES, REPORTED
from tuner.analysis.margins.limits import LIMITS
from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console, bound_text, unit_text
from tuner.documents.margins import LimitRow, MarginsDocument, NotedValue, Reading
from tuner.documents.parts import in_shown_units
from tuner.documents.states import WORST_MARK, by_quantity, state_table
from tuner.documents.summary import RequiredRow
from tuner.report.labels import time_unit
from tuner.report.verdict_text import beside_limit

if TYPE_CHECKING:
    from tuner.api.designing import Design
    from tuner.api.margins import Margins


PLANT_UNITS = {"load_index": "input/(output s)"}
"""Quantity -> unit that it has for a plant, where that of a quadrotor is of accelerations."""
SHORT_CASES = {"steepest slope": "steep", "small signals": "small"}


def print_margins(margins: "Margins", console: Console) -> None:
    """Print the loops, the requirements, and tolerances and certificates if any."""
    document, from_study = margins.document, margins.from_study
    console.print(margins_table(document, from_study))
    disk = document.multiloop.disk
    bound = document.multiloop.disk_range
    if disk.value:
        console.print(
            f"All plant inputs at once: disk margin {disk.value:.2f}, so every gain may change by a factor of "
            f"{shown(bound.low, 2)} to {shown(bound.high, 2)} or every phase by "
            f"{degrees(bound.phase.value or 0.0):.0f} deg, all together.",
        )
    # The table of margins has no cell for a limit of a study that is of no loop.
    limits = [row for row in document.requirements if from_study or row.quantity is None]
    if limits:
        console.print(requirements_table(limits))
    print_states(console, document.requirements if from_study else by_quantity(document.requirements))
    print_limit_cycles(console, document)
    print_extents(console, document)
    print_certificates(console, document)
    print_verdict(console, document)
    if margins.folder is not None:
        print(f"Figures and margins.json: {margins.folder}")


def margins_table(document: MarginsDocument, from_study: bool) -> TerminalTable:
    """Return quantities down and channels across; broken limits are marked with !, missed targets with ~."""
    table = TerminalTable(f"{about(document)}, in the worst amplitude", keys=1)
    table.columns_of("", *[channel.channel for channel in document.channels], left=("",))
    limits = {} if from_study else {limit.quantity: limit.text for limit in LIMITS}
    if limits:
        table.add_column("limit", no_wrap=True)
    add_rows(table, document, limits)
    return table


def about(document: MarginsDocument) -> str:
    """Return whose margins these are: laws, and the airframe or the plant that they fly."""
    if document.laws is None or document.trim is None:
        laws = dict.fromkeys((document.channel_laws or {}).values())
        return f"{' / '.join(laws)} on {document.plant}"
    where = "" if document.trim.position_held else ", attitude mode"
    return f"{document.laws.position} / {document.laws.attitude} on {document.airframe}{where}"


def add_rows(table: TerminalTable, document: MarginsDocument, limits: dict[str, str]) -> None:
    """Add a row for each quantity; unstable loops have no values, the disk margin has its guarantees below it."""
    channels, marks = document.channels, marks_of(document.requirements)

    def add(label: str, name: str, cells: list[str]) -> None:
        valid = [cell if c.stable or name == "stable" else "-" for cell, c in zip(cells, channels, strict=True)]
        marked = [mark(cell, marks.get((c.channel, name))) for cell, c in zip(valid, channels, strict=True)]
        table.add_row(label, *marked, *([limits.get(name, "")] if limits else []))

    add("stable", "stable", ["yes" if c.stable else "NO" for c in channels])
    for name in REPORTED:
        unit, per_unit = time_unit(name, [c.quantities[name].value for c in channels])
        add(heading(name, unit, document), name, [reading(c.quantities[name], name, per_unit) for c in channels])
        if name == "disk":
            ranges = [c.disk_range for c in channels]
            add("  gain from", "", [shown(each.low, 2) for each in ranges])
            add("  gain to", "", [shown(each.high, 2) for each in ranges])
            add("  phase to [deg]", "", [f"{degrees(each.phase.value or 0.0):.0f}" for each in ranges])
    worst = [c.quantities["ms"].case for c in channels]
    if any(worst):
        add("Ms at amplitude", "", [short(case) for case in worst])


def marks_of(requirements: list[LimitRow]) -> dict[tuple[str, str], str]:
    """Return the mark of each cell (channel, quantity): ! for a broken limit, ~ for a missed target."""
    marks: dict[tuple[str, str], str] = {}
    for row in requirements:
        if not row.is_satisfied and row.channel is not None and row.quantity is not None:
            place = row.channel, row.quantity
            marks[place] = "!" if row.hard or marks.get(place) == "!" else "~"
    return marks


def heading(name: str, unit: str, document: MarginsDocument) -> str:
    """Return the name of a line of the table: a margin quantity with the unit in which it is printed."""
    # Inputs and outputs of a plant have units of their own, a channel each.
    shown_unit = PLANT_UNITS.get(name, unit) if document.plant else unit
    return f"{QUANTITIES[name].short}{unit_text(shown_unit, ' [{}]')}"


def reading(entry: Reading, name: str, per_unit: float = 1.0) -> str:
    """Return a reading of a margin quantity as text; per_unit: how many of its shown unit the printed one is."""
    quantity = QUANTITIES[name]
    if entry.value is None:
        return quantity.infinite_text("inf")
    value = float(quantity.shown(entry.value)) / per_unit
    return number_text(value, quantity.digits if per_unit == 1.0 else 2)


def mark(text: str, sign: str | None) -> Text:
    """Return a cell with its mark, bold where a limit is broken."""
    if sign == "!":
        return Text(f"{text}!", "bold red")
    return Text(f"{text}~", "yellow") if sign else Text(f"{text} ")


def shown(entry: NotedValue, digits: int) -> str:
    """Return a value as text; what has no end as "inf"."""
    return number_text(entry.value, digits)


def number_text(value: float | None, digits: int) -> str:
    """Return a number as text, "inf" for None, which is infinite.

    A small number has two significant digits.
    """
    if value is None:
        return "inf"
    if 0.0 < abs(value) < 10.0 ** (1 - digits):
        return f"{value:.2g}"
    return f"{value:.{digits if abs(value) < 100.0 else 0}f}"


def short(case: str | None) -> str:
    """Return the amplitude as it fits a column."""
    return "" if case is None else SHORT_CASES.get(case, case.removeprefix("amplitude "))


def requirements_table(rows: list[LimitRow]) -> TerminalTable:
    """Return the requirements of a study."""
    table = TerminalTable("Required by the study", keys=1)
    table.columns_of("requirement", "value", "limit", "unit", "", left=("requirement", "unit", ""))
    for row in map(in_shown_units, rows):
        verdict = "satisfied" if row.is_satisfied else "VIOLATED" if row.hard else "missed"
        infinite = "inf" if row.quantity is None else QUANTITIES[row.quantity].infinite_text("inf")
        value = infinite if row.value is None else beside_limit(row.value, row, 4)
        table.add_row(row.label, value, bound_text(row), unit_text(row.unit), verdict)
    return table


def print_states(console: Console, rows: Sequence[RequiredRow | LimitRow]) -> None:
    """Print limited margins by steady state, where there is more than hover."""
    view = state_table([in_shown_units(row) for row in rows])
    if view is None:
        return
    table = TerminalTable(f"Margins by steady state ({WORST_MARK} worst)", keys=1)
    heads = [f"{limit}{unit_text(unit, ' {}')}" for limit, unit in zip(view.limits, view.units, strict=True)]
    table.columns_of("state", *heads, left=("state",))
    for state, values in zip(view.states, view.marked, strict=True):
        table.add_row(state, *values)
    console.print(table)


def print_limit_cycles(console: Console, document: MarginsDocument) -> None:
    """Print the oscillations that loops of a plant sustain by themselves."""
    for row in document.limit_cycles or []:
        sizes = ", ".join(
            f"{each.value:.3g}{unit_text(each.unit, ' {}')} in the {each.term} of {each.channel}"
            for each in row.amplitudes
        )
        kind = "Limit cycle" if row.attracts else "Edge of what decays"
        console.print(
            f"{kind} of {' and '.join(row.channels)} by harmonic balance: {row.frequency.value:.4g} rad/s, {sizes}."
        )


def print_extents(console: Console, document: MarginsDocument) -> None:
    """Print the tolerance of the controller to deviations of the vehicle."""
    for row in document.mismatch or []:
        low, high = (f"{end:.2f}" if end is not None else None for end in (row.low, row.high))
        what = {"stability": "stable", "limits": "within the limits"}[row.criterion]
        if row.low == row.high == 1.0:
            text = f"not {what} even as assumed"
        else:
            text = f"{what} from {low or 'less than a quarter'} to {high or 'more than 4 times'} of what is assumed"
        console.print(f"{row.factor.capitalize()} alone: {text}.")


def print_certificates(console: Console, document: MarginsDocument) -> None:
    """Print what was proved, axis by axis."""
    if document.certificates is None:
        return
    rows = document.certificates
    if not rows:
        console.print("No certificate speaks of these laws.")
        return
    where = "at hover" if document.plant is None else "at rest"
    table = TerminalTable(f"Proved by matrix inequalities {where}")
    table.columns_of("axis", "certificate", "value", "what", left=("axis", "certificate", "what"), wrap=("what",))
    for row in rows:
        value = "nothing" if row.value is None else f"{row.value:.4g}{unit_text(row.unit, ' {}')}"
        table.add_row(row.axis, row.name, value, row.why)
    console.print(table)


def print_verdict(console: Console, document: MarginsDocument) -> None:
    """Print whether the hard requirements are kept."""
    open_ones = [row for row in document.requirements if not row.is_satisfied]
    broken = [row.label for row in open_ones if row.hard]
    # A target says nothing more where the limit itself is broken.
    unmet = {(row.channel, row.quantity) for row in open_ones if row.hard and row.channel}
    missed = [r.label for r in open_ones if not r.hard and (r.channel, r.quantity) not in unmet]
    if broken:
        console.print(f"VIOLATED (!): {', '.join(broken)}", style="red")
    else:
        console.print("All limits are satisfied.")
    if missed:
        console.print(f"Missed (~): {', '.join(missed)}", style="yellow")


def print_design(design: "Design", console: Console) -> None:
    """Print gains and margins of default and design, and a study's table.

    The table is of a plant's study that starts from the design.
    """
    console.print(gains_table(design))
    console.print(both_margins(design.margins))
    console.warn(design.warnings)
    if design.toml:
        console.print(f"\n{design.toml}\n", markup=False, soft_wrap=True)
    if design.gains.path is not None:
        say_files(console, Gains=design.gains.path)


def gains_table(design: "Design") -> TerminalTable:
    """Return the gains of default and design, axis by axis."""
    table = TerminalTable("Gains")
    table.columns_of("gain", "default", "design", "unit", left=("gain", "unit"))
    for name, default, new, unit in design.table.itertuples():
        table.add_row(str(name), f"{default:.4g}", f"{new:.4g}", str(unit))
    return table


def both_margins(margins: dict[str, MarginsDocument]) -> TerminalTable:
    """Return default over design in each loop; broken limits are marked with !, missed targets with ~."""
    default, design = margins["default"], margins["design"]
    table = TerminalTable("Margins: default, then design", keys=2)
    table.columns_of("", "", *[channel.channel for channel in default.channels], left=("",))
    marks = {name: marks_of(document.requirements) for name, document in margins.items()}
    for name in REPORTED:
        values = [c.quantities[name].value for document in (default, design) for c in document.channels]
        unit, per_unit = time_unit(name, values)
        for who, document in (("default", default), ("design", design)):
            texts = [reading(c.quantities[name], name, per_unit) if c.stable else "-" for c in document.channels]
            cells = [
                mark(text, marks[who].get((c.channel, name))) for text, c in zip(texts, document.channels, strict=True)
            ]
            table.add_row(heading(name, unit, document) if who == "default" else "", who, *cells)
    return table
