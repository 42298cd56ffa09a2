"""The opening of the page: what was asked, the sentences, and the key figures."""

from collections.abc import Sequence

from tuner.documents.comparison import ComparedFolder
from tuner.report.labels import channels_of, compared_label, in_plain_words, user_names
from tuner.text.markup import Markup, element, join
from tuner.text.neutral import Neutral
from tuner.text.numbers import count, duration
from tuner.text.sentences import counted, listing


def lead_text(compared: ComparedFolder) -> Markup:
    """Return the lead: who flew what, how often and on which airframes."""
    many = counted(len(compared.contenders), "controller")
    where = listing([f"{count(entry.flights)} of {entry.scenario}" for entry in compared.document.compared_on])
    flown = f" on {listing(compared.flown)}, compared on the same flights in the same air ({where}). "
    return join((element("strong", many[:1].upper() + many[1:]), flown, _tuned(compared)))


def _tuned(compared: ComparedFolder) -> str:
    """Return whose gains a search had chosen before."""
    names = {tuned: [entry.name for entry in compared.contenders if entry.tuned is tuned] for tuned in (True, False)}
    if not names[True]:
        return "All gains were given, none were tuned."
    if not names[False]:
        return "All were tuned by a search."
    return f"Tuned by a search: {listing(names[True])}; gains as given: {listing(names[False])}."


def key_figures(compared: ComparedFolder, further: Sequence[tuple[str, str]] = ()) -> list[tuple[str, str]]:
    """Return the numbers of the page, name and value."""
    figures = [
        ("Contenders", count(len(compared.contenders))),
        ("Flights in all", count(compared.document.flights)),
        ("Flights of each in the comparison", count(sum(entry.flights for entry in compared.document.compared_on))),
    ]
    return [*figures, *further, ("Wall time", duration(compared.document.wall_seconds))]


def words(compared: ComparedFolder, repeated: tuple[str, ...] = ()) -> Markup:
    """Return the sentences but for those with some beginnings, which stand below them."""
    names = {label: compared_label(compared, label) for label in compared.quantity}
    shown = [sentence for sentence in compared.document.words if not sentence.startswith(repeated)]
    texts = [in_plain_words(sentence, names) for sentence in shown]
    if channels_of(compared) is not None:
        texts = [*map(Neutral(user_names(compared)).text, texts)]
    return element("ul", *[element("li", text) for text in texts], class_="words") if texts else Markup()
