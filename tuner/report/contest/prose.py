"""The opening of the page: what was asked, the sentences, the claims with their verdicts, and the key figures."""

from tuner.documents.contest import ComparedFolder
from tuner.documents.contest_document import ClaimRow, RulingRow
from tuner.report.labels import contest_label, has_rotors, in_plain_words, user_names
from tuner.text.markup import Markup, element, join
from tuner.text.neutral import Neutral
from tuner.text.numbers import count, duration, estimate
from tuner.text.sentences import counted, listing
from tuner.text.units import plain

SIGNS = {"survives": "✓", "fails": "✗", "undecided": "≈"}
COUNTS = {"survives": "for it", "fails": "against it", "undecided": "without a decision"}


def lead_text(contest: ComparedFolder) -> Markup:
    """Return the lead: who flew what, how often and on which airframes."""
    many = counted(len(contest.contenders), "controller")
    where = listing([f"{count(entry.flights)} of {entry.scenario}" for entry in contest.document.compared_on])
    flown = f" on {listing(contest.flown)}, compared on the same flights in the same air ({where}). "
    return join((element("strong", many[:1].upper() + many[1:]), flown, _tuned(contest)))


def _tuned(contest: ComparedFolder) -> str:
    """Return whose gains a search had chosen before."""
    names = {tuned: [entry.name for entry in contest.contenders if entry.tuned is tuned] for tuned in (True, False)}
    if not names[True]:
        return "All gains were given, none were tuned."
    if not names[False]:
        return "All were tuned by a search."
    return f"Tuned by a search: {listing(names[True])}; gains as given: {listing(names[False])}."


def key_figures(contest: ComparedFolder) -> list[tuple[str, str]]:
    """Return the numbers at the top of the page, name and value."""
    figures = [
        ("Contenders", count(len(contest.contenders))),
        ("Flights in all", count(contest.document.flights)),
        ("Flights of each in the comparison", count(sum(entry.flights for entry in contest.document.compared_on))),
    ]
    free = [cell.inside for cell in contest.shown.published if not cell.fitted]
    if free:
        figures.append(("Printed numbers inside", f"{sum(free)} of {len(free)}"))
    surviving = [claim.verdict == "survives" for claim in contest.shown.claims]
    if surviving:
        figures.append(("Claims that survive", f"{sum(surviving)} of {len(surviving)}"))
    return [*figures, ("Wall time", duration(contest.document.wall_seconds))]


def words(contest: ComparedFolder) -> Markup:
    """Return the sentences of the contest but for those that only repeat a claim, which stands below them."""
    beginnings = tuple(f'The claim "{claim.text}"' for claim in contest.shown.claims if claim.text)
    names = {label: contest_label(contest, label) for label in contest.quantity}
    shown = [sentence for sentence in contest.document.words if not (beginnings and sentence.startswith(beginnings))]
    texts = [in_plain_words(sentence, names) for sentence in shown]
    if not has_rotors(contest):
        texts = [*map(Neutral(user_names(contest)).text, texts)]
    return element("ul", *[element("li", text) for text in texts], class_="words") if texts else Markup()


def claims(contest: ComparedFolder) -> Markup:
    """Return every claim with its verdict, and the comparisons behind it folded away."""
    if not contest.shown.claims:
        return Markup()
    return element("div", *[_claim(contest, claim) for claim in contest.shown.claims], class_="claims")


def _claim(contest: ComparedFolder, claim: ClaimRow) -> Markup:
    text = claim.text or f"{claim.better} is better"
    counts = [(sum(row.verdict == kind for row in claim.rows), name) for kind, name in COUNTS.items()]
    names = {label: contest_label(contest, label) for label in contest.quantity}
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
    return element("li", _verdict(row.verdict), pair, contest_label(contest, row.quantity), f": {value}{unit} {ends}")


def _verdict(word: str) -> Markup:
    return element("span", f"{SIGNS.get(word, '')} {word}".strip(), class_=f"verdict {word}")
