"""Values with their 95 % intervals for a paper: a panel for each quantity, a row for each contender."""

from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tuner.documents.contest import Contest, Quantity
from tuner.documents.contest_loading import load_contest
from tuner.report.figure_style import COLOURS, grid, save, style
from tuner.text.units import bracketed

COLUMNS, MOST_PANELS = 3, 15


def write_values_figure(folder: Path) -> list[Path]:
    """Write figures/values.png and .pdf into the folder of a comparison and return them."""
    contest = load_contest(folder)
    # Names are text, even those with dollar signs.
    with style(), rc_context({"text.parse_math": False}):
        return save(values_figure(contest), folder, "figures/values")


def values_figure(contest: Contest) -> Figure:
    """Return the figure, of the first quantities where there are more than fit on a page."""
    shown = contest.quantities[:MOST_PANELS]
    figure, axes = grid(len(shown), min(COLUMNS, len(shown)), 0.75 + 0.2 * len(contest.contenders))
    for number, (ax, quantity) in enumerate(zip(axes, shown, strict=True)):
        _panel(contest, ax, quantity, named=number % COLUMNS == 0)
    figure.supxlabel("bars: 95 % intervals over flights; dashed: limit; further left is better", fontsize=6.5)
    return figure


def _panel(contest: Contest, ax: Axes, quantity: Quantity, named: bool) -> None:
    for row, entry in enumerate(contest.contenders):
        value, low, high = contest.estimates[entry.name, quantity.label]
        if value is None or low is None or high is None:
            continue
        ax.plot([low, high], [-row, -row], color=entry.look.ink, linewidth=1.2, solid_capstyle="butt")
        face = "white" if entry.look.hollow else entry.look.ink
        ax.plot([value], [-row], entry.look.marker, color=entry.look.ink, markersize=4, markerfacecolor=face)
    if quantity.limit is not None:
        ax.axvline(quantity.limit, color=COLOURS["ink"], linewidth=0.8, linestyle="--", zorder=1)
    count = len(contest.contenders)
    names = [entry.name for entry in contest.contenders] if named else [""] * count
    ax.set_yticks([-row for row in range(count)], names, fontsize=6.5)
    ax.set_ylim(0.6 - count, 0.6)
    where = "" if quantity.scenario is None else f"\nscenario {quantity.scenario}"
    ax.set_xlabel(bracketed(quantity.label.removesuffix(f"@{quantity.scenario}"), quantity.unit) + where, fontsize=6.5)
    ax.tick_params(axis="x", labelsize=6.5)
    ax.locator_params(axis="x", nbins=4)
    ax.grid(visible=False, axis="y")
