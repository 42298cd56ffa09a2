"""The front of two objectives as lines of characters: what the search tried, the held-out front, default and recommended."""

import numpy as np

from tuner.documents.tuning import TuningFolder
from tuner.report.charts.front import front_panels
from tuner.report.charts.text import to_text


def lost_words(lost: np.ndarray) -> str:
    """Return the legend of points that lost flights; lost (points,): how many each lost."""
    return f"lost flights when held out ({int((lost > 0).sum())} points, {int(lost.sum())} flights; at the edge if beyond it)"


def front_lines(results: TuningFolder, width: int, height: int) -> list[str]:
    """Return the lines; values are in the units that reports show, angles in degrees."""
    names = {".": "tried, as the search saw it", "o": "front", "x": lost_words(results.front.lost), "@": results.called}
    return to_text(front_panels(results)[0], names, width, height)
