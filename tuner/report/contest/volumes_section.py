"""How large the fronts are: the share of one common box that each dominates."""

from tuner.documents.contest import Fronts, ShownContest
from tuner.report.charts.look import looks_of, sample
from tuner.report.contest.values_section import BEST, CLOSE
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import count, estimate, significant
from tuner.text.units import plain

HEAD = ["Front of", "Points", "Share of the common box (hypervolume)"]


def volumes_table(contest: ShownContest, fronts: Fronts) -> Markup:
    """Return a row a front; the larger the share, the better."""
    shares = {entry.contender: entry.share.value for entry in fronts.volumes if entry.share.value is not None}
    best = {name for name, share in shares.items() if share == max(shares.values())}
    rows = []
    for entry in fronts.volumes:
        value, ends = estimate(*entry.share.parts)
        largest = entry.contender in best
        sign = f"{BEST} " if largest else f"{CLOSE} " if entry.even & best else ""
        number = element("strong" if largest else "span", sign, value, class_="number")
        name = join((sample(looks_of(contest)[entry.contender]), " ", entry.contender))
        rows.append(
            [name, count(entry.points), element("span", number, " ", element("small", ends, class_="interval"))]
        )
    reference = [(contest.quantity[label], value) for label, value in fronts.reference.items()]
    corner = ", ".join(
        f"{entry.label} {significant(value, 3)} {plain(entry.unit)}".rstrip() for entry, value in reference
    )
    note = element("p", f"The far corner of the box: {corner}.", class_="aid")
    return join((table(HEAD, rows, class_="volumes stacked"), note))
