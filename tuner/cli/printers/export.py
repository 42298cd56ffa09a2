"""Printers of an export and of an import."""

import sys
from math import degrees
from typing import TYPE_CHECKING

from plant.quadrotor.gains import gain_addresses
from tuner.cli.tables import TerminalTable, say_files, wide_console
from tuner.cli.terminal import Console, bound_text, unit_text
from tuner.documents.export import ExportDocument, ExportedParameter, RoundedMargin, VerificationPart
from tuner.documents.parts import in_shown_units

if TYPE_CHECKING:
    from tuner.api.exporting import Exported, Imported

# Options that an exporter has where a vehicle can be known.
VEHICLE_OPTIONS = ("others",)
# Lag of a Butterworth low-pass of second order at low frequencies, sqrt(2)/(2 pi) of its period [1].
SLOWNESS = 0.225
# Relative resolution of float32.
ROUNDING = 6e-8
# Percentages from here on have three digits before the point.
TWO_DIGITS = 99.5


def print_export(made: "Exported", _: Console) -> None:
    """Print files, parameters, margins and flights after rounding, and target notes."""
    console, document = wide_console(), made.document

    def say(text: str) -> None:
        console.print(text, soft_wrap=not console.is_terminal)

    verification = document.verification
    for sentence in lost_flights(verification):
        say(sentence)
    say(f"{document.target_version}: {laws_of(document)} for {made.made.airframe}")
    if document.experimental:
        say(f"Experimental: {document.experimental}")
    if document.parameters:
        console.print(parameters_table(document.parameters))
        if is_compared(document):
            say(said_of_before(document))
    console.print(changes_table(verification))
    say(said_of_margins(verification, "at hover" if document.plant is None else "at rest"))
    for sentence in said_of_filter(verification):
        say(sentence)
    for sentence in document.lossy:
        say(f"- {sentence}")
    for label in verification.broken:
        say(f"Broken by what the target holds: {label}")
    say(f"{made.folder}: {', '.join([*document.files, 'rollback/', 'export.json', 'gains.json'])}")


def is_compared(document: ExportDocument) -> bool:
    """Return true where the vehicle's parameters are given, or could be."""
    return any(row.before is not None for row in document.parameters) or any(
        option in document.settings for option in VEHICLE_OPTIONS
    )


def laws_of(document: ExportDocument) -> str:
    """Return the laws in words."""
    if document.laws is not None:
        return f"{document.laws.position} / {document.laws.attitude}"
    return ", ".join(f"{law} ({channel})" for channel, law in (document.channel_laws or {}).items())


def parameters_table(rows: list[ExportedParameter]) -> TerminalTable:
    """Return the target's parameters next to the vehicle's or the target's defaults.

    The defaults stand where no parameters of the vehicle are given.
    """
    table = TerminalTable("Parameters", keys=1)
    has_vehicle_values = any(row.before is not None for row in rows)
    compared = ("vehicle", "new", "change") if has_vehicle_values else ("default", "new")
    table.columns_of("name", *compared, "allowed", "unit", left=("name", "unit"), wrap=("unit",))
    for row in rows:
        old = old_text(row) if has_vehicle_values else _number(row.usual)
        cells = [old, f"{row.held:.6g}", *([change_text(row)] if has_vehicle_values else [])]
        table.add_row(row.name, *cells, _allowed(row), unit_text(row.unit))
    return table


def old_text(row: ExportedParameter) -> str:
    """Return the value on the vehicle: what its file lacks stands at the default."""
    return f"{_number(row.usual)} (default)" if row.before is None else _number(row.before)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"


def change_text(row: ExportedParameter) -> str:
    """Return the change on the vehicle: nothing, a percentage, or from or to 0 as it is."""
    old = row.usual if row.before is None else row.before
    if old is None:
        return "not in its file"
    change = difference(row)
    if change == 0.0:
        return "kept" if row.is_unmanaged else "same"
    share = 100.0 * change / abs(old) if old else 0.0
    if old == 0.0:
        return f"{change:+.4g}"
    return f"{share:+.2g} %" if abs(share) < TWO_DIGITS else f"{share:+.0f} %"


def difference(row: ExportedParameter) -> float:
    """Return the change of a parameter; of the default, to the digits of float32, where the vehicle's file lacks it."""
    if row.change is not None:
        return row.change
    change = row.held - (row.usual or 0.0)
    return 0.0 if abs(change) <= ROUNDING * abs(row.held) else change


def said_of_before(document: ExportDocument) -> str:
    """Return the origin of the compared values, with advice on the vehicle's."""
    origin = document.before
    if origin is None:
        return (
            "Compared with the defaults of the firmware: give --previous with the vehicle's own parameter file to see what "
            "changes on it, and to keep what our loops do not carry."
        )
    changed = sum(difference(row) != 0.0 for row in document.parameters)
    sentence = f"Compared with {origin}: {changed} of {len(document.parameters)} parameters change."
    return (
        sentence
        if origin.startswith("the previous")
        else f"{sentence} Give --previous if the vehicle has changed since."
    )


def _allowed(row: ExportedParameter) -> str:
    """Return the range of a parameter; null is no bound."""
    low, high = (None if end is None else f"{end:g}" for end in (row.low, row.high))
    if low is None:
        return "any" if high is None else f"to {high}"
    return f"{low} up" if high is None else f"{low} to {high}"


def changes_table(verification: VerificationPart) -> TerminalTable:
    """Return limits and metrics with changed digits, as tuned and as held."""
    flights, scenario = verification.flights, verification.scenario
    title = f"As tuned, and as the target holds it; metrics over {flights} flights, {scenario}"
    table = TerminalTable(title, keys=1)
    table.columns_of("", "unit", "limit", "tuned", "held", left=("", "unit"))
    for row in map(in_shown_units, changed_margins(verification)):
        table.add_row(row.label, row.unit, bound_text(row), _shown(row.unrounded), _shown(row.held))
    for row in verification.metrics:
        table.add_row(
            f"mean({row.metric})", row.unit, "", *("-" if x is None else _shown(x) for x in (row.unrounded, row.held))
        )
    return table


def lost_flights(verification: VerificationPart) -> list[str]:
    """Return a sentence on flights that are lost, nothing where none is."""
    tuned, held = verification.lost_asked or 0, verification.lost_held or 0
    if not tuned and not held:
        return []
    count = str(tuned) if tuned == held else f"{tuned} as tuned and {held} as the target holds it"
    return [f"{count} of {verification.flights} flights lost in {verification.scenario}: do not fly these gains."]


def changed_margins(verification: VerificationPart) -> list[RoundedMargin]:
    """Return the margins with other digits shown, or below their limits."""
    return [
        row
        for row in verification.margins
        if _shown(row.unrounded) != _shown(row.held) or not (row.kept_asked and row.kept_held)
    ]


def said_of_margins(verification: VerificationPart, where: str) -> str:
    """Return in a sentence what becomes of the limits on margins; where: "at hover" or "at rest"."""
    rows = verification.margins
    if not rows:
        return "No margins: this controller holds no steady hover."
    differing = sum(_shown(row.unrounded) != _shown(row.held) for row in rows)
    satisfied = sum(row.kept_held for row in rows)
    changed = (
        f"{differing} of them change{'s' if differing == 1 else ''} in five digits, see above"
        if differing
        else "none changes in five digits"
    )
    return (
        f"After rounding alone the loops satisfy {satisfied} of {len(rows)} limits on margins {where}; {changed}. Rates and "
        "delays of the target, and filters of it that are none of these gains, are not in these figures."
    )


def said_of_filter(verification: VerificationPart) -> list[str]:
    """Return sentences on the phase lag of the target's gyro low-pass.

    The loop with the least phase left comes first.
    """
    gyro = verification.gyro_filter
    if gyro is None or not gyro.rows:
        return []
    source = "as the vehicle has it" if gyro.is_from_vehicle_file else "the default"
    rows = sorted(gyro.rows, key=lambda row: row.theirs)
    taken = ", ".join(f"{row.loop} {degrees(row.taken):.2g} of {degrees(row.spare):.2g}" for row in rows)
    sentences = [
        f"{gyro.name} = {gyro.cutoff:g} Hz ({source}) in place of our derivative filters takes these degrees of the phase "
        f"margin that is spare: {taken}."
    ]
    broken = [row for row in rows if row.breaks]
    if broken:
        left = ", ".join(f"{row.loop} {degrees(row.theirs):.3g} deg" for row in broken)
        sentences.append(
            f"Warning: with that filter the phase margin falls below {degrees(broken[0].limit):g} deg: {left}; raise "
            f"{gyro.name}, or tune with attitude.t_f near {SLOWNESS / gyro.cutoff:.2g} s."
        )
    return sentences


def _shown(value: float | None) -> str:
    return "no bound" if value is None else f"{value:.5g}"


def print_import(imported: "Imported", _: Console) -> None:
    """Print the gains, the assumptions, and the next steps with the file."""
    console = Console(soft_wrap=not sys.stdout.isatty())
    controller, out = imported.gains.controller, imported.gains.path
    for gain in gain_addresses(controller.cascade):
        console.print(f"{gain.address:>12} {controller.gains[gain.column]:10.5g} {gain.unit}")
    console.bullets(imported.notes)
    if out is None:
        return
    say_files(console, Wrote=out)
    console.print(f'In a study: [controller] default = "{out.name}"')
    if controller.vehicle is not None:
        back = f"tuner export results/STUDY/gains.json --to {imported.source} --previous {imported.parameters}"
        console.print(f"Changes that a study then makes on the vehicle: {back}", soft_wrap=True)
