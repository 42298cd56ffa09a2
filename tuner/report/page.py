"""report.html: one offline page that says what was asked, what was found, what it costs and what to fly."""

import json
from itertools import combinations
from math import log
from pathlib import Path

from plotly.offline import get_plotlyjs

from tuner.report.charts import chart_data, role_title
from tuner.report.loading import load
from tuner.report.markup import Markup, described, element, join, table
from tuner.report.numbers import count, duration, estimate, significant
from tuner.report.results import Quantity, Results, Variable
from tuner.report.units import marked_up

ASSETS = Path(__file__).parent
GOOD, BAD = ("better", "kept"), ("worse", "broken")
# With more objectives than this, single pairs say little and parallel coordinates take over.
MOST_PAIRED = 3


def write_page(folder: Path) -> Path:
    """Write report.html of a results folder and return its path."""
    results = load(folder)
    file = folder / "report.html"
    aside = file.with_suffix(".part")
    aside.write_text(page(results), encoding="utf-8")
    aside.replace(file)
    return file


def page(results: Results) -> str:
    """Return the whole page."""
    body = element(
        "main", heading(results), comparison(results), gains(results), front(results), responses(results),
        progress(results), provenance(results),
    )  # fmt: skip
    head = join(
        [
            element("meta", charset="utf-8"),
            element("meta", name="viewport", content="width=device-width, initial-scale=1"),
            element("title", f"{results.summary['title']} - holdfast report"),
            element("style", Markup((ASSETS / "page.css").read_text(encoding="utf-8"))),
        ]
    )
    # "</" would end the script element; "<\\/" is the same text to a JSON parser.
    data = Markup(json.dumps(chart_data(results), allow_nan=False, separators=(",", ":")).replace("</", "<\\/"))
    scripts = join(
        [
            element("script", data, type="application/json", id="chart-data"),
            element("script", Markup(get_plotlyjs())),
            element("script", Markup((ASSETS / "page.js").read_text(encoding="utf-8"))),
        ]
    )
    return f"<!doctype html>\n{element('html', element('head', head), element('body', body, scripts), lang='en')}\n"


def heading(results: Results) -> Markup:
    """Say in plain words what was done and what is recommended."""
    summary, resolved = results.summary, results.resolved
    laws = resolved["controller"]
    said = (
        f"{count(summary['flights'])} flights of the {resolved['airframe']['name']} in turbulence, with the "
        f"{laws['attitude']} law on attitude and the {laws['position']} law on position, in "
        f"{duration(summary['wall_seconds'])}. {summary['front_size']} points stayed on the front when they were flown again on "
        f"{summary['held_out']} scenarios that the search never saw. Fly {results.tuned}: {summary['pick']['why']}."
    )
    warnings = [element("p", f"Warning: {text}", class_="warning") for text in summary["warnings"]]
    return join([element("h1", summary["title"]), element("p", said), *warnings])


def comparison(results: Results) -> Markup:
    """Show every objective and constraint, default against tuned."""
    head = ("what is judged", "unit", "default", "tuned", "tuned − default", "verdict")
    rows = [comparison_row(entry) for entry in results.quantities]
    return element(
        "section",
        element("h2", "Default against tuned"),
        aid(
            "Smaller is better everywhere. Brackets are 95 % intervals over held-out scenarios; differences are flight by flight."
        ),
        table(head, rows, class_="stack"),
    )


def comparison_row(entry: Quantity) -> list[Markup]:
    """Return one line of the comparison."""
    limit = f" ≤ {significant(None if entry.limit is None else entry.limit)}" if entry.constrained else ""
    kind = "good" if entry.verdict in GOOD else "bad" if entry.verdict in BAD else ""
    mark = {"good": "✓ ", "bad": "✗ "}.get(kind, "= ")
    cells = [
        number_cell(*estimate(*part, signed=signed))
        for part, signed in ((entry.default, False), (entry.tuned, False), (entry.difference, True))
    ]
    name = element("span", entry.label + limit, title=f"{entry.definition}; {entry.risk}")
    return [name, unit_cell(entry.unit), *cells, element("span", mark + entry.verdict, class_=f"verdict {kind}")]


def number_cell(value: str, interval: str) -> Markup:
    """Return a number over its interval."""
    return join([value, element("span", interval, class_="interval")])


def unit_cell(unit: str) -> Markup:
    """Return a unit in one piece."""
    return element("span", Markup(marked_up(unit)))


def gains(results: Results) -> Markup:
    """Show the searched gains and the gains file."""
    head = ("gain", "unit", "default", "tuned", "range", "where in the range")
    rows = [gain_row(entry) for entry in results.variables]
    document = json.dumps(results.gains, indent=2, ensure_ascii=False)
    return element(
        "section",
        element("h2", "The gains"),
        aid("The wide mark is the tuned value, the short one the default. A mark at an end asks for a wider range."),
        table(head, rows, class_="stack"),
        element(
            "details",
            element("summary", "gains.json, ready to copy"),
            element("button", "Copy", id="copy", type="button"),
            element("pre", document, id="gains-json", tabindex="0"),
        ),
    )


def gain_row(entry: Variable) -> list[Markup]:
    """Return one line of the gains."""
    name = element("span", entry.name, title=f"{entry.symbol}: {entry.meaning}")
    marks = [
        element("i", class_=kind, style=f"left:calc({100 * place(entry, value):.1f}% - 1px)")
        for kind, value in (("default", entry.default), ("tuned", entry.tuned))
    ]
    inside = f"tuned at {100 * place(entry, entry.tuned):.0f} % of the range"
    return [
        name, unit_cell("" if entry.unit == "1" else entry.unit), Markup(significant(entry.default)),
        Markup(significant(entry.tuned)), Markup(f"{significant(entry.low)} to {significant(entry.high)}"),
        element("span", *marks, class_="bar", role="img", aria_label=inside, title=inside),
    ]  # fmt: skip


def place(entry: Variable, value: float) -> float:
    """Return where in its range a gain stands, 0 to 1, on the scale that the search walked."""
    inside = min(max(value, entry.low), entry.high)
    if entry.scale == "log":
        return log(inside / entry.low) / log(entry.high / entry.low)
    return (inside - entry.low) / (entry.high - entry.low)


def front(results: Results) -> Markup:
    """Show the front."""
    count_of = len(results.objectives)
    charts: list[Markup] = []
    if count_of == 1:
        charts.append(element("div", id="front-one", class_="chart"))
    if count_of == MOST_PAIRED:
        charts.append(element("div", id="front-space", class_="chart"))
    if count_of > MOST_PAIRED:
        charts.append(element("div", id="front-parallel", class_="chart"))
    pairs = list(combinations(range(count_of), 2))
    charts += [element("div", data_pair=f"{i},{j}", class_="chart") for i, j in pairs]
    return element(
        "section",
        element("h2", "The trade-off"),
        aid(
            "Down and left is better. Hover over a point for its gains; click an entry of the legend to hide or show it."
        ),
        *charts,
    )


def responses(results: Results) -> Markup:
    """Show the Monte Carlo fans."""
    if not results.fans:
        return element("section", element("h2", "Responses"), element("p", "This folder holds no recorded responses."))
    points = [
        element(
            "option", f"{name} ({role_title(results.front.role(name))})", value=name, selected=name == results.tuned
        )
        for name in results.flown_points
    ]
    scenarios = [element("option", name, value=name) for name in results.scenarios]
    signals = list(dict.fromkeys(fan.signal for fan in results.fans))
    return element(
        "section",
        element("h2", "Responses"),
        aid(
            "Bands hold 90 % of the flights, lines are medians: solid for the chosen point, dashed for the default, dotted for "
            "the reference. Rotor commands are in hover thrusts."
        ),
        element(
            "div",
            element("label", "Point ", element("select", *points, id="point")),
            element("label", "Scenario ", element("select", *scenarios, id="scenario")),
            class_="controls",
        ),
        element("div", *[element("div", class_="chart", data_signal=name) for name in signals], class_="grid"),
    )


def progress(results: Results) -> Markup:
    """Show how the search went."""
    return element(
        "section",
        element("h2", "The search"),
        aid(
            "Hypervolume: share of the box between zero and 1.1 times the default's values that the feasible front dominates. "
            "Flat at the end: more generations would find little."
        ),
        element("div", id="history", class_="chart"),
    )


def provenance(results: Results) -> Markup:
    """Tell where the numbers come from."""
    resolved, environment = results.resolved, results.environment
    pairs = [
        ("study", str(results.summary["study"])),
        ("seed", str(resolved["seed"])),
        ("digest", str(resolved.get("digest", "–"))),
        ("search", f"{resolved['search']['algorithm']}, {resolved['search'].get('generations', '–')} generations"),
        *[(key, str(value)) for key, value in environment.items() if value is not None],
    ]
    air = [element("h3", f"Air: {row['scenario']}") + described(air_pairs(row)) for row in results.summary["air"]]
    metrics = {entry.metric: entry for entry in results.quantities}
    meanings = [(name, f"{entry.definition}; {entry.risk}") for name, entry in metrics.items()]
    return element(
        "section",
        element("h2", "Where this comes from"),
        described(pairs),
        *[Markup(part) for part in air],
        element("h3", "Definitions"),
        described(meanings),
        element("details", element("summary", "The study file"), element("pre", results.study, tabindex="0")),
    )


AIR_UNITS = {"altitude": "m", "mean_wind": "m/s", "airspeed": "m/s", "length": "m", "sigma": "m/s", "tau": "s"}


def air_pairs(row: dict[str, object]) -> list[tuple[str, str]]:
    """Return what the report states of a scenario's turbulence."""
    pairs = []
    for key, value in row.items():
        if key == "scenario":
            continue
        unit = AIR_UNITS.get(key.split("_")[0] if key not in AIR_UNITS else key, "")
        shown = f"{significant(value)} {unit}".strip() if isinstance(value, int | float) else str(value)
        pairs.append((key.replace("_", " "), shown))
    return pairs


def aid(text: str) -> Markup:
    """Return a one-line reading aid."""
    return element("p", text, class_="aid")
