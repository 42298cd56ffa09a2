"""Forest plots for a paper: paired differences with 95 % intervals, a panel for each quantity, a row for each pair."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tuner.documents.contest import Contest, Difference
from tuner.report.contest.differences_section import related
from tuner.report.figure_style import COLOURS, grid
from tuner.text.units import bracketed

# Panels drawn at most, objectives first; pairs as they come.
MOST_PANELS, COLUMNS = 15, 3


def differences_figure(contest: Contest) -> Figure | None:
    """Return the figure; quantities in which no two contenders differ at all are left out, None where nothing is left."""
    shown = [(quantity, _pairs(contest, quantity.label)) for quantity in contest.quantities]
    shown = [
        (quantity, pairs) for quantity, pairs in shown if any(number for entry in pairs for number in entry.difference)
    ]
    if not shown:
        return None
    shown = shown[:MOST_PANELS]
    rows = max(len(pairs) for _, pairs in shown)
    figure, axes = grid(len(shown), min(COLUMNS, len(shown)), 0.7 + 0.15 * rows)
    for number, (ax, (quantity, pairs)) in enumerate(zip(axes, shown, strict=True)):
        _forest(ax, pairs, named=number % COLUMNS == 0)
        name = bracketed(quantity.label.removesuffix(f"@{quantity.scenario}"), quantity.unit)
        ax.set_xlabel(f"{name}\n{'' if quantity.scenario is None else f'scenario {quantity.scenario}'}", fontsize=6.5)
    figure.supxlabel("left of zero the one named first is lower; hollow: no clear difference", fontsize=6.5)
    return figure


def _pairs(contest: Contest, label: str) -> list[Difference]:
    return [entry for entry in contest.differences if entry.quantity == label and related(contest, entry)]


def _forest(ax: Axes, pairs: list[Difference], named: bool) -> None:
    ax.axvline(0.0, color=COLOURS["ink"], linewidth=0.8, zorder=1)
    for row, entry in enumerate(pairs):
        value, low, high = entry.difference
        if value is None or low is None or high is None:
            continue
        ax.plot([low, high], [-row, -row], color=COLOURS["ink"], linewidth=1.1, solid_capstyle="butt")
        face = COLOURS["ink"] if entry.lower is not None else "white"
        ax.plot([value], [-row], "D", markersize=4, markerfacecolor=face, markeredgecolor=COLOURS["ink"])
    names = [f"{entry.second} − {entry.first}" for entry in pairs] if named else []
    ax.set_yticks([-row for row in range(len(pairs))], names or [""] * len(pairs), fontsize=6.5)
    ax.set_ylim(0.6 - len(pairs), 0.6)
    ax.tick_params(axis="x", labelsize=6.5)
    ax.locator_params(axis="x", nbins=3)
    ax.grid(visible=False, axis="y")
