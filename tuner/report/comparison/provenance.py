"""Origin of the numbers of a comparison: seed, flights, machine, versions, the command, and what the words mean."""

from tuner.documents.comparison import ComparedFolder
from tuner.report.provenance import RULE_TEXT, environment_facts, glossary
from tuner.text.markup import Markup, described
from tuner.text.numbers import MISSING, count, duration, significant

WORDS = (
    ("Held-out", "in scenarios that no search saw; flight i is in the same air for every contender."),
    ("95 % interval", "bootstrap over flights: it covers the sampling of flights, not errors of the model."),
    (
        "Difference",
        "paired over flights in the same air, so its interval is narrower than those of the two values suggest.",
    ),
    ("Lower", RULE_TEXT),
    (
        "Survives, fails, undecided",
        "a claim survives where every difference behind it is for it, fails where one is against it, "
        "and is undecided else.",
    ),
    (
        "Inside",
        "the printed number lies between the 2.5 and the 97.5 percentile of our flights: one of them could have given it.",
    ),
    ("Percentile", "share of our flights that lie below the printed number, in per cent."),
    (
        "Front",
        "feasible points of a contender that none of its feasible points dominates.",
    ),
)


def facts(compared: ComparedFolder) -> Markup:
    """Return study, seed, flights, machine, command and versions."""
    document = compared.document
    scenarios = [
        f"{entry.scenario}: {count(entry.flights)} of {significant(entry.duration)} s each"
        for entry in compared.document.compared_on
    ]
    shown = [
        ("Study", document.study),
        ("Seed", significant(document.seed, 15)),
        ("Flights", f"{count(document.flights)} in {duration(document.wall_seconds)}"),
        ("Compared on", "; ".join(scenarios) or MISSING),
        *environment_facts(compared.environment),
    ]
    return described(shown, class_="facts columns")


def definitions(compared: ComparedFolder) -> Markup:
    """Return definitions: of the metrics, of counted operations and of the words of the page."""
    words = list(WORDS)
    if compared.fronts is not None and compared.fronts.meaning:
        words.append(("Share of the box", compared.fronts.meaning))
    costs = [row.cost for row in compared.document.contenders]
    words += [("Operations", cost.meaning) for cost in costs[:1]]
    for counted in [cost.processor for cost in costs if cost.processor is not None][:1]:
        tools = f"{counted.compiler} ({counted.flags}), {counted.emulator}"
        words.append(("Instructions", f"On a {counted.target}: {counted.meaning}. {tools}."))
    return glossary(compared.shown.quantities, words)


def document_text(compared: ComparedFolder) -> str:
    """Return the document as JSON."""
    return compared.document.text().rstrip()
