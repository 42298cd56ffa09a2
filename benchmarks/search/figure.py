"""The race as a figure: share of the best known over flights and over processor time, a column a problem."""

from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.search.contestants import AUTO, CONTESTANTS
from benchmarks.search.problems import RACED
from benchmarks.search.table import ENOUGH, Curve, curves

Runs = list[dict[str, Any]]
# Colours of lines that stay apart for colour-blind eyes too, after M. Okabe and K. Ito, 2008; families differ by dashes.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000")
DASHES = {"tool": "-", "peer": "--", "baseline": ":"}


def draw_figure(runs: Runs, file: Path) -> None:
    """Draw medians over seeds; of the default the range too."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    problems = [problem for problem in RACED if curves(runs, problem)]
    if not problems:
        return
    figure, axes = pyplot.subplots(
        2, len(problems), figsize=(4.0 * len(problems), 7.5), layout="constrained", sharey=True, squeeze=False
    )
    styles = _styles()
    for column, problem in enumerate(problems):
        for name, own in curves(runs, problem).items():
            if name in styles:
                _draw(axes[0, column], name, own, [curve.flights for curve in own], styles[name])
                _draw(axes[1, column], name, own, [curve.seconds for curve in own], styles[name])
        axes[0, column].set_title(f"{problem}\n{RACED[problem].about}", fontsize=9)
        axes[0, column].set_xlabel("flights")
        axes[1, column].set_xlabel("processor time [s]")
    for axis in axes.flat:
        axis.set_xscale("log")
        axis.tick_params(axis="x", which="minor", labelbottom=False)
        axis.set_ylim(0.0, 1.02)
        axis.axhline(ENOUGH, color="#888888", linewidth=0.8)
        axis.grid(True, which="major", color="#dddddd")
    for axis in axes[:, 0]:
        axis.set_ylabel("share of the best known, held out")
    known = {label: line for axis in axes.flat for line, label in zip(*axis.get_legend_handles_labels(), strict=True)}
    figure.legend(
        known.values(), known.keys(), loc="outside lower center", ncols=1 + len(problems), frameon=False, fontsize=9
    )
    figure.savefig(file, dpi=110)
    pyplot.close(figure)


def _styles() -> dict[str, dict[str, Any]]:
    """Return how each contestant is drawn: colours in turn within a family, the default thick."""
    styles: dict[str, dict[str, Any]] = {}
    counts = dict.fromkeys(DASHES, 0)
    for name, entry in CONTESTANTS.items():
        if entry.family in DASHES:
            colour = COLOURS[counts[entry.family] % len(COLOURS)]
            counts[entry.family] += 1
            width = 2.8 if name == AUTO else 1.3
            styles[name] = {"color": colour, "linestyle": DASHES[entry.family], "linewidth": width}
    return styles


def _draw(axis: Any, name: str, own: list[Curve], along: list[list[Any]], style: dict[str, Any]) -> None:
    """Draw the median of the curves at the entries that all have."""
    count = min(len(curve.shares) for curve in own)
    x = [median(values[i] for values in along) for i in range(count)]
    shares = [[curve.shares[i] for curve in own] for i in range(count)]
    axis.plot(x, [median(entry) for entry in shares], label=name, **style)
    if name == AUTO:
        axis.fill_between(x, [min(e) for e in shares], [max(e) for e in shares], color=style["color"], alpha=0.15)
