"""The rungs of successive halving: where each contender stood, and who went on."""

from tuner.documents.contest import ComparedFolder
from tuner.documents.contest_document import RungRow
from tuner.text.markup import Markup, element, table
from tuner.text.numbers import count

HEAD = ("Rung", "Contender", "Generations", "Search flights", "Share of the common box", "")


def rungs_table(contest: ComparedFolder) -> Markup:
    """Return a row for each contender of each rung; nothing without halving."""
    rows = contest.document.rungs
    return table(HEAD, [_cells(row) for row in rows], class_="stacked") if rows else Markup()


def _cells(row: RungRow) -> list[Markup | str]:
    name = element("strong", row.contender) if row.goes_on else row.contender
    share = f"{row.share:.3f}" if row.feasible else "nothing feasible"
    return [
        str(row.rung),
        name,
        str(row.generations),
        count(row.flights),
        share,
        "goes on" if row.goes_on else "stopped",
    ]
