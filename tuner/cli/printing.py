"""The printers of answers, and the early answer of a run."""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

import tuner

if TYPE_CHECKING:
    from tuner.cli.terminal import Console

PRINTERS = {
    "Approach": "approach:print_approach",
    "Assessment": "assessment:print_assessment",
    "Checked": "check:print_checked",
    "Autotuned": "autotune:print_autotune",
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
    "Judgement": "check:print_judgement",
    "LogComparison": "identification:print_log_comparison",
    "LogCheck": "identification:print_log_check",
    "Margins": "margins:print_margins",
    "Plan": "planning:print_plan",
    "RunReport": "run_report:print_run_report",
    "ReadBackComparison": "assessment:print_read_back",
    "Sensitivity": "planning:print_sensitivity",
    "Tail": "tail:print_tail",
    "Theory": "gains:print_theory",
    "TuningResults": "tuning:print_tuning",
    "Verdict": "tuning:print_verdict",
}
"""Type of what was found -> module of `tuner.cli.printers` and function; a module is imported when it has something to print."""


def print_result(result: Any, as_json: bool, console: "Console | None" = None) -> None:
    """Print a result as JSON or for a person; console: a new one by default."""
    if as_json:
        print(result.json, flush=True)
        return
    from tuner.cli.terminal import Console

    module, name = PRINTERS[type(result).__name__].split(":")
    getattr(import_module(f"tuner.cli.printers.{module}"), name)(result, console or Console())


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
            from tuner.cli.printers.assessment import print_opinion
            from tuner.cli.terminal import Console

            print_opinion(opinion.document, Console())
        leave_with(code)
