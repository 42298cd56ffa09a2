"""An inference as tables: which printed numbers some setting reproduces, and the open values that they identify."""

from math import exp

from tuner.documents.inference_document import CellRow, InferenceDocument, RatioRow, UnknownRow
from tuner.report.charts.look import Look, looks, sample
from tuner.report.charts.strip import StripScale, ranged
from tuner.report.contest.published_section import percentile_text
from tuner.text.markup import Markup, element, join, table
from tuner.text.numbers import MISSING, estimate, significant
from tuner.text.units import marked_up

UNKNOWN_HEAD = ("Open value", "Unit", "Before", "Inferred", "Range searched", "Identified?")
RATIO_HEAD = ("Ratio", "Printed", "Ours at the inferred setting", "Reproduced?")
VERDICTS = {"told": "✓ identified", "loosely": "≈ loosely", "not": "✗ not identified"}
BY = {
    "here": "✓ inside at the inferred setting",
    "near": "≈ inside under a setting that fits about as well",
    "elsewhere": "≈ inside only under settings that fit less well",
    "nowhere": "✗ inside under no setting",
}
CLASSES = {"here": "inside", "near": "undecided", "elsewhere": "undecided", "nowhere": "outside"}


def unknowns_table(inference: InferenceDocument) -> Markup:
    """Return a row an open value: before, inferred, and where that lies in the range searched."""
    return table(UNKNOWN_HEAD, [_unknown(entry) for entry in inference.unknowns], class_="unknowns stacked")


def cells_table(inference: InferenceDocument) -> Markup:
    """Return the printed table, rows metrics and columns contenders, with what the inferred setting makes of it."""
    style = _looks(inference)
    names = [name for name in inference.contenders if any(cell.contender == name for cell in inference.cells)]
    heads = [join((sample(style[name]), element("br"), name)) for name in names]
    top = element("tr", *[element("th", head, scope="col") for head in ("Printed number", *heads)])
    rows = dict.fromkeys((cell.metric, cell.scenario) for cell in inference.cells)
    body = [
        _cells_row([cell for cell in inference.cells if (cell.metric, cell.scenario) == row], names) for row in rows
    ]
    return element("table", element("thead", top), element("tbody", *body), class_="values printed stacked")


def ratios_table(inference: InferenceDocument) -> Markup:
    """Return a row a printed ratio of two contenders; nothing where there are none."""
    if not inference.ratios:
        return Markup()
    return table(RATIO_HEAD, [_ratio_row(entry) for entry in inference.ratios], class_="ratios stacked")


def misfits_table(inference: InferenceDocument) -> Markup:
    """Return by which factor our medians typically miss the printed numbers, by kind, for each setting."""
    head = [
        "Setting",
        *[f"{kind}, {part}" for kind in inference.misfit_kinds for part in ("search", "held out")],
        "Inside",
    ]
    rows = []
    for name, entry in inference.misfits:
        factors = [_factor(part[kind]) for kind in inference.misfit_kinds for part in (entry.search, entry.held_out)]
        rows.append([name, *factors, f"{entry.inside} of {len(inference.cells)}"])
    return table(head, rows, class_="misfits stacked")


def _looks(inference: InferenceDocument) -> dict[str, Look]:
    return dict(zip(inference.contenders, looks([(name, "") for name in inference.contenders]), strict=True))


def _factor(misfit: float) -> str:
    return f"× {significant(exp(misfit), 3)}"


def _unknown(entry: UnknownRow) -> list[Markup | str]:
    shown = StripScale(entry.low, entry.high, entry.scale == "log")
    ends = [significant(entry.low, 3), entry.scale, significant(entry.high, 3)]
    drawn = ranged(shown, entry.near, entry.resampled, entry.default, entry.inferred)
    scale = element("span", *[element("span", text) for text in ends], class_="ends")
    near, resampled = (" to ".join(significant(end, 3) for end in pair) for pair in (entry.near, entry.resampled))
    notes = [element("small", f"fits about as well: {near}"), element("small", f"one draw leaves: {resampled} (68 %)")]
    if entry.at_end:
        notes.append(element("small", "reaches an end of the range"))
    name = element(
        "span", entry.name, element("details", element("summary", "sets"), *_addresses(entry), class_="plain")
    )
    verdict = element("span", VERDICTS.get(entry.verdict, entry.verdict), class_="verdict")
    return [
        name,
        marked_up(MISSING if entry.unit == "1" else entry.unit),
        significant(entry.default, 3),
        element("strong", significant(entry.inferred, 3), class_="number"),
        element("span", drawn, scale),
        element("span", verdict, *notes),
    ]


def _addresses(entry: UnknownRow) -> list[Markup]:
    return [element("small", element("code", address)) for address in entry.addresses]


def _cells_row(cells: list[CellRow], names: list[str]) -> Markup:
    by_contender = {cell.contender: _cell(cell) for cell in cells}
    unit = join((" [", marked_up(cells[0].unit), "]")) if cells[0].unit else Markup()
    head = element(
        "th", element("code", cells[0].metric), unit, element("small", f"scenario {cells[0].scenario}"), scope="row"
    )
    shown = [(name, by_contender.get(name, Markup(MISSING))) for name in names]
    return element("tr", head, *[element("td", element("div", cell), data_label=name) for name, cell in shown])


def _cell(cell: CellRow) -> Markup:
    median, ends = estimate(*cell.ours.central.parts)
    before, before_ends = estimate(*cell.default.central.parts)
    where = f"{BY[cell.by]}, percentile {percentile_text(cell.ours.percentile)}"
    nearest = (
        element("small", f"nearest median of all settings {significant(cell.nearest, 3)}")
        if cell.by == "nowhere"
        else ""
    )
    return element(
        "span",
        element("span", "printed ", element("strong", significant(cell.published, 6)), class_="number"),
        element("span", f"ours {median} {ends}", class_="number ours"),
        element("small", where, class_=CLASSES[cell.by]),
        nearest,
        element("small", f"before {before} {before_ends}"),
    )


def _ratio_row(entry: RatioRow) -> list[Markup | str]:
    median, ends = estimate(*entry.ours.central.parts)
    verdict = element(
        "span",
        f"{BY[entry.by]}, percentile {percentile_text(entry.ours.percentile)}",
        class_=f"verdict {CLASSES[entry.by]}",
    )
    nearest = element("small", f"nearest median {significant(entry.nearest, 3)}") if entry.by == "nowhere" else ""
    about = element("small", f"{entry.second} to {entry.first}, scenario {entry.scenario}")
    return [
        join((element("code", entry.metric), about)),
        significant(entry.published, 4),
        element("span", median, " ", element("small", ends, class_="interval")),
        element("span", verdict, nearest),
    ]
