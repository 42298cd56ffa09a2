"""Disk margins: the largest disk of factors, gain and phase at once, that the loop bears.

    F = (1 + (1 - sigma)/2 d) / (1 - (1 + sigma)/2 d),   |d| < alpha,   alpha = 1 / max |S + (sigma - 1)/2|

sigma = 0 treats rise and fall of the gain alike, 1 gives alpha = 1/Ms, -1 gives 1/Mt. P. Seiler, A. Packard, P. Gahinet, "An
introduction to disk margins", IEEE Control Systems Magazine 40(5), 2020, pp. 78-95.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class DiskRange(NamedTuple):
    """Real gain factors and phases [rad] that a disk holds.

    Factors go from `low` to `high`, phases up to `phase` either way.
    """

    low: Array
    high: Array
    phase: Array


def center(sigma: float) -> float:
    """Return the center c of a disk margin.

    It is the point such that alpha = 1/max |T + c|, with T = S - 1.
    """
    return 0.5 * (1.0 + sigma)


def disk_range(alpha: ArrayLike, sigma: float = 0.0) -> DiskRange:
    """Guarantee of a disk margin; the range of gains is open above where the disk holds the point at infinity."""
    a = np.asarray(alpha, dtype=float)
    below, above = a * (1.0 - sigma), a * (1.0 + sigma)
    low = (2.0 - below) / (2.0 + above)
    high = np.where(above < 2.0, (2.0 + below) / np.where(above < 2.0, 2.0 - above, 1.0), np.inf)
    # cos = (1 + low high)/(low + high), written so that an infinite `high` needs no case.
    cosine = (1.0 / high + low) / (low / high + 1.0)
    return DiskRange(low, high, np.arccos(np.clip(cosine, -1.0, 1.0)))
