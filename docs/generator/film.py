"""Draw a search as a film: python docs/generator/film.py results/quickstart docs/images/film.gif

A picture for each generation: candidates and the front so far, and responses in turbulence of the best balanced candidate so far.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import tuner
from tuner.api.gains import gains_of
from tuner.experiments.compare.entrants import rows_of, study_of
from tuner.report.labels import named
from tuner.search.front import non_dominated
from tuner.text.units import bracketed

FLIGHTS, SIGNAL, SECONDS_PER_PICTURE, LAST_PICTURES = 64, "x", 0.6, 4
GRAY, BLUE, ORANGE = "#b0b4ba", "#1f5fa8", "#d9822b"


def main(folder: str, picture: str) -> None:
    """Draw the film of a results folder of a quadrotor with two objectives."""
    results: Any = tuner.open_results(folder)
    every = results.candidates
    losses = every.filter(like="objective:").to_numpy()
    feasible = every["feasible"].to_numpy()
    generations = np.repeat(np.arange(len(results.history)), len(every) // len(results.history))
    last = int(generations[-1])
    shown = [best(losses, feasible & (generations <= generation)) for generation in range(last + 1)]
    bands = {place: band(results, place) for place in set(shown)}
    figure = Figure(figsize=(9.6, 3.6), dpi=100, layout="constrained")
    left, right = figure.subplots(1, 2)
    (first, second) = results.objectives
    labels = [bracketed(named(results, entry, short=True), entry.unit) for entry in (first, second)]

    def draw(frame: int) -> None:
        generation = min(frame, last)
        left.clear()
        right.clear()
        draw_front(left, losses, feasible, generations <= generation, shown[generation])
        left.set(xlabel=labels[0], ylabel=labels[1], title=f"generation {generation + 1} of {last + 1}")
        draw_responses(right, bands[0], bands[shown[generation]])

    film = FuncAnimation(figure, draw, frames=last + 1 + LAST_PICTURES)
    film.save(picture, writer=PillowWriter(fps=1 / SECONDS_PER_PICTURE))
    print(f"{picture}: {Path(picture).stat().st_size / 1e6:.2f} MB")


def best(losses: np.ndarray, among: np.ndarray) -> int:
    """Return the feasible candidate with the least sum of objectives relative to the default."""
    places = np.flatnonzero(among)
    return int(places[np.argmin((losses[places] / losses[0]).sum(axis=1))]) if places.size else 0


def band(results: Any, place: int) -> Any:
    """Return times with 5 %, 50 % and 95 % of the responses of a candidate in turbulence."""
    study = study_of(results.home)
    searched = results.candidates.filter(like="gain:").to_numpy()[[place]]
    (row,) = rows_of(study, searched)
    gains = gains_of(study.controller(row), {})
    responses = tuner.fly(gains, study=study, flights=FLIGHTS).responses
    return responses[responses["signal"] == SIGNAL]


def draw_front(axes: Axes, losses: np.ndarray, feasible: np.ndarray, seen: np.ndarray, chosen: int) -> None:
    """Draw candidates, the front and the default, within twice the default."""
    good = seen & feasible
    axes.plot(*losses[seen & ~feasible].T, "x", color=GRAY, ms=4, label="violates a limit")
    axes.plot(*losses[good].T, "o", color=BLUE, ms=3, alpha=0.5, label="feasible")
    if good.any():
        front = losses[good][non_dominated(losses[good])]
        front = front[np.argsort(front[:, 0])]
        axes.step(front[:, 0], front[:, 1], where="post", color=BLUE, lw=1.5, label="front")
    axes.plot(*losses[0], "s", color=ORANGE, ms=8, label="default")
    if chosen:
        axes.plot(*losses[chosen], "*", color=BLUE, ms=14)
    axes.set(xlim=(0, 2 * losses[0, 0]), ylim=(0, 2 * losses[0, 1]))
    axes.legend(loc="upper right", fontsize=8)


def draw_responses(axes: Axes, default: Any, tuned: Any) -> None:
    """Draw bands that hold 90 % of the flights of the default and of a candidate."""
    for rows, color, name in ((default, ORANGE, "default"), (tuned, BLUE, "tuned")):
        axes.fill_between(rows["time"], rows["low"], rows["high"], color=color, alpha=0.3, lw=0)
        axes.plot(rows["time"], rows["median"], color=color, lw=1.2, label=name)
    axes.plot(default["time"], default["reference"], "k--", lw=0.8)
    axes.set(xlabel="time [s]", ylabel="position [m]", ylim=(-1, 2), title=f"90 % of {FLIGHTS} flights in turbulence")
    axes.legend(loc="lower right", fontsize=8)


if __name__ == "__main__":
    main(*sys.argv[1:])
