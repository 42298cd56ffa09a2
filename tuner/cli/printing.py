"""The printers of answers, and the early answer of a run."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

import tuner
from tuner.extension import added, load

if TYPE_CHECKING:
    from tuner.cli.terminal import Console

PRINTERS = {
    "Checked": "tuner.cli.printers.check:print_checked",
    "ComparisonResults": "tuner.cli.printers.compare:print_compared",
    "Design": "tuner.cli.printers.margins:print_design",
    "Exported": "tuner.cli.printers.export:print_export",
    "Flights": "tuner.cli.printers.gains:print_flights",
    "Imported": "tuner.cli.printers.export:print_import",
    "Judgement": "tuner.cli.printers.check:print_judgement",
    "Margins": "tuner.cli.printers.margins:print_margins",
    "Plan": "tuner.cli.printers.planning:print_plan",
    "RunReport": "tuner.cli.printers.run_report:print_run_report",
    "TuningResults": "tuner.cli.printers.tuning:print_tuning",
    "Verdict": "tuner.cli.printers.tuning:print_verdict",
    **added("printers"),
}
"""Type of an answer -> "module:function" that prints it; a module is imported when it has something to print."""


def print_result(result: Any, as_json: bool, console: "Console | None" = None) -> None:
    """Print a result as JSON or for a person; console: a new one by default."""
    if as_json:
        print(result.json, flush=True)
        return
    from tuner.cli.terminal import Console

    load(PRINTERS[type(result).__name__])(result, console or Console())


def leave_with(code: int) -> None:
    """End with an exit code other than 0."""
    if code:
        raise typer.Exit(code)


class RunAnswer:
    """The answer of a run: printed once, as soon as its documents are written.

    has_opinion: whether an opinion joins the document at the end, for which JSON waits.
    """

    def __init__(self, as_json: bool, has_opinion: bool = False) -> None:
        self._as_json, self._is_printed, self._waits = as_json, False, as_json and has_opinion

    def print_folder(self, folder: Path, flights_made: int | None, console: "Console | None" = None) -> None:
        """Print the answer of a folder whose report may still be missing."""
        if self._waits:
            return
        results = tuner.open_results(folder)
        results.flights_made = flights_made
        print_result(results, self._as_json, console)
        self._is_printed = True

    def end(self, result: Any, code: int) -> None:
        """Print answer and opinion unless printed, and end with a code."""
        if not self._is_printed:
            print_result(result, self._as_json)
        opinion = getattr(result, "opinion", None)
        if opinion is not None and not self._as_json:
            from tuner.cli.printers.opinion import print_opinion
            from tuner.cli.terminal import Console

            print_opinion(opinion.document, Console())
        leave_with(code)
