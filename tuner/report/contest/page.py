"""report.html of a contest: one offline page, from what was asked to its provenance; what has no data is left out."""

from pathlib import Path
from string import Template

from plotly.offline import get_plotlyjs

from tuner.documents.contest import Contest
from tuner.documents.contest_loading import load_contest
from tuner.report.chart import Charts, Panel
from tuner.report.contest.best_section import best_table
from tuner.report.contest.contenders_section import contenders_table, gains_cards
from tuner.report.contest.controls import contender_switches, interval_switch, response_choices
from tuner.report.contest.differences_section import forests
from tuner.report.contest.distribution_charts import add_distributions
from tuner.report.contest.front_charts import add_fronts
from tuner.report.contest.inference_page import inference_parts
from tuner.report.contest.prose import asked, claims, key_figures, words
from tuner.report.contest.provenance import definitions, document_text, facts
from tuner.report.contest.published_section import printed_tables, strips
from tuner.report.contest.response_charts import add_responses
from tuner.report.contest.values_section import values_table
from tuner.report.contest.volumes_section import volumes_table
from tuner.report.page import asset, embedded, ending_aside, grid, page_section, put_page, warnings_aside
from tuner.text.markup import Markup, described, element, join, safe

AIDS = {
    "contenders": "Operations are those of the laws in one control step, counted and not timed.",
    "values": "Values on the flights of the comparison with 95 % intervals; smaller is better. ★ smallest, ≈ not told apart "
    "from the smallest by the paired difference, ✗ limit broken. Every drawing has a scale of its own, logarithmic where values "
    "cover decades; a dashed line is a limit.",
    "differences": "The one named first minus the other, flight by flight in the same air: left of the line the one named "
    "first is better. Bar: 95 % interval; filled mark: the interval leaves out zero; hollow mark: it does not.",
    "fronts": "Down and to the left is better. Ring: the recommended point of a contender; cross: a point that lost flights. "
    "Point at a mark for its gains, drag to zoom, double-click to zoom out.",
    "best": "The best point of each front that keeps the limit, picked on held-out flights; values are those on the flights of "
    "the comparison. ★ best in the row.",
    "published": "A printed number is one draw: the question is whether one of our flights could have given it. Ours is "
    "the mean over flights with the central 95 % of them in brackets. The percentile is that of the printed number; "
    "fitted: the study was set to meet it.",
    "strips": "Bar: central 95 % of our flights; stroke: their median; triangle: the printed number, filled where it is "
    "inside.",
    "distributions": "Share of flights with at most this value; the further left and the steeper, the better. The worst "
    "1 % of flights may lie beyond the right end.",
    "responses": "Bold line: flight 0, the same air for all; band: 5 to 95 % of flights; dotted: the reference. Zooming one "
    "figure in time zooms all.",
    "gains": "In the units of the study file; bold: chosen by the search.",
}


def write_contest_page(folder: Path) -> Path:
    """Write report.html into a contest folder; StoreError where a file is missing, damaged or cannot be written."""
    return put_page(folder, page(load_contest(folder)))


def page(contest: Contest) -> str:
    """Return the page of a contest folder."""
    charts = Charts()
    sections = {key: (name, content) for key, name, content in _sections(contest, charts) if content}
    document = contest.document
    description = document.get("description")
    opening = join((asked(contest), " Angles are in rad throughout, as in printed numbers and in study files."))
    return Template(asset("page.html")).substitute(
        kind="comparison" if (contest.folder / "comparison.json").exists() else "contest report",
        title=safe(document["title"]),
        ending=ending_aside(document.get("ending", [])),
        description=element("p", str(description)) if description else "",
        paragraph=opening,
        figures=join((words(contest), claims(contest), described(key_figures(contest), class_="figures"))),
        warnings=warnings_aside(document["warnings"]),
        navigation=join(element("li", element("a", name, href=f"#{key}")) for key, (name, _) in sections.items()),
        sections=join((contender_switches(contest), *[page_section(key, *entry) for key, entry in sections.items()])),
        data=embedded(charts),
        style="\n".join((asset("page.css"), asset("contest/contest.css"))),
        script=asset("page.js"),
        plotly=get_plotlyjs(),
    )


def _sections(contest: Contest, charts: Charts) -> list[tuple[str, str, Markup]]:
    return [
        ("values", "Side by side", _values(contest)),
        (
            "differences",
            "Paired differences",
            _with_aid("differences", forests(contest)) if contest.differences else Markup(),
        ),
        ("fronts", "Trade-offs", _fronts(contest, charts)),
        (
            "best",
            "Best under a limit",
            _with_aid("best", _wide(best_table(contest))) if contest.best_under else Markup(),
        ),
        ("distributions", "Scatter over flights", _charts("distributions", add_distributions(contest, charts), "axis")),
        ("published", "Printed numbers", _published(contest)),
        ("responses", "Responses", _responses(contest, charts)),
        ("gains", "Gains", _with_aid("gains", gains_cards(contest))),
        *_inference(contest),
        ("provenance", "Provenance", _provenance(contest)),
    ]


def _values(contest: Contest) -> Markup:
    parts = [_with_aid("values", _wide(values_table(contest)))] if contest.estimates else []
    return join((*parts, element("h3", "The contenders"), _with_aid("contenders", _wide(contenders_table(contest)))))


def _fronts(contest: Contest, charts: Charts) -> Markup:
    if contest.fronts is None or not contest.fronts.fronts:
        return Markup()
    panels = add_fronts(contest, contest.fronts, charts)
    form = f"front-grid objectives-{min(max(len(contest.fronts.objectives), 2), 4)}"
    return join((_aid("fronts"), interval_switch(), grid(panels, form), _wide(volumes_table(contest, contest.fronts))))


def _published(contest: Contest) -> Markup:
    if not contest.cells:
        return Markup()
    return join(
        (_aid("published"), printed_tables(contest), element("h3", "As a picture"), _aid("strips"), strips(contest))
    )


def _responses(contest: Contest, charts: Charts) -> Markup:
    panels = add_responses(contest, charts)
    if not panels:
        return Markup()
    grids = [
        grid([panel for panel in panels if panel.form == form], f"{'rotor' if form == 'rotor' else 'axis'}-grid")
        for form in ("air", "axis", "rotor")
    ]
    return join((_aid("responses"), response_choices(contest), *grids))


def _inference(contest: Contest) -> list[tuple[str, str, Markup]]:
    if contest.inference is None:
        return []
    told = element("ul", *[element("li", sentence) for sentence in contest.inference.words], class_="words")
    parts = inference_parts(contest.inference)
    shown = [element("section", element("h3", name), content, id=f"inference-{key}") for key, name, content in parts]
    return [("inference", "Open values inferred", join((told, *shown)))]


def _provenance(contest: Contest) -> Markup:
    files = (
        ("Study file as given", contest.study),
        ("Every number of this page, as JSON", document_text(contest)),
    )
    folded = [element("details", element("summary", name), element("pre", text, tabindex="0")) for name, text in files]
    return join((facts(contest), element("h3", "What the words mean"), definitions(contest), *folded))


def _charts(key: str, panels: list[Panel], form: str) -> Markup:
    return join((_aid(key), grid(panels, f"{form}-grid"))) if panels else Markup()


def _with_aid(key: str, content: Markup) -> Markup:
    return join((_aid(key), content))


def _wide(content: Markup) -> Markup:
    return element("div", content, class_="wide")


def _aid(key: str) -> Markup:
    return element("p", AIDS[key], class_="aid")
