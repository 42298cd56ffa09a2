"""The section on sensitivity of a run's page."""

from tuner.documents.parts import SampledValue
from tuner.documents.tuning import TuningFolder
from tuner.extensions.sensitivity.document import SensitivityDocument
from tuner.report.page import aid, wide
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import estimate


def sensitivity_section(results: TuningFolder) -> Markup:
    """Return the Sobol indices of an analysis in the folder, if any."""
    file = results.home / "sensitivity.json"
    sensitivity = SensitivityDocument.read(file) if file.exists() else None
    if sensitivity is None and results.is_external:
        return Markup()
    if sensitivity is None:
        note = "No sensitivity analysis in this folder; compute one with tuner sensitivity."
        return aid(note)
    wanted = [row for row in sensitivity.indices if row.scale == "rank"] or sensitivity.indices
    outputs = list(dict.fromkeys(row.output for row in wanted))
    names = list(dict.fromkeys(row.variable for row in wanted))
    by_place = {(row.variable, row.output): row.total for row in wanted}
    rows = [[element("code", name), *[_index(by_place.get((name, output))) for output in outputs]] for name in names]
    text = (
        "Share of the spread of each quantity, over the whole search ranges, that vanishes when a gain is fixed (total Sobol "
        "index of ranks), with 95 % intervals: near 0 the gain does not matter."
    )
    return join(
        (
            element("h3", "Sensitivity to the gains"),
            aid(text),
            wide(table(["Gain", *outputs], rows, class_="stacked")),
        )
    )


def _index(entry: SampledValue | None) -> Markup:
    if entry is None:
        return Markup()
    value, interval = estimate(entry.value, entry.low, entry.high)
    return element("span", value, " ", element("small", interval, class_="interval"), class_="number")
