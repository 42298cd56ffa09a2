"""The front of two objectives as lines of characters: what the search tried, the held-out front, default and recommended."""

import numpy as np

from tuner.report.results import DEFAULT, TUNED, Results
from tuner.report.units import bracketed
from tuner.show.scatter import Layer, scatter


def front_lines(results: Results, width: int, height: int) -> list[str]:
    """Return the lines; values are in the units that reports show, angles in degrees."""
    front, tried = results.front, results.candidates
    best = front.non_dominated & front.feasible & np.array([role == "" for role in front.roles])
    layers = [
        Layer(".", "tried, as the search saw it", tried.values[tried.feasible], cut=True),
        Layer("o", "front", front.held_out[best]),
        Layer("D", "default", front.held_out[front.of(DEFAULT)]),
        Layer("@", "recommended", front.held_out[front.of(TUNED)]),
    ]
    labels = [bracketed(entry.label, entry.unit) for entry in results.objectives]
    return scatter(layers, (labels[0], labels[1]), width, height)
