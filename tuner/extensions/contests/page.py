"""report.html of a contest: the page of a comparison with claims, stopped searches and printed numbers."""

from tuner.documents.comparison import ComparedFolder
from tuner.documents.comparison_document import ClaimRow, RulingRow, RungRow
from tuner.extensions.contests.published_section import printed_tables, strips
from tuner.report.comparison.page import Further, comparison_page
from tuner.report.labels import compared_label, in_plain_words
from tuner.report.page import Page, Section, aid, wide
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import count, estimate
from tuner.text.units import plain

AIDS = {
    "rungs": "Every search goes on to the rung; those whose fronts dominate most of the common box (up to 1.1 times the nadir of "
    "all fronts of the rung, on search flights, the same for all) go on. The study of each lies next to its folder: run with "
    "--reuse of that, it goes on where it stopped.",
    "published": "A printed number is one draw: the question is whether one of our flights could have given it. Ours is "
    "the mean over flights with the central 95 % of them in brackets. The percentile is that of the printed number; "
    "fitted: the study was set to meet it.",
    "strips": "Bar: central 95 % of our flights; stroke: their median; triangle: the printed number, filled where it is "
    "inside.",
}
SIGNS = {"survives": "✓", "fails": "✗", "undecided": "≈"}
COUNTS = {"survives": "for it", "fails": "against it", "undecided": "without a decision"}
RUNGS_HEAD = ("Rung", "Contender", "Generations", "Search flights", "Share of the common box", "")


def contest_page(contest: ComparedFolder) -> Page:
    """Return the page of a contest."""
    further = Further(
        opening=claims(contest),
        repeated=tuple(f'The claim "{claim.text}"' for claim in contest.shown.claims if claim.text),
        figures=judged_figures(contest),
        sections=[
            Section("rungs", "Stopped searches", _rungs(contest)),
            Section("published", "Printed numbers", _published(contest)),
        ],
    )
    return comparison_page(contest, "contest report", further)


def judged_figures(contest: ComparedFolder) -> list[tuple[str, str]]:
    """Return the counts of printed numbers inside and of claims that survive."""
    figures = []
    free = [cell.inside for cell in contest.shown.published if not cell.fitted]
    if free:
        figures.append(("Printed numbers inside", f"{sum(free)} of {len(free)}"))
    surviving = [claim.verdict == "survives" for claim in contest.shown.claims]
    if surviving:
        figures.append(("Claims that survive", f"{sum(surviving)} of {len(surviving)}"))
    return figures


def _rungs(contest: ComparedFolder) -> Markup:
    rungs = rungs_table(contest)
    return join((aid(AIDS["rungs"]), wide(rungs))) if rungs else rungs


def _published(contest: ComparedFolder) -> Markup:
    if not contest.shown.published:
        return Markup()
    picture = (element("h3", "As a picture"), aid(AIDS["strips"]), strips(contest))
    return join((aid(AIDS["published"]), printed_tables(contest), *picture))


def claims(contest: ComparedFolder) -> Markup:
    """Return every claim with its verdict, its comparisons folded away."""
    if not contest.shown.claims:
        return Markup()
    return element("div", *[_claim(contest, claim) for claim in contest.shown.claims], class_="claims")


def _claim(contest: ComparedFolder, claim: ClaimRow) -> Markup:
    text = claim.text or f"{claim.better} is better"
    counts = [(sum(row.verdict == kind for row in claim.rows), name) for kind, name in COUNTS.items()]
    names = {label: compared_label(contest, label) for label in contest.quantity}
    basis = f"{in_plain_words(claim.basis, names)}; " if claim.basis else ""
    rests = f"{basis}paired comparisons: {', '.join(f'{number} {name}' for number, name in counts if number)}"
    head = element(
        "summary", _verdict(claim.verdict), element("span", text, class_="claim-text"), element("small", rests)
    )
    return element(
        "details", head, element("ul", *[_ruling(contest, claim, row) for row in claim.rows]), class_="claim"
    )


def _ruling(contest: ComparedFolder, claim: ClaimRow, row: RulingRow) -> Markup:
    quantity = contest.quantity.get(row.quantity)
    unit = f" {plain(quantity.unit)}" if quantity and quantity.unit else ""
    value, ends = estimate(*row.estimate.parts, signed=True)
    pair = f" {claim.better} − {row.than} in "
    return element("li", _verdict(row.verdict), pair, compared_label(contest, row.quantity), f": {value}{unit} {ends}")


def _verdict(word: str) -> Markup:
    return element("span", f"{SIGNS.get(word, '')} {word}".strip(), class_=f"verdict {word}")


def rungs_table(contest: ComparedFolder) -> Markup:
    """Return a row for each contender of each rung; nothing without halving."""
    rows = contest.document.rungs
    return table(RUNGS_HEAD, [_cells(row) for row in rows], class_="stacked") if rows else Markup()


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
