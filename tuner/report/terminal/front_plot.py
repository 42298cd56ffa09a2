"""The front of two objectives as lines of characters: what the search tried, the held-out front, default and recommended."""

import numpy as np

from tuner.documents.results import DEFAULT, TUNED, Results
from tuner.report.terminal.scatter import Layer, scatter
from tuner.text.units import bracketed


def lost_words(lost: np.ndarray) -> str:
    """Return the legend of points that lost flights; lost (points,): how many each lost."""
    return f"lost flights when held out ({int((lost > 0).sum())} points, {int(lost.sum())} flights; at the edge if beyond it)"


def front_lines(results: Results, width: int, height: int) -> list[str]:
    """Return the lines; values are in the units that reports show, angles in degrees."""
    front, tried = results.front, results.candidates
    best = front.non_dominated & front.feasible & np.array([role == "" for role in front.roles])
    layers = [
        Layer(".", "tried, as the search saw it", tried.values[tried.feasible], cut=True),
        Layer("o", "front", front.held_out[best]),
        Layer("x", lost_words(front.lost), front.held_out[front.lost > 0], cut=True, edge=True),
        Layer("D", "default", front.held_out[front.of(DEFAULT)]),
        Layer("@", results.called, front.held_out[front.of(TUNED)]),
    ]
    labels = [bracketed(entry.label, entry.unit) for entry in results.objectives]
    return scatter(layers, (labels[0], labels[1]), width, height)
