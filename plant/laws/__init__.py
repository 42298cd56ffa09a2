"""Control laws: one file a law, one line here. The cascade, the search and the reports learn of a law from this table."""

from plant.errors import UnknownNameError
from plant.laws import hybrid, ladrc, pid
from plant.laws.law import GainInfo, Law, Span

__all__ = ["LAWS", "GainInfo", "Law", "Span", "law"]

LAWS: dict[str, Law] = {entry.name: entry for entry in (pid.LAW, ladrc.LAW, hybrid.LAW)}


def law(name: str) -> Law:
    """Return the law of that name; raises UnknownNameError."""
    if name not in LAWS:
        raise UnknownNameError("law", name, LAWS)
    return LAWS[name]
