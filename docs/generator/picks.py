"""Draw how a point of a front is picked: python docs/generator/picks.py docs/images/which_point.png

Each panel is a front that is made up, and the answer of the rule itself.
"""

import sys
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tuner.experiments.tuning.recommendation import Default, alternatives, choose_finalist
from tuner.search.front import non_dominated

GRAY, BLUE, ORANGE, BLACK = "#b0b4ba", "#1f5fa8", "#d9822b", "#222222"
LABELS = ("error", "travel")


class Panel(NamedTuple):
    """A default at (error, travel) beside a front from stiff to soft."""

    title: str
    default: tuple[float, float]
    keeps: bool
    worst: tuple[bool, bool] = (False, False)
    exponent: float = 1.0


PANELS = (
    Panel("1. Points are better in everything:\nthe knee of these", (1.6, 1.6), True),
    Panel("2. The default is on the front:\nit is kept, points are offered", (1.0, 1.0), True),
    Panel("3. The default breaks a limit, nothing\nis better in everything: small losses", (0.8, 1.1), False),
    Panel(
        "4. A default that hardly acts and breaks a limit:\nthe whole front",
        (4.1, 0.085),
        False,
        (True, False),
        exponent=2.0,
    ),
    Panel(
        "5. A default that shakes and breaks a limit:\nhalf of that for less error is enough",
        (1.2, 3.0),
        False,
        (False, True),
    ),
)


def study_of(labels: tuple[str, ...]) -> Any:
    """Return the parts of a study that the rule reads."""
    return SimpleNamespace(pick="knee", objectives=[SimpleNamespace(label=name) for name in labels])


def draw_panel(axes: Axes, panel: Panel) -> None:
    """Draw the front, the points that are eligible, the default and the recommended point."""
    error = np.geomspace(0.5, 4.0, 15)
    values = np.vstack([panel.default, np.stack([error, error**-panel.exponent], axis=1)])
    rows = 1 + np.flatnonzero(non_dominated(values[1:]))
    default, names = Default(panel.keeps, np.array(panel.worst)), [str(row) for row in range(len(values))]
    excess = np.zeros((len(values), 1))
    among, _ = alternatives(values, default, rows)
    chosen = choose_finalist(study_of(LABELS), values, default, rows, excess, names).row
    axes.scatter(*values[rows].T, s=26, color=GRAY, label="front")
    axes.scatter(*values[among].T, s=26, color=BLUE, label="may be picked")
    axes.scatter(*values[0], s=60, marker="x", color=BLACK, label="default")
    axes.scatter(*values[chosen], s=170, facecolors="none", edgecolors=ORANGE, linewidths=2.2, label="recommended")
    axes.axvline(panel.default[0], color=GRAY, linewidth=0.8, linestyle=":")
    axes.axhline(panel.default[1], color=GRAY, linewidth=0.8, linestyle=":")
    axes.set_title(panel.title, fontsize=9)
    axes.set(xlabel=LABELS[0], ylabel=LABELS[1], xlim=(0.0, 4.3), ylim=(0.0, 3.3))


def draw_limit(axes: Axes) -> None:
    """Draw one objective over a limited quantity with its intervals."""
    overshoot = np.linspace(6.0, 22.0, 9)
    error, limit, half = 2.2 - 0.35 * np.sqrt(overshoot - 5.0), 15.0, 0.7
    within = overshoot + half <= limit
    values, excess = np.array([[3.0], *error[:, None]]), np.maximum(np.array([20.0, *overshoot]) + half - limit, 0.0)
    rows = 1 + np.flatnonzero(within)
    best = rows[non_dominated(values[rows])]
    names = [str(row) for row in range(len(values))]
    default = Default(False, np.zeros(1, dtype=bool))
    chosen = choose_finalist(study_of(LABELS[:1]), values, default, best, excess[:, None], names).row - 1
    for mask, color, label in ((within, BLUE, "keeps the limit"), (~within, GRAY, "does not")):
        axes.errorbar(overshoot[mask], error[mask], xerr=half, fmt="o", markersize=4, color=color, label=label)
    axes.scatter(overshoot[chosen], error[chosen], s=170, facecolors="none", edgecolors=ORANGE, linewidths=2.2)
    axes.axvline(limit, color=BLACK, linewidth=0.8)
    axes.set_title("6. One objective under a limit: the smallest\nof those whose interval keeps it", fontsize=9)
    axes.set(xlabel="overshoot, limit 15 %", ylabel=LABELS[0])
    axes.legend(fontsize=7, loc="upper right")


def main(picture: str) -> None:
    """Draw all panels into a picture."""
    figure = Figure(figsize=(11.0, 6.6), layout="constrained")
    grid = figure.subplots(2, 3).ravel()
    for axes, panel in zip(grid, PANELS, strict=False):
        draw_panel(axes, panel)
    grid[0].legend(fontsize=7, loc="upper right")
    draw_limit(grid[-1])
    figure.savefig(picture, dpi=110)


if __name__ == "__main__":
    main(sys.argv[1])
