"""Loops that are flown, as matrices by differences of their steps: none of the margins' own linearization or lifting.

The closed loop of a system is stepped from points about its trim, all of them at once; the body's attitude is a rotation vector
about that of the trim, so its quaternion has no fourth direction. Altered in one channel, by a factor or a delay of its command,
the loop is stable where the matrix of its common period has its poles inside the unit circle (Floquet).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Step = Callable[[Array, int, Array], tuple[Array, Array]]
# Half the difference in a state of size 1, and from which on: smaller ones round, larger ones bend.
DIFFERENCE = 1e-5


@dataclass(frozen=True)
class FlownLoop:
    """A periodic loop x(k+1) = A_k x + B_k v, c = C_k x + D_k v, from signals v at the break points to commands c."""

    a: list[Array]
    b: list[Array]
    c: list[Array]
    d: list[Array]

    def is_stable(self, channel: int = 0, factor: complex = 1.0, delay: int = 0) -> bool:
        """Return True if the loop comes to rest with a channel's command times a factor and so many periods late."""
        return self.radius(channel, factor, delay) < 1.0

    def radius(self, channel: int = 0, factor: complex = 1.0, delay: int = 0) -> float:
        """Return the spectral radius of the altered loop over its common period."""
        n = len(self.a[0])
        whole: Any = np.eye(n + delay)
        for a, b, c, d in zip(self.a, self.b, self.c, self.d, strict=True):
            column, row, direct = b[:, channel], c[channel], d[channel, channel]
            # The queue holds the latest commands, newest first; its last one comes into force in place of the newest.
            seen = np.concatenate([row, np.zeros(delay)]).astype(complex)
            late = np.eye(n + delay)[-1] if delay else seen
            v = (factor * late - seen) / (1.0 - (0.0 if delay else factor - 1.0) * direct)
            v = v / (1.0 + direct) if delay else v
            period = np.zeros((n + delay, n + delay), dtype=complex)
            period[:n, :n] = a
            period[:n] += column[:, None] * v[None]
            if delay:
                period[n] = seen + direct * v
                period[n + 1 :, n:-1] = np.eye(delay - 1)
            whole = period @ whole
        return float(np.abs(np.linalg.eigvals(whole)).max())


def linearized(step: Step, rest: Array, periods: int, channels: int, quaternion: int | None = None) -> FlownLoop:
    """Return a flown loop about a state at which it rests.

    Args:
        step: The step from states (n, lanes), number of the period and signals (channels, lanes) to states and commands.
        rest: State (n,) at the start of the common period.
        periods: Control periods of the common period.
        channels: Number of channels.
        quaternion: Index of the first of the four numbers of the attitude.
    """
    matrices: list[tuple[Array, ...]] = []
    still = np.zeros((channels, 1))
    for k in range(periods):
        chart = _Chart(rest, quaternion)
        following = step(rest[:, None], k, still)[0][:, 0]
        n = chart.size
        sizes = DIFFERENCE * np.concatenate([chart.scale, np.ones(channels)])
        offsets = np.concatenate([np.diag(sizes), -np.diag(sizes)], axis=1)
        after, command = step(chart.at(offsets[:n]), k, offsets[n:])
        moved = _Chart(following, quaternion).of(after)
        rows = np.concatenate([moved, command])
        slope = (rows[:, : len(sizes)] - rows[:, len(sizes) :]) / (2.0 * sizes)
        matrices.append((slope[:n, :n], slope[:n, n:], slope[n:, :n], slope[n:, n:]))
        rest = following
    return FlownLoop(*(list(part) for part in zip(*matrices, strict=True)))


class _Chart:
    """Coordinates (m,) about a state (n,): differences, and a rotation vector in body axes for the quaternion."""

    def __init__(self, rest: Array, quaternion: int | None) -> None:
        self._rest, self._q = rest, quaternion
        self.size = len(rest) - (quaternion is not None)
        self.scale = self._without(np.maximum(np.abs(rest), 1.0)[:, None])[:, 0]

    def at(self, offsets: Array) -> Array:
        """Return the states (n, lanes) of coordinates (m, lanes)."""
        if self._q is None:
            return self._rest[:, None] + offsets
        q = self._q
        turn = 0.5 * offsets[q : q + 3]
        angle = np.linalg.norm(turn, axis=0)
        sine = np.sinc(angle / np.pi)
        turned = _product(self._rest[q : q + 4, None], np.concatenate([np.cos(angle)[None], turn * sine]))
        whole = np.concatenate([offsets[:q], np.zeros((4, offsets.shape[1])), offsets[q + 3 :]])
        whole = self._rest[:, None] + whole
        whole[q : q + 4] = turned
        return whole

    def of(self, states: Array) -> Array:
        """Return the coordinates (m, lanes) of states (n, lanes)."""
        plain = self._without(states - self._rest[:, None])
        if self._q is not None:
            q = self._q
            back = self._rest[q : q + 4, None] * np.array([1.0, -1.0, -1.0, -1.0])[:, None]
            turned = _product(back, states[q : q + 4])
            plain[q : q + 3] = 2.0 * turned[1:] / turned[:1]
        return plain

    def _without(self, rows: Array) -> Array:
        return rows.copy() if self._q is None else np.delete(rows, self._q + 3, axis=0)


def _product(p: Array, q: Array) -> Array:
    """Hamilton product of quaternions (4, lanes), scalar first."""
    (a, b, c, d), (w, x, y, z) = np.broadcast_arrays(p, q)[0], np.broadcast_arrays(p, q)[1]
    return np.array(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ]
    )
