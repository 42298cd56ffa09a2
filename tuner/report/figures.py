"""Figures for a paper: front, responses and progress of a results folder, as PNG (200 dpi) and PDF."""

from itertools import combinations
from math import ceil
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tuner.report.loading import load
from tuner.report.results import DEFAULT, TUNED, Fan, Front, Results
from tuner.report.units import bracketed

# Colours that stay apart in grey and for colour-blind eyes (Okabe, Ito 2008); shapes and dashes say the same.
GREY, ORANGE, BLUE, GREEN = "0.75", "#d55e00", "#0072b2", "#009e73"
INCH = 3.4
MOST_PAIRS = 6
SPAN = 20.0


def write_all(folder: Path) -> list[Path]:
    """Write every figure that the folder has data for and return the files."""
    results = load(folder)
    target = folder / "figures"
    target.mkdir(exist_ok=True)
    drawn = {"front": front_figure(results), "progress": progress_figure(results)}
    for i, scenario in enumerate(results.scenarios):
        drawn["responses" if i == 0 else f"responses-{i}"] = response_figure(results, scenario)
    return [path for name, figure in drawn.items() for path in save(figure, target / name)]


def save(figure: Figure, stem: Path) -> list[Path]:
    """Write a figure as STEM.png and STEM.pdf."""
    files = [stem.with_name(f"{stem.name}{ending}") for ending in (".png", ".pdf")]
    for file in files:
        figure.savefig(file, dpi=200)
    return files


def blank(columns: int, rows: int, height: float = 2.6) -> tuple[Figure, list[Axes]]:
    """Return a figure with a grid of axes, in reading order."""
    figure = Figure(figsize=(INCH * columns, height * rows), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, squeeze=False)
    for ax in axes.flat:
        ax.grid(visible=True, color="0.9", linewidth=0.6)
        ax.spines[["top", "right"]].set_visible(False)
        ax.tick_params(labelsize=8)
    return figure, list(axes.flat)


def front_figure(results: Results) -> Figure:
    """Draw the held-out front with 95 % intervals over all candidates, one panel for each pair of objectives."""
    count = len(results.objectives)
    pairs = list(combinations(range(count), 2))[:MOST_PAIRS] or [(0, 0)]
    columns = min(len(pairs), 3)
    figure, axes = blank(columns, ceil(len(pairs) / columns), 3.0)
    for ax, (i, j) in zip(axes, pairs, strict=False):
        draw_front(ax, results, i, j)
    for ax in axes[len(pairs) :]:
        ax.set_visible(False)
    axes[0].legend(fontsize=7, frameon=False)
    return figure


def draw_front(ax: Axes, results: Results, i: int, j: int) -> None:
    """Draw one pair of objectives."""
    front, tried = results.front, results.candidates
    ax.plot(
        tried.values[:, i], tried.values[:, j], ".", color=GREY, markersize=3, label="tried, search value", zorder=1
    )
    styles = {"": ("o", BLUE, "front, held-out"), DEFAULT: ("D", ORANGE, "default"), TUNED: ("*", GREEN, "tuned")}
    for role, (marker, colour, label) in styles.items():
        rows = [k for k in front.of(role) if role or front.non_dominated[k]]
        if not rows:
            continue
        value = front.held_out[rows]
        error = np.clip(np.stack([value - front.low[rows], front.high[rows] - value]), 0.0, None)
        size = 11 if role == TUNED else 4
        ax.errorbar(
            value[:, i], value[:, j], xerr=error[:, :, i], yerr=error[:, :, j], fmt=marker, color=colour, label=label,
            markersize=size, linewidth=0.8, zorder=3 if role else 2,
        )  # fmt: skip
    for axis, k in (("x", i), ("y", j)):
        low, high, scale = axis_range(front, k)
        getattr(ax, f"set_{axis}scale")(scale)
        getattr(ax, f"set_{axis}lim")(low, high)
    ax.set_xlabel(bracketed(results.objectives[i].label, results.objectives[i].unit), fontsize=8)
    ax.set_ylabel(bracketed(results.objectives[j].label, results.objectives[j].unit), fontsize=8)


def axis_range(front: Front, column: int) -> tuple[float, float, str]:
    """Return the ends and the scale of an axis: logarithmic where the front spans more than a factor of SPAN.

    It shows the default and what stays on the front; finalists that failed on held-out scenarios lie far outside.
    """
    shown = front.non_dominated | np.array([role == DEFAULT for role in front.roles])
    values = front.held_out[shown, column] if shown.any() else front.held_out[:, column]
    low, high = float(values.min(axis=0)), float(values.max(axis=0))
    if low > 0.0 and high > SPAN * low:
        return low / 1.4, high * 1.4, "log"
    return 0.0, 1.15 * high if high > 0.0 else 1.0, "linear"


def progress_figure(results: Results) -> Figure:
    """Draw hypervolume and feasible share over the flights of the search."""
    figure, (ax,) = blank(1, 1)
    history = results.history
    ax.plot(history.flights, history.hypervolume, "-o", color=BLUE, markersize=3, label="hypervolume")
    ax.plot(history.flights, history.feasible_share, "--s", color=ORANGE, markersize=3, label="feasible share")
    ax.set_xlabel("flights", fontsize=8)
    ax.set_ylabel("share [1]", fontsize=8)
    ax.set_ylim(0.0, 1.02)
    ax.legend(fontsize=7, frameon=False)
    return figure


def response_figure(results: Results, scenario: str) -> Figure:
    """Draw the 5-95 % fans and medians of default and tuned, one panel for each signal."""
    fans = [fan for fan in results.fans if fan.scenario == scenario]
    signals = list(
        dict.fromkeys(fan.signal for fan in fans if not fan.signal.startswith("rotor") or fan.signal == "rotor1")
    )
    figure, axes = blank(2, ceil(len(signals) / 2), 2.0)
    for ax, signal in zip(axes, signals, strict=False):
        chosen = [(fan, results.front.role(fan.point)) for fan in fans if fan.signal == signal]
        for fan, role in chosen:
            if role in (DEFAULT, TUNED):
                draw_fan(ax, fan, role)
        ax.set_ylabel(bracketed(signal, chosen[0][0].unit), fontsize=8)
    for ax in axes[len(signals) :]:
        ax.set_visible(False)
    for ax in axes[: len(signals)][-2:]:
        ax.set_xlabel("time [s]", fontsize=8)
    axes[0].legend(fontsize=7, frameon=False)
    return figure


def draw_fan(ax: Axes, fan: Fan, label: str) -> None:
    """Draw one fan: band, median, reference."""
    colour, dash = (ORANGE, "--") if label == DEFAULT else (BLUE, "-")
    ax.fill_between(fan.time, fan.low, fan.high, color=colour, alpha=0.2, linewidth=0)
    ax.plot(fan.time, fan.median, dash, color=colour, linewidth=1.2, label=f"{label}, median and 5-95 %")
    tracked = fan.signal in ("x", "y", "z", "yaw")
    if tracked and label == TUNED:
        ax.plot(fan.time, fan.reference, ":", color="0.3", linewidth=1.0, label="reference")
