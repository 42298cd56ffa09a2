"""report.html of a tuning run: the answer, the trade-off, the point picked, whether to believe it, and where it comes from."""

from collections.abc import Sequence

from tuner.documents.summary import TableRow
from tuner.documents.tuning import TuningFolder
from tuner.report.answer_section import answer, answer_table, states_table
from tuner.report.charts.progress import front_probability_panel, gap_panels, progress_panels
from tuner.report.charts.web import Arrays, grid, to_web
from tuner.report.controls import layer_switches
from tuner.report.explorer_data import explorer_data, limited_quantities
from tuner.report.explorer_section import axis_choices, explorer_section, plane
from tuner.report.labels import in_plain_words, names_of
from tuner.report.named_points import points_table
from tuner.report.opinion_section import opinion_section, opinion_text
from tuner.report.page import Page, Section, neutral_page, wide
from tuner.report.point_section import point_section
from tuner.report.provenance import provenance_section
from tuner.report.sheets import added_panels
from tuner.report.trust_section import trust_section
from tuner.report.tuning_charts import margin_panels, response_panels, spectrum_panels
from tuner.text.markup import Markup, element, join


def tuning_page(results: TuningFolder) -> Page:
    """Return the page of a results folder."""
    arrays, responses, loops = Arrays(), [*response_panels(results), *spectrum_panels(results)], margin_panels(results)
    trust = [
        *gap_panels(results),
        *filter(None, [front_probability_panel(results)]),
        *progress_panels(results.progress),
    ]
    more = [panel for panels in added_panels(results).values() for panel in panels]
    limited = limited_quantities(results)
    limits, _ = limited
    opinion = results.document.opinion
    charts = {panel.key: to_web(panel, arrays) for panel in [*responses, *loops, *trust, *more]}
    page = Page(
        kind="tuning report",
        title=results.document.title,
        ending=results.document.ending,
        lead=join((answer(results), _opinion_line(results), _description(results))),
        opening=_opening(results, limits),
        warnings=[in_plain_words(text, names_of(results)) for text in results.document.warnings],
        sections=(
            Section("front", "Explore the trade-off", explorer_section(results, limits)),
            Section("point", "Selected point", point_section(results, responses, loops)),
            *([Section("opinion", "Against the present gains", opinion_section(opinion))] if opinion else []),
            Section("trust", "Reliability", trust_section(results, grid(trust, "trust-grid"))),
            Section("provenance", "Provenance", provenance_section(results)),
        ),
        data=explorer_data(results, limited, charts, arrays),
    )
    return page if results.has_rotors else neutral_page(page, _user_names(results))


def _user_names(results: TuningFolder) -> list[str]:
    """Return the names that study and plant give."""
    plant = results.resolved.plant
    scenarios = [str(entry.get("name", "")) for entry in results.resolved.scenario]
    signals = [fan.signal for fan in results.fans] + [loop.channel for loop in results.loops]
    titles = [results.document.title, *([plant.title, plant.name] if plant else [])]
    return [*titles, *scenarios, *signals, *[row.name for row in results.variables]]


def _opinion_line(results: TuningFolder) -> Markup:
    opinion = results.document.opinion
    return Markup() if opinion is None else element("p", opinion_text(opinion).replace("`", ""), class_="lead")


def _description(results: TuningFolder) -> Markup:
    text = results.resolved.description
    return element("p", text, class_="aid") if text else Markup()


def _opening(results: TuningFolder, limits: Sequence[TableRow]) -> Markup:
    """Return the answer as a table next to the trade-off."""
    name = results.document.gains_file
    actions = element(
        "div",
        element("button", f"Save {name}", type="button", id="save-tuned"),
        element("button", f"Copy {name}", type="button", id="copy-tuned"),
        class_="actions",
    )
    left = element("div", wide(answer_table(results)), points_table(results), states_table(results), actions)
    right = element("div", plane(results), layer_switches(results), axis_choices(results, limits))
    return element("div", left, right, class_="opening", id="answer")
