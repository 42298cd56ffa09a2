"""Whether a search can be trusted: how it went by generation, search against held-out values, and places on the front."""

import numpy as np

from tuner.documents.tuning import TuningFolder
from tuner.documents.tuning_tables import History
from tuner.report.charts.chart import Axis, Bars, Line, Mark, Panel, Points
from tuner.report.charts.front import LAYERS, layer_of, shown_range
from tuner.report.charts.look import DEFAULT, FRONT, RULE, TUNED, Look
from tuner.report.labels import definition_text, named, titles_of
from tuner.text.numbers import count, significant
from tuner.text.units import bracketed

# Ticks of an axis of generations at most.
MAX_TICKS = 6


def progress_panels(history: History) -> list[Panel]:
    """Return hypervolume and share of feasible candidates by generation, and the flights made and saved where known."""
    volume, share = history.hypervolume, 100.0 * history.feasible_share
    x = _generations(history)
    panels = [
        Panel(
            "progress-hypervolume",
            "Hypervolume [share of the box]",
            x,
            Axis(""),
            [_series(history, volume, TUNED._replace(symbol="circle"))],
            aid="Share of the box between zero and 1.1 times the default's values that the front dominates.",
        ),
        Panel(
            "progress-feasible",
            "Feasible candidates [%]",
            x,
            Axis("", -4.0, 104.0),
            [_series(history, share, FRONT._replace(symbol="square"))],
            aid="Share of a generation's candidates that violate no limit.",
        ),
    ]
    if history.flights_saved is not None or history.flights_raced is not None:
        panels.append(_flights(history))
    return panels


def gap_panels(results: TuningFolder) -> list[Panel]:
    """Return held-out over search values of every finalist, a panel an objective; on the dotted line they agree."""
    return [_gap(results, i) for i in range(len(results.objectives))]


def front_probability_panel(results: TuningFolder) -> Panel | None:
    """Return the finalists' probabilities to be on the front; None where the folder does not hold them."""
    front = results.held_out_front
    probability = front.columns.get("probability")
    if probability is None:
        return None
    finite = [row for row, role in enumerate(front.roles) if role != "default" and np.isfinite(probability[row])]
    rows = sorted(finite, key=lambda row: -probability[row])
    bars = Bars(
        look=FRONT._replace(symbol=""),
        x=np.arange(1.0, len(rows) + 1.0),
        y=100.0 * probability[rows],
        labels=[front.points[row] for row in rows],
    )
    aid = "Bootstrap probability that no other finalist dominates this point."
    return Panel(
        "probability",
        "Probability of being on the front",
        Axis("finalists, by probability"),
        Axis("probability [%]", 0.0, 104.0),
        [bars],
        aid=aid,
    )


def _generations(history: History) -> Axis:
    """Return the axis of generations, which are whole numbers."""
    last = int(history.generation[-1]) if len(history.generation) else 1
    step = next(step for power in range(9) for digit in (1, 2, 5) if (step := digit * 10**power) * MAX_TICKS >= last)
    return Axis("generation", ticks=tuple((float(tick), str(tick)) for tick in range(0, last + 1, step)))


def _series(history: History, values: np.ndarray, look: Look) -> Line:
    flights = history.flights
    return Line(
        look=look,
        x=history.generation,
        y=values,
        tips=(flights, flights),
        marked=slice(None),
        tip="%{y:.4~g} after %{customdata[0]:,.0f} simulations",
    )


def _flights(history: History) -> Panel:
    layers = (
        ("made", history.flights, TUNED._replace(symbol="")),
        ("skipped by racing", history.flights_raced, FRONT._replace(symbol="/")),
        ("skipped by pre-screening", history.flights_saved, DEFAULT._replace(symbol="x")),
    )
    bars = [
        Bars(name=name, look=look, x=history.generation, y=counts, stacked=True)
        for name, counts, look in layers
        if counts is not None
    ]
    aid = "Simulations made, and skipped by pre-screening and racing."
    return Panel(
        "progress-saved",
        "Simulations",
        _generations(history),
        Axis("simulations, cumulative"),
        bars,
        aid=aid,
        stacked=True,
        legend=True,
    )


def _gap(results: TuningFolder, i: int) -> Panel:
    front, entry = results.held_out_front, results.objectives[i]
    search, held_out, shown = front.search[:, i], front.held_out[:, i], shown_range(front, i)
    seen = search[np.isfinite(search) & (held_out >= shown.low) & (held_out <= shown.high)]
    ends = np.array([min([shown.low, *seen]), max([shown.high, *seen])])
    log = shown.log and bool(ends[0] > 0.0)
    marks: list[Mark] = [Line(look=RULE, x=ends, y=ends)]
    layers = [layer_of(front, row) for row in range(len(front.points))]
    for layer in ("finalist", "front", "default", "tuned"):
        rows = [k for k, name in enumerate(layers) if name == layer and np.isfinite([search[k], held_out[k]]).all()]
        if rows:
            hover, labels = [_gap_words(results, i, k) for k in rows], [front.points[k] for k in rows]
            look, held = LAYERS[layer][1], (front.low[rows, i], front.high[rows, i])
            marks.append(Points(look=look, x=search[rows], y=held_out[rows], y_ends=held, labels=labels, hover=hover))
    x, y = (Axis(bracketed(name, entry.unit), float(ends[0]), float(ends[1]), log) for name in ("search", "held-out"))
    aid = f"{count(len(front.points))} finalists; above the dotted line the search was optimistic."
    return Panel(f"gap-{i}", named(results, entry, short=True), x, y, marks, aid=aid, tip=definition_text(entry))


def _gap_words(results: TuningFolder, i: int, row: int) -> str:
    front, unit = results.held_out_front, results.objectives[i].unit
    search, held_out = significant(front.search[row, i]), significant(front.held_out[row, i])
    return f"{titles_of(results)[front.points[row]]}: search {search}, held-out {held_out} {unit}"
