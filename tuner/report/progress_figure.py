"""The progress of a search for a paper: hypervolume, and share of feasible candidates, by generation."""

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from tuner.documents.results import Results
from tuner.report.figure_style import COLOURS, grid


def progress_figure(results: Results) -> Figure:
    """Return a figure with both, side by side."""
    history = results.history
    figure, (left, right) = grid(2, 2, 2.2)
    left.plot(history.generation, history.hypervolume, "-o", markersize=3, color=COLOURS["tuned"])
    left.set(xlabel="generation", ylabel="hypervolume [share of box]")
    right.plot(history.generation, 100.0 * history.feasible_share, "-s", markersize=3, color=COLOURS["front"])
    right.set(xlabel="generation", ylabel="feasible candidates [%]", ylim=(-4.0, 104.0))
    for ax in (left, right):
        ax.xaxis.set_major_locator(MaxNLocator(nbins=6, integer=True))
    return figure
