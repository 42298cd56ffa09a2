"""The opinion of `tuner judge` on a page.

It is a sentence, and tables of flights, margins, rules and gains.
"""

from collections.abc import Sequence

from tuner.documents.assessment import AssessmentDocument
from tuner.report.assessment_page import assessment_tables
from tuner.report.page import wide
from tuner.text.markup import Markup, element, join, table
from tuner.text.tables import Table


def opinion_text(document: AssessmentDocument) -> str:
    """Return the sentence on tuned gains against the present ones."""
    assert document.before is not None, "a run is judged against present gains"
    return f"Against the present gains, {document.before.file}, in the flights of `tuner judge`: {document.sentence}"


def opinion_section(document: AssessmentDocument) -> Markup:
    """Return the verdict in a sentence, and its tables."""
    return join((element("p", document.sentence), titled_tables(assessment_tables(document))))


def titled_tables(views: Sequence[Table]) -> Markup:
    """Return tables below their titles."""
    return join(join((element("h3", view.title), shown_table(view))) for view in views)


def shown_table(view: Table) -> Markup:
    """Return a table that scrolls on narrow screens."""
    return wide(table(view.head, view.rows))
