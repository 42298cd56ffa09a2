"""Printer of an autotune."""

from typing import TYPE_CHECKING

from tuner.cli.tables import say_files
from tuner.cli.terminal import Console

if TYPE_CHECKING:
    from tuner.extensions.autotune.api import Autotuned


def print_autotune(made: "Autotuned", console: Console) -> None:
    """Print the stages, the result in a sentence, and the next commands."""
    for row in made.document.stages:
        console.print(f"{row.stage}: {row.sentence}", markup=False)
    console.print(made.document.sentence, style=None if made.passed else "bold red", markup=False)
    for command in made.document.commands:
        console.print(command, markup=False)
    say_files(console, Page=made.folder / "index.html", Document=made.folder / "autotune.json")
