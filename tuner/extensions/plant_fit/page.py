"""The page of a fit: the plant, data and model, residuals, step and frequency responses, rivals, and what is not known."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tuner.extensions.plant_fit.charts import (
    INPUT,
    MEASURED_LOOK,
    MODEL_LOOK,
    bode_panels,
    data_panels,
    residual_panels,
    step_panels,
)
from tuner.extensions.plant_fit.document import OutputRow, PlantFitDocument
from tuner.extensions.plant_fit.printer import noise_text, number_cells, rival_cells, transfer_text
from tuner.report.charts.chart import Panel
from tuner.report.charts.look import Look, legend
from tuner.report.charts.web import grid, page_data
from tuner.report.page import Page, Section, aid, wide
from tuner.text.markup import Markup, described, element, join, table
from tuner.text.numbers import count, per_cent, significant

if TYPE_CHECKING:
    from tuner.extensions.plant_fit.result import PlantFit

AIDS = {
    "data": "The model gets the measured inputs alone: no measured output corrects it.",
    "residuals": "Autocorrelations are those of one-step prediction errors behind the noise model. Of white noise, one bar in "
    "twenty passes the dashed lines.",
    "step": "Response to a step of one unit of the input, with the 95 % band of the covariance.",
    "bode": "Frequency response with its 95 % band, up to half the sampling rate.",
    "numbers": "95 % intervals, most of them likelihood profiles: a dead time trades with lags, so they are not symmetric.",
    "rivals": "Each structure is fitted without blocks of the record and judged by its errors there. The chosen one has "
    "the fewest parameters among those within two standard errors, or two per cent, of the best, and simulates the blocks "
    "better than their mean, if any does.",
    "unknown": "Numbers with intervals wider than themselves, and an experiment that would identify them.",
}
LINES = (("measured", MEASURED_LOOK), ("model", MODEL_LOOK), ("input", INPUT))


def fit_page(fit: "PlantFit") -> Page:
    """Return the page."""
    document = fit.document
    panels = [make(fit) for make in (data_panels, residual_panels, step_panels, bode_panels)]
    names = ", ".join(row.output for row in document.outputs)
    lead = [
        f"{row.output}: {row.structure}, which explains {per_cent(max(row.fit, 0.0))} of the record."
        for row in document.outputs
    ]
    return Page(
        kind="plant-fit",
        title=f"{names} by {', '.join(document.inputs)}, fitted to data",
        lead=element("p", " ".join(lead), class_="lead"),
        opening=described(_key_figures(document), class_="figures"),
        warnings=document.warnings,
        sections=_sections(document, *panels),
        data=page_data(panel for part in panels for panel in part),
    )


def _key_figures(document: PlantFitDocument) -> list[tuple[str, str]]:
    rows = []
    for row in document.outputs:
        rows += [(f"{row.output} / {each.input}", transfer_text(each)) for each in row.transfer_functions]
        rows.append((f"{row.output}, fit on held-out blocks", per_cent(max(row.held_out, 0.0))))
    return rows


def _sections(
    document: PlantFitDocument,
    data: Sequence[Panel],
    residuals: Sequence[Panel],
    steps: Sequence[Panel],
    bode: Sequence[Panel],
) -> list[Section]:
    notes = [f"{row.output}: {note}" for row in document.outputs for note in row.notes]
    listed = element("ul", *[element("li", note) for note in notes]) if notes else Markup()
    return [
        Section("measured", "Data and model", _charts("data", data, LINES)),
        Section("numbers", "The plant", join((aid(AIDS["numbers"]), *[_numbers(row) for row in document.outputs]))),
        Section("unknown", "Wide intervals", join((aid(AIDS["unknown"]), listed)) if notes else Markup()),
        Section("residuals", "Residuals", _charts("residuals", residuals)),
        Section("step", "Step response", _charts("step", steps)),
        Section("bode", "Frequency response", _charts("bode", bode)),
        Section("rivals", "Rival structures", join((aid(AIDS["rivals"]), *[_rivals(row) for row in document.outputs]))),
        Section("records", "Records", wide(_records(document))),
    ]


def _charts(key: str, panels: Sequence[Panel], names: Sequence[tuple[str, Look]] = ()) -> Markup:
    return join((aid(AIDS[key]), legend(names) if names else "", grid(panels, "axis-grid")))


def _numbers(row: OutputRow) -> Markup:
    head = ("input", "", "value", "95 % interval", "unit")
    content = table(head, [number_cells(number) for number in row.numbers])
    return join((element("h3", f"{row.output}: {row.structure}"), wide(content), element("p", noise_text(row))))


def _rivals(row: OutputRow) -> Markup:
    head = ("structure", "parameters", "fit", "on held-out blocks", "squared error over the best's")
    return join((element("h3", row.output), wide(table(head, [rival_cells(rival) for rival in row.rivals]))))


def _records(document: PlantFitDocument) -> Markup:
    cells = []
    for row in document.records:
        duration, period = (f"{significant(value)} s" for value in (row.duration, row.period))
        cells.append((row.file, count(row.samples), duration, period, row.sha256[:16], "; ".join(row.notes)))
    return table(("", "samples", "duration", "interval", "sha256", ""), cells)
