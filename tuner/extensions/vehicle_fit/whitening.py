"""Whitening of residuals by a long autoregression.

Without it, a fit in closed loop is biased and its intervals are too narrow (Ljung, System Identification, 2nd ed., section 13.4).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ORDERS = (2, 4, 8, 16, 32)
"""Orders that are tried; Akaike's criterion chooses."""
DECAY = 0.975
"""Share of a leaky sum that a step of 4 ms leaves. Differences of white noise have a zero at frequency 0, which no autoregression
inverts; their sum has none.
"""


def autoregression(series: Sequence[Array], weights: Sequence[Array]) -> tuple[Array, float]:
    """Fit an autoregression to segments (n,) of an output: x_t = sum a_i x_(t-i) + e_t.

    weights (n,): 1 where a sample counts, 0 elsewhere. Returns (a (order,), RMS of e).
    """
    # All orders are judged on the same samples.
    lagged = [_lags(x, ORDERS[-1]) for x in series]
    chosen = np.concatenate([w[ORDERS[-1] :] for w in weights]) > 0.0
    past, now = (
        np.concatenate([part[:, 1:] for part in lagged])[chosen],
        np.concatenate([part[:, 0] for part in lagged])[chosen],
    )
    gram, cross, power = past.T @ past, past.T @ now, now @ now
    best: tuple[float, Array, float] | None = None
    for order in ORDERS:
        ridge = 1e-9 * np.trace(gram[:order, :order]) / order
        a = np.linalg.solve(gram[:order, :order] + ridge * np.eye(order), cross[:order])
        mean = max(float(power - 2.0 * a @ cross[:order] + a @ gram[:order, :order] @ a) / len(now), 1e-300)
        score = len(now) * np.log(mean) + 2.0 * order
        if best is None or score < best[0]:
            best = (score, a, mean**0.5)
    assert best is not None
    return best[1], best[2]


def whitened(series: Array, a: Array) -> Array:
    """Return x_t - sum a_i x_(t-i) along the first axis; zeros for the first samples, which lack a past."""
    from scipy.signal import lfilter

    white = np.asarray(lfilter(np.concatenate([[1.0], -a]), [1.0], series, axis=0), np.float64)
    white[: ORDERS[-1]] = 0.0
    return white


def leaky_sum(series: Array) -> Array:
    """Return s_t = `DECAY` s_(t-1) + x_t along the first axis."""
    from scipy.signal import lfilter

    return np.asarray(lfilter([1.0], [1.0, -DECAY], series, axis=0), np.float64)


def _lags(series: Array, order: int) -> Array:
    return np.column_stack([series[order - i : len(series) - i] for i in range(order + 1)])
