"""Printer of tails: a line for each event, then how it happens and the flight that does it."""

from typing import TYPE_CHECKING

from tuner.cli.tables import say_files
from tuner.cli.terminal import Console
from tuner.documents.tail import TailEvent
from tuner.extensions.tails.document import TailDocument
from tuner.extensions.tails.words import event_line, mode_line, point_line, ratio_line

if TYPE_CHECKING:
    from tuner.extensions.tails.api import Tail


def print_tail(made: "Tail", console: Console) -> None:
    """Print the events of all gains, with modes, design points and ratios."""
    document = made.document
    console.print(f"{document.scenario}, {document.duration:g} s, seed {document.seed}", style="bold")
    for gains in document.gains:
        if len(document.gains) > 1:
            console.print(f"{gains.gains} ({gains.laws})")
        for event in gains.events:
            _print_event(event, document, console)
    for ratio in document.ratios:
        console.print(ratio_line(ratio))
    if made.folder is not None:
        say_files(console, Document=made.folder / "tail.json")


def _print_event(event: TailEvent, document: TailDocument, console: Console) -> None:
    console.print(event_line(event, document.smallest))
    for mode in event.modes:
        if len(event.modes) > 1 and mode.probability.value > 0.0:
            console.print(f"  {mode_line(mode)}")
        if document.worst is not None and mode.point is None and mode.probability.value > 0.0:
            console.print(f"  no {document.worst} alone leads to it by {mode.mode}")
        if mode.point is not None:
            console.print(f"  {point_line(mode.point)}")
