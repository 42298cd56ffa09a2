"""How the contenders of a contest look, the same in every chart, legend and table."""

from tuner.documents.contest import ShownContest
from tuner.report.charts.look import Look, looks


def looks_of(contest: ShownContest) -> dict[str, Look]:
    """Return the look of each contender by name."""
    flown = [(tuple(sorted(entry.laws.items())), entry.airframe) for entry in contest.contenders]
    return dict(zip(contest.index, looks(flown), strict=True))
