"""Printer of the opinion that ends a run."""

from tuner.cli.terminal import Console
from tuner.documents.assessment import REFUSED, AssessmentDocument
from tuner.report.opinion_section import opinion_text


def print_opinion(document: AssessmentDocument, console: Console) -> None:
    """Print the sentence of an opinion that ends a run."""
    style = "bold red" if document.verdict in REFUSED else None
    console.print(opinion_text(document), style=style, markup=False)
