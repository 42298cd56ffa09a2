"""report.html of a contest or a comparison: who is best in what and by how much; sections without data are left out."""

from collections.abc import Sequence

from tuner.documents.contest import ComparedFolder
from tuner.report.charts.chart import Panel
from tuner.report.charts.web import grid, page_data
from tuner.report.contest.answer import answer_text
from tuner.report.contest.contenders_section import contenders_table, gains_cards
from tuner.report.contest.controls import contender_switches, interval_switch, response_choices
from tuner.report.contest.differences_section import forests
from tuner.report.contest.distribution_panels import distribution_panels
from tuner.report.contest.fronts_panels import fronts_panels
from tuner.report.contest.prose import claims, key_figures, lead_text, words
from tuner.report.contest.provenance import definitions, document_text, facts
from tuner.report.contest.published_section import printed_tables, strips
from tuner.report.contest.response_panels import response_panels
from tuner.report.contest.rungs_section import rungs_table
from tuner.report.contest.values_section import best_table, values_table, volumes_table
from tuner.report.labels import contest_label, has_rotors, in_plain_words, user_names
from tuner.report.page import Page, Section, aid, collapsible, collapsible_text, neutral_page, wide
from tuner.text.markup import Markup, described, element, join
from tuner.text.neutral import Neutral

AIDS = {
    "contenders": "Operations are those of the laws in one control step, counted and not timed.",
    "values": "Values on the flights of the comparison with 95 % intervals; smaller is better. ★ smallest, ≈ the smallest is "
    "not better than it, ✗ limit violated. Each drawing has its own scale, logarithmic where values cover decades; "
    "dashed line: limit.",
    "differences": "First contender minus second, paired over flights in the same air: left of the line the first is better. "
    "Bar: 95 % interval; filled mark: better or worse; hollow mark: neither.",
    "fronts": "Down and to the left is better. Ring: the recommended point of a contender; cross: a point with failed flights. "
    "Point at a mark for its gains, drag to zoom, double-click to zoom out.",
    "best": "Best point of each front that satisfies the limit, selected on held-out flights; values on the flights of the "
    "comparison. ★ best in the row.",
    "rungs": "Every search goes on to the rung; those whose fronts dominate most of the common box (up to 1.1 times the nadir of "
    "all fronts of the rung, on search flights, the same for all) go on. The study of each lies next to its folder: run with "
    "--reuse of that, it goes on where it stopped.",
    "published": "A printed number is one draw: the question is whether one of our flights could have given it. Ours is "
    "the mean over flights with the central 95 % of them in brackets. The percentile is that of the printed number; "
    "fitted: the study was set to meet it.",
    "strips": "Bar: central 95 % of our flights; stroke: their median; triangle: the printed number, filled where it is "
    "inside.",
    "distributions": "Share of flights with at most this value; the further left and the steeper, the better. The worst "
    "1 % of flights may lie beyond the right end.",
    "responses": "Bold line: flight 0, in the same air for all; band: 5 to 95 % of flights; dotted: reference. Time axes zoom "
    "together.",
    "gains": "In the units of the study file; bold: searched.",
}


def contest_page(contest: ComparedFolder) -> Page:
    """Return the page of a contest."""
    fronts, responses, spreads = fronts_panels(contest), response_panels(contest), distribution_panels(contest)
    document, names = contest.document, {label: contest_label(contest, label) for label in contest.quantity}
    lead = lead_text(contest) if has_rotors(contest) else Neutral(user_names(contest)).markup(lead_text(contest))
    parts = (
        element("p", answer, class_="answer") if (answer := answer_text(contest)) else "",
        element("p", lead, " Angles are in degrees.", class_="lead"),
        element("p", document.description, class_="aid") if document.description else "",
        words(contest),
        claims(contest),
    )
    page = Page(
        kind="comparison" if contest.kind == "comparison" else "contest report",
        title=document.title,
        ending=document.ending,
        lead=join(parts),
        opening=Markup(),
        warnings=[in_plain_words(text, names) for text in document.warnings],
        sections=_sections(contest, fronts, responses, spreads),
        data=page_data([*fronts, *responses, *spreads]),
        bar=contender_switches(contest),
    )
    return page if has_rotors(contest) else neutral_page(page, user_names(contest))


def _sections(
    contest: ComparedFolder, fronts: Sequence[Panel], responses: Sequence[Panel], spreads: Sequence[Panel]
) -> list[Section]:
    best, parts = contest.shown.best_under, contest.shown.differences
    return [
        Section("values", "Side by side", _values(contest)),
        Section("fronts", "Trade-offs", _fronts(contest, fronts)),
        Section("differences", "Paired differences", _with_aid("differences", forests(contest)) if parts else Markup()),
        Section("best", "Best under a limit", _with_aid("best", wide(best_table(contest))) if best else Markup()),
        Section(
            "distributions",
            "Scatter over flights",
            _with_aid("distributions", grid(spreads, "axis-grid")) if spreads else Markup(),
        ),
        Section("rungs", "Stopped searches", _rungs(contest)),
        Section("published", "Printed numbers", _published(contest)),
        Section("responses", "Responses", _responses(contest, responses)),
        Section("gains", "Gains", _with_aid("gains", gains_cards(contest))),
        Section("provenance", "Provenance", _provenance(contest)),
    ]


def _rungs(contest: ComparedFolder) -> Markup:
    rungs = rungs_table(contest)
    return _with_aid("rungs", wide(rungs)) if rungs else rungs


def _values(contest: ComparedFolder) -> Markup:
    parts = [_with_aid("values", wide(values_table(contest)))] if contest.estimates else []
    return join((*parts, element("h3", "The contenders"), _with_aid("contenders", wide(contenders_table(contest)))))


def _fronts(contest: ComparedFolder, panels: Sequence[Panel]) -> Markup:
    if contest.fronts is None or not panels:
        return Markup()
    form = f"front-grid objectives-{min(max(len(contest.fronts.objectives), 2), 4)}"
    return join(
        (aid(AIDS["fronts"]), interval_switch(), grid(panels, form), wide(volumes_table(contest, contest.fronts)))
    )


def _published(contest: ComparedFolder) -> Markup:
    if not contest.shown.published:
        return Markup()
    picture = (element("h3", "As a picture"), aid(AIDS["strips"]), strips(contest))
    return join((aid(AIDS["published"]), printed_tables(contest), *picture))


def _responses(contest: ComparedFolder, panels: Sequence[Panel]) -> Markup:
    if not panels:
        return Markup()
    grids = [
        grid([panel for panel in panels if panel.form == form], f"{'rotor' if form == 'rotor' else 'axis'}-grid")
        for form in ("air", "axis", "rotor")
    ]
    return join((aid(AIDS["responses"]), response_choices(contest), *grids))


def _provenance(contest: ComparedFolder) -> Markup:
    folds = (
        collapsible("Definitions", definitions(contest)),
        collapsible_text("Study file", contest.study_text),
        collapsible_text("All numbers of this page, as JSON", document_text(contest)),
    )
    return join(
        (described(key_figures(contest), class_="figures"), facts(contest), element("div", *folds, class_="foldings"))
    )


def _with_aid(key: str, content: Markup) -> Markup:
    return join((aid(AIDS[key]), content))
