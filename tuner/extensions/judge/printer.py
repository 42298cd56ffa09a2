"""Printers of a second opinion and of a read-back."""

from typing import TYPE_CHECKING

from tuner.cli.tables import TerminalTable, say_files
from tuner.cli.terminal import Console
from tuner.extensions.judge.page import rollback_lines, subject_lines, unmodeled_lines
from tuner.report.opinion_section import assessment_tables

if TYPE_CHECKING:
    from tuner.extensions.judge.api import Assessment, ReadBackComparison


def print_assessment(made: "Assessment", console: Console) -> None:
    """Print what the model lacks, then files, tables and the verdict."""
    document = made.document
    for line in (*unmodeled_lines(document), *subject_lines(document)):
        console.print(line, markup=False)
    for table in assessment_tables(document, violated=True):
        console.print(TerminalTable.of(table))
    console.print(document.sentence, style=None if made.passed else "bold red", markup=False)
    for line in rollback_lines(document):
        console.print(line, markup=False)
    if made.folder is not None:
        say_files(console, Page=made.folder / "judge.md", Document=made.folder / "assessment.json")


def print_read_back(made: "ReadBackComparison", console: Console) -> None:
    """Print the parameters that differ, and how many were compared."""
    for row in made.document.differing:
        held = "missing" if row.after is None else row.after
        console.print(f"{row.name}: {row.before} written, {held} on the vehicle", markup=False)
    console.print(made.document.sentence, markup=False)
