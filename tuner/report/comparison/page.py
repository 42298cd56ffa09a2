"""report.html of a comparison: who is best in what and by how much; sections without data are left out."""

from collections.abc import Sequence
from dataclasses import dataclass

from tuner.documents.comparison import ComparedFolder
from tuner.report.charts.chart import Panel
from tuner.report.charts.web import grid, page_data
from tuner.report.comparison.answer import answer_text
from tuner.report.comparison.contenders_section import contenders_table, gains_cards
from tuner.report.comparison.controls import contender_switches, interval_switch, response_choices
from tuner.report.comparison.differences_section import forests
from tuner.report.comparison.distribution_panels import distribution_panels
from tuner.report.comparison.fronts_panels import fronts_panels
from tuner.report.comparison.prose import key_figures, lead_text, words
from tuner.report.comparison.provenance import definitions, document_text, facts
from tuner.report.comparison.response_panels import response_panels
from tuner.report.comparison.values_section import best_table, values_table, volumes_table
from tuner.report.labels import channels_of, compared_label, in_plain_words, user_names
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
    "distributions": "Share of flights with at most this value; the further left and the steeper, the better. The worst "
    "1 % of flights may lie beyond the right end.",
    "responses": "Bold line: flight 0, in the same air for all; band: 5 to 95 % of flights; dotted: reference. Time axes zoom "
    "together.",
    "gains": "In the units of the study file; bold: searched.",
}


@dataclass(frozen=True)
class Further:
    """Parts that another kind of comparison adds to the page.

    Attributes:
        opening: Below the sentences at the top.
        repeated: Beginnings of sentences that the opening repeats.
        figures: Key figures, name and value.
        sections: Behind the scatter over flights.
    """

    opening: Markup = Markup()
    repeated: tuple[str, ...] = ()
    figures: Sequence[tuple[str, str]] = ()
    sections: Sequence[Section] = ()


NOTHING = Further()


def comparison_page(compared: ComparedFolder, kind: str = "comparison", further: Further = NOTHING) -> Page:
    """Return the page of a comparison; kind: of page, as its head names it."""
    fronts, responses, spreads = fronts_panels(compared), response_panels(compared), distribution_panels(compared)
    document, names = compared.document, {label: compared_label(compared, label) for label in compared.quantity}
    lead = (
        lead_text(compared)
        if channels_of(compared) is None
        else Neutral(user_names(compared)).markup(lead_text(compared))
    )
    parts = (
        element("p", answer, class_="answer") if (answer := answer_text(compared)) else "",
        element("p", lead, " Angles are in degrees.", class_="lead"),
        element("p", document.description, class_="aid") if document.description else "",
        words(compared, further.repeated),
        further.opening,
    )
    page = Page(
        kind=kind,
        title=document.title,
        ending=document.ending,
        lead=join(parts),
        opening=Markup(),
        warnings=[in_plain_words(text, names) for text in document.warnings],
        sections=_sections(compared, fronts, responses, spreads, further),
        data=page_data([*fronts, *responses, *spreads]),
        bar=contender_switches(compared),
    )
    return page if channels_of(compared) is None else neutral_page(page, user_names(compared))


def _sections(
    compared: ComparedFolder,
    fronts: Sequence[Panel],
    responses: Sequence[Panel],
    spreads: Sequence[Panel],
    further: Further,
) -> list[Section]:
    best, parts = compared.shown.best_under, compared.shown.differences
    return [
        Section("values", "Side by side", _values(compared)),
        Section("fronts", "Trade-offs", _fronts(compared, fronts)),
        Section(
            "differences", "Paired differences", _with_aid("differences", forests(compared)) if parts else Markup()
        ),
        Section("best", "Best under a limit", _with_aid("best", wide(best_table(compared))) if best else Markup()),
        Section(
            "distributions",
            "Scatter over flights",
            _with_aid("distributions", grid(spreads, "axis-grid")) if spreads else Markup(),
        ),
        *further.sections,
        Section("responses", "Responses", _responses(compared, responses)),
        Section("gains", "Gains", _with_aid("gains", gains_cards(compared))),
        Section("provenance", "Provenance", _provenance(compared, further)),
    ]


def _values(compared: ComparedFolder) -> Markup:
    parts = [_with_aid("values", wide(values_table(compared)))] if compared.estimates else []
    return join((*parts, element("h3", "The contenders"), _with_aid("contenders", wide(contenders_table(compared)))))


def _fronts(compared: ComparedFolder, panels: Sequence[Panel]) -> Markup:
    if compared.fronts is None or not panels:
        return Markup()
    form = f"front-grid objectives-{min(max(len(compared.fronts.objectives), 2), 4)}"
    return join(
        (aid(AIDS["fronts"]), interval_switch(), grid(panels, form), wide(volumes_table(compared, compared.fronts)))
    )


def _responses(compared: ComparedFolder, panels: Sequence[Panel]) -> Markup:
    if not panels:
        return Markup()
    grids = [
        grid([panel for panel in panels if panel.form == form], f"{'rotor' if form == 'rotor' else 'axis'}-grid")
        for form in ("air", "axis", "rotor")
    ]
    return join((aid(AIDS["responses"]), response_choices(compared), *grids))


def _provenance(compared: ComparedFolder, further: Further) -> Markup:
    folds = (
        collapsible("Definitions", definitions(compared)),
        collapsible_text("Study file", compared.study_text),
        collapsible_text("All numbers of this page, as JSON", document_text(compared)),
    )
    return join(
        (
            described(key_figures(compared, further.figures), class_="figures"),
            facts(compared),
            element("div", *folds, class_="foldings"),
        )
    )


def _with_aid(key: str, content: Markup) -> Markup:
    return join((aid(AIDS[key]), content))
