"""The page of an identification: a verdict, what was predicted next to what was measured, what is left over, and the
intervals.
"""

from collections.abc import Sequence

from tuner.extensions.identification.charts import (
    MEASURED,
    MODELLED,
    prediction_panels,
    response_panels,
    spectrum_panels,
    whiteness_panels,
)
from tuner.extensions.identification.document import FlightRow, IdentificationDocument, IdentifiedNumber, LogRow
from tuner.extensions.identification.identify import Identified
from tuner.report.charts.chart import Panel
from tuner.report.charts.look import Look, legend
from tuner.report.charts.web import grid, page_data
from tuner.report.page import Page, Section, aid, wide
from tuner.text.markup import Markup, described, element, join, table
from tuner.text.numbers import count, estimate, per_cent, significant

AIDS = {
    "prediction": "Windows that the fit did not see, those with the most motion, one after the other, with the 95 % band of what "
    "the posterior and the noise leave open. A straight line in the rates and the mean of the lift do not count.",
    "spectra": "If the model explains nothing, both lines coincide; what it leaves over at high frequencies is noise "
    "of the sensors.",
    "whiteness": "Residuals behind the noise model. Of white noise, one bar in twenty stands beyond the dashed lines.",
    "responses": "Response of each output to the motor commands of its axis, by cross spectra of the logs and by the fitted "
    "numbers, with 95 % bands. That of the logs is drawn where the coherence is above the dashed line and noise and leakage are "
    "small. Setpoints of the rates are the instrument where the log has them; without them, feedback of noise and air bends it "
    "towards the inverse of the controller.",
    "numbers": "95 % intervals, and those known before the flight.",
    "untold": "These stand where they stood before the flight, and their prior is in the airframe file's [uncertainty].",
    "flights": "Each flight alone, and all together with the scatter between them. A chi-square test compares each with the "
    "others; a difference of more than 1.96 standard deviations is printed.",
    "regressions": "Ordinary least squares of the same data, one way and the other: the true inertia lies between the two.",
}

PREDICTED = (("measured", MEASURED), ("predicted, with its 95 % band", MODELLED))
SPECTRA = (("measured", MEASURED), ("left over", MODELLED))
RESPONSES = (("from the logs", MEASURED), ("of the model", MODELLED))


def identification_page(fit: Identified, document: IdentificationDocument) -> Page:
    """Return the page."""
    parts = (prediction_panels(fit), spectrum_panels(fit), whiteness_panels(fit))
    # Flights too short to hold windows out have no panels of these.
    shown = [[panel for panel, used in zip(part, fit.problem.outputs, strict=bool(part)) if used] for part in parts]
    shown.append(response_panels(document.responses))
    return Page(
        kind="identification",
        title=f"{document.airframe}, identified from flight logs",
        lead=element("p", document.verdict, class_="lead"),
        opening=described(_key_figures(document), class_="figures"),
        warnings=document.warnings,
        sections=_sections(document, *shown),
        data=page_data(panel for part in shown for panel in part),
    )


def _sections(
    document: IdentificationDocument,
    predicted: Sequence[Panel],
    spectra: Sequence[Panel],
    whiteness: Sequence[Panel],
    responses: Sequence[Panel],
) -> list[Section]:
    identified, left = ([row for row in document.numbers if row.identified is wanted] for wanted in (True, False))
    return [
        Section("prediction", "Predicted and measured", _charts("prediction", predicted, PREDICTED)),
        Section("spectra", "Residuals of the model", _charts("spectra", spectra, SPECTRA)),
        Section("whiteness", "Whiteness of the residuals", _charts("whiteness", whiteness)),
        Section("responses", "Frequency responses", _charts("responses", responses, RESPONSES)),
        Section(
            "numbers",
            "Identified parameters",
            _with_aid("numbers", _numbers([*identified, *document.curve])) if identified else Markup(),
        ),
        Section(
            "untold", "Parameters that are not identified", _with_aid("untold", _untold(left)) if left else Markup()
        ),
        Section("regressions", "Regressions for comparison", _with_aid("regressions", _regressions(document))),
        Section(
            "flights", "Flights", _with_aid("flights", _flights(document)) if len(document.flights) > 1 else Markup()
        ),
        Section("logs", "Logs", wide(_logs(document.logs))),
    ]


def _key_figures(document: IdentificationDocument) -> list[tuple[str, str]]:
    n_identified = sum(row.identified for row in document.numbers)
    return [
        ("Numbers identified", f"{n_identified} of {len(document.numbers)}"),
        *[
            (f"{row.output} explained", "hardly moved" if row.is_quiet else per_cent(max(row.explained, 0.0)))
            for row in document.prediction
        ],
        ("In the 95 % band", " to ".join(dict.fromkeys(_ends([row.covered for row in document.prediction])))),
    ]


def _ends(shares: Sequence[float]) -> list[str]:
    return [per_cent(min(shares)), per_cent(max(shares))] if shares else ["nothing predicted"]


def _charts(key: str, panels: Sequence[Panel], names: Sequence[tuple[str, Look]] = ()) -> Markup:
    return join((aid(AIDS[key]), legend(names) if names else "", grid(panels, "axis-grid"))) if panels else Markup()


def _with_aid(key: str, content: Markup) -> Markup:
    return join((aid(AIDS[key]), wide(content)))


def _numbers(rows: Sequence[IdentifiedNumber]) -> Markup:
    cells = []
    for row in rows:
        value, interval = estimate(row.value, row.low, row.high)
        before = estimate(row.prior, row.prior_low, row.prior_high)[1]
        cells.append((row.name, row.meaning, value, interval, before, _unit(row.unit)))
    return table(("", "meaning", "value", "95 % interval", "before", "unit"), cells)


def _untold(rows: Sequence[IdentifiedNumber]) -> Markup:
    cells = [(row.name, row.meaning, significant(row.value, 3), _unit(row.unit), row.reason) for row in rows]
    return table(("", "meaning", "prior", "unit", "why"), cells)


def _flights(document: IdentificationDocument) -> Markup:
    pooled = [row for row in document.numbers if row.identified]
    cells = [
        (
            row.name,
            *[_flight_cell(flight, row.name) for flight in document.flights],
            " ".join(estimate(row.value, row.low, row.high)),
            _unit(row.unit),
        )
        for row in pooled
    ]
    tests = ["" if row.probability is None else significant(row.probability, 2) for row in document.flights]
    names = [row.flight for row in document.flights]
    return table(("", *names, "pooled", "unit"), [*cells, ("probability of the same vehicle", *tests, "", "")])


def _flight_cell(flight: FlightRow, name: str) -> str:
    number = next((entry for entry in flight.numbers if entry.name == name), None)
    if number is None:
        return ""
    text = " ".join(estimate(number.value, number.low, number.high))
    return text if number.difference is None else f"{text} ({number.difference:+.1f} sd)"


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _regressions(document: IdentificationDocument) -> Markup:
    cells = [
        (f"I{row.axis}", significant(row.acceleration_on_torque, 3), significant(row.torque_on_acceleration, 3))
        for row in document.regressions
    ]
    return table(("", "acceleration on torque [kg m²]", "torque on acceleration [kg m²]"), cells)


def _logs(rows: Sequence[LogRow]) -> Markup:
    cells = [
        (
            row.file,
            row.kind,
            f"{row.begin:.1f} to {row.end:.1f} s",
            f"{row.rate:.0f} Hz",
            count(row.lost),
            row.sha256[:16],
        )
        for row in rows
    ]
    return table(("", "kind", "flight", "rate", "lost", "sha256"), cells)
