"""Axes of figures for a paper that cover decades: round numbers in full, not powers of ten."""

from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from tuner.report.contest.spans import Span
from tuner.text.numbers import significant


def show_span(ax: Axes, name: str, span: Span) -> None:
    """Give an axis, "x" or "y", the ends of a span and, where it is logarithmic, its round numbers."""
    ax.set(**{f"{name}scale": "log" if span.log else "linear", f"{name}lim": (span.low, span.high)})
    if span.log:
        shown = ax.xaxis if name == "x" else ax.yaxis
        shown.set_ticks(span.ticks(), [significant(value) for value in span.ticks()])
        # Minor ticks would be labelled where there are few others.
        shown.set_minor_formatter(NullFormatter())
