"""The answer of a command: progress while it works, then what was found, as JSON or for a person."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import typer

from tuner.search.watcher import Watcher

PRINTERS = {
    "Approach": "approach:print_approach",
    "Checked": "check:print_checked",
    "ComparisonResults": "compare:print_compared",
    "Confirmation": "confirmation:print_confirmation",
    "ContestResults": "contest:print_contest",
    "Cost": "gains:print_costs",
    "Design": "margins:print_design",
    "EstimatedAirframe": "identification:print_estimate",
    "Exported": "export:print_export",
    "FlightPlan": "flight_plan:print_flight_plan",
    "Flights": "gains:print_flights",
    "Identification": "identification:print_identification",
    "Imported": "export:print_import",
    "InferenceResults": "inference:print_inference",
    "Judgement": "check:print_judgement",
    "LogComparison": "identification:print_log_comparison",
    "LogCheck": "identification:print_log_check",
    "Margins": "margins:print_margins",
    "Plan": "planning:print_plan",
    "RunReport": "run_report:print_run_report",
    "Sensitivity": "planning:print_sensitivity",
    "Theory": "gains:print_theory",
    "TuningResults": "tuning:print_tuning",
    "Verdict": "tuning:print_verdict",
}
"""Type of what was found -> module of `tuner.cli.printers` and function; a module is imported when it has something to print."""


class Messages(Watcher):
    """Watcher that prints on standard error, for commands with machine-readable output."""

    def on_message(self, text: str) -> None:
        """Print it."""
        print(text, file=sys.stderr, flush=True)


@contextmanager
def progress(as_json: bool, quiet: bool = False) -> Iterator[Watcher]:
    """Yield what shows the progress of a command: a display on the terminal, or beside JSON messages alone, none if quiet."""
    if as_json:
        yield Watcher() if quiet else Messages()
        return
    from tuner.cli.display import TerminalWatcher

    with TerminalWatcher() as watcher:
        yield watcher


def answer(result: Any, as_json: bool, code: int = 0) -> None:
    """Print what was found and end; code: the exit code."""
    if as_json:
        print(result.json)
    else:
        from tuner.cli.terminal import Console

        module, name = PRINTERS[type(result).__name__].split(":")
        getattr(import_module(f"tuner.cli.printers.{module}"), name)(result, Console())
    if code:
        raise typer.Exit(code)
