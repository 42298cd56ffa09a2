"""Margins of a loop as python-control finds them on a grid, refined with roots and minima of SciPy on its own response."""

from collections.abc import Callable
from typing import Any

import control
import numpy as np
from scipy.optimize import brentq, minimize_scalar


class Loop:
    """Frequency response of a loop sampled every h seconds, a function of z made of python-control's systems, kept on a grid."""

    def __init__(self, system: Callable[[Any], Any], h: float, grid: np.ndarray) -> None:
        self.system, self.h, self.grid = system, h, grid
        self.on_grid = system(np.exp(1j * grid * h))

    def __call__(self, w):
        return complex(self.system(np.exp(1j * w * self.h)))

    def refined(self, f, w):
        """Root of f(L) next to a frequency."""
        i = int(np.clip(np.searchsorted(self.grid, w), 1, len(self.grid) - 1))
        for low, high in (
            (self.grid[i - 1], self.grid[i]),
            (self.grid[max(i - 2, 0)], self.grid[min(i + 1, len(self.grid) - 1)]),
        ):
            if f(self(low)) * f(self(high)) < 0.0:
                return brentq(lambda v: f(self(v)), low, high, xtol=1e-10 * high, rtol=np.float64(1e-10))
        return w

    def least(self, f):
        """Least f(L) over all frequencies, ends included."""
        values = f(self.on_grid)
        lowest = []
        for i in np.nonzero(values < 1.2 * values.min(axis=0))[0]:
            bounds = self.grid[max(i - 1, 0)], self.grid[min(i + 1, len(self.grid) - 1)]
            if values[max(i - 1, 0)] >= values[i] <= values[min(i + 1, len(self.grid) - 1)]:
                found: Any = minimize_scalar(
                    lambda w: f(self(w)), bounds=bounds, method="bounded", options={"xatol": 1e-6 * bounds[1]}
                )
                lowest.append(min(found.fun, values[i]))
        return min(lowest)


def classical(loop):
    """Gain factors up and down, phase and delay margin of a loop, from the crossings that python-control finds."""
    data = control.frd(loop.on_grid, loop.grid, smooth=True)
    gains, phases, _, w_gain, w_phase, _ = control.stability_margins(data, returnall=True)
    factors = np.array([abs(1.0 / loop(loop.refined(np.imag, w))) for w in w_gain])
    crossed = np.array([loop.refined(lambda z: np.log(np.abs(z)), w) for w in w_phase])
    # At z = -1 the loop is real, which a grid does not tell.
    end = loop.on_grid[-1].real
    factors = np.append(factors, -1.0 / end if end < 0.0 else np.inf)
    lag = np.mod(np.angle([loop(w) for w in crossed]) + np.pi, 2.0 * np.pi) if len(crossed) else np.array([])
    return {
        "gain_up": min(factors[factors > 1.0], default=np.inf),
        "gain_down": min(1.0 / factors[(factors < 1.0) & (factors > 0.0)], default=np.inf),
        "phase": min(np.minimum(lag, 2.0 * np.pi - lag), default=np.inf),
        "delay": min(lag / crossed, default=np.inf) if len(lag) else np.inf,
    }
