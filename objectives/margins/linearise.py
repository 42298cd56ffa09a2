"""The closed loop linearized about steady flight, for batches of gains: x+ = A x + B u, o = C x + D u.

u holds the signals v, w, r and o the readings c, s, y, e of `period`; the nonlinear terms stay open between s and w. The
derivatives follow by the chain rule over one period, the controller's instant and then the plant steps, so they are those of the
flown code to rounding.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from objectives.margins.period import BODY, N_CHANNELS, ROTORS, PeriodMap

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LinearLoops:
    """Linearized loops of k channels with w nonlinear terms left open.

    They are a batch of loops of six channels, or of those of one block.
    a (..., x, x), b (..., x, k + w + k + k), c (..., k + w + k + k, x), d: from inputs v (k), w (w), r (k) and load (k) to
    outputs c (k), s (w), y (k), e (k); the slices of each part are given.
    """

    a: Array
    b: Array
    c: Array
    d: Array
    n_channels: int
    n_terms: int

    @property
    def injected(self) -> slice:
        """Columns of v in b and d."""
        return slice(0, self.n_channels)

    @property
    def terms(self) -> slice:
        """Columns of w in b and d; rows of s in c and d."""
        return slice(self.n_channels, self.n_channels + self.n_terms)

    @property
    def reference(self) -> slice:
        """Columns of r in b and d."""
        return slice(self.terms.stop, self.terms.stop + self.n_channels)

    @property
    def load(self) -> slice:
        """Columns of the load in b and d."""
        return slice(self.reference.stop, self.reference.stop + self.n_channels)

    @property
    def command(self) -> slice:
        """Rows of c in c and d."""
        return slice(0, self.n_channels)

    @property
    def output(self) -> slice:
        """Rows of y in c and d."""
        return slice(self.terms.stop, self.terms.stop + self.n_channels)

    @property
    def error(self) -> slice:
        """Rows of e in c and d."""
        return slice(self.output.stop, self.output.stop + self.n_channels)

    def of_channels(self, places: Sequence[int]) -> "LinearLoops":
        """Return the loops with the signals of some channels alone; their terms are closed."""
        k, w, first = self.n_channels, self.n_terms, np.array(places)
        spots = np.concatenate([first, k + w + first, 2 * k + w + first])
        b, c, d = self.b[..., spots], self.c[..., spots, :], self.d[..., spots[:, None], spots]
        return LinearLoops(self.a, b, c, d, len(first), 0)

    def of(self, rows: NDArray[np.bool_]) -> "LinearLoops":
        """Return some of the batch."""
        return self if rows.all() else replace(self, **{name: getattr(self, name)[rows] for name in "abcd"})

    @staticmethod
    def stacked(batches: "Sequence[LinearLoops]") -> "LinearLoops":
        """Return batches of loops as one."""
        parts = {name: np.concatenate([getattr(batch, name) for batch in batches], axis=0) for name in "abcd"}
        return replace(batches[0], **parts)

    def expanded(self) -> "LinearLoops":
        """The same with a second axis of length 1, for several cases."""
        return replace(self, **{name: getattr(self, name)[:, None] for name in "abcd"})

    def flattened(self) -> "LinearLoops":
        """The same with the first two axes as one."""
        parts = {}
        shape = self.a.shape[:2]
        for name in "abcd":
            part = getattr(self, name)
            parts[name] = np.broadcast_to(part, (*shape, *part.shape[2:])).reshape(-1, *part.shape[2:])
        return replace(self, **parts)


@dataclass(frozen=True)
class OperatingPoint:
    """OperatingPoint of a batch as rows of numbers: nominal, reference, disturbance, dynamics."""

    nominal: Array
    reference: Array
    disturbance: Array
    dynamics: Array


@dataclass(frozen=True)
class Plant:
    """A vehicle about the balance of its forces, which no gains change: there it stays at rest.

    body (17,) in balance; command (4,): speeds that are commanded there; following (17,): the body one period later; slope
    (17, 17 + 4 + 6): its derivative by body, commanded speeds and load.
    """

    body: Array
    command: Array
    following: Array
    slope: Array

    def after(self, body: Array, speed: Array) -> Array:
        """Return the bodies (n, 17) one period later, to first order.

        It is first order in what bodies and squares of commanded speeds (n, 4) are off balance.
        Thrust goes with about that square, so in squares the way to a balance far off is straight.
        """
        balance = self.command
        off = np.concatenate([body - self.body, 0.5 * (speed * speed / balance - balance)], axis=1)
        # Summed row by row: a product of matrices adds up in an order that depends on how many rows there are.
        return self.following + np.sum(self.slope[:, : BODY + ROTORS] * off[:, None], axis=-1)


def plant_about(period: PeriodMap, body: Array, setting: OperatingPoint) -> Plant:
    """The plant about a body (17,) in balance."""
    command = period.commands(body[-ROTORS:], setting.dynamics)
    held = np.concatenate([command, np.zeros(N_CHANNELS)])
    unit = np.eye(BODY + len(held))
    following, slope = body[None], unit[None, :BODY]
    for _ in range(period.timing.steps):
        following, entries, _ = period.fly(
            np.concatenate([following, held[None]], axis=1), setting.disturbance, setting.dynamics
        )
        slope = period.fly.full(entries) @ np.concatenate([slope, unit[None, BODY:]], axis=1)
    return Plant(body, command, following[0], slope[0])


@dataclass(frozen=True)
class PeriodStep:
    """One period at a batch of points: next state (n, x), readings (n, o) and values f(s) (n, w).

    entries (n, m): of the derivative of `PeriodMap.decide`, with speeds of rotors as shares of those in balance.
    """

    period: PeriodMap
    plant: Plant
    state: Array
    readings: Array
    values: Array
    entries: Array

    @property
    def signals(self) -> Array:
        """Signals s (n, w) of the nonlinear terms."""
        return self.readings[:, N_CHANNELS : N_CHANNELS + self.values.shape[1]]

    @cached_property
    def loops(self) -> LinearLoops:
        """The linear loops of all channels."""
        by_body, by_speed, by_load = np.split(self.plant.slope, [BODY, BODY + ROTORS], axis=-1)
        slope = self.period.decide.full(self.entries)
        return chained(slope, by_body, by_speed, by_load, N_CHANNELS, self.values.shape[1])


def chained(slope: Array, by_body: Array, by_command: Array, by_load: Array, k: int, w: int) -> LinearLoops:
    """Return the loops over a control period: the controller's instant, then the plant.

    Args:
        slope: Derivatives (n, m + memory + readings, x + k + w + k) of the controller's instant by state, v, w and r.
        by_body: Derivative (b, b) of the body a period later by the body, the first of the states.
        by_command: The same (b, m) by what the controller gives the plant.
        by_load: The same (..., b, k) by the load.
        k: Number of channels.
        w: Number of nonlinear terms.
    """
    b, m = by_command.shape
    x = slope.shape[-1] - k - w - k
    memory = slice(m, m + x - b)
    states = np.zeros((len(slope), x, slope.shape[-1] + k))
    states[:, :b, :-k] = by_command @ slope[:, :m]
    states[:, :b, :b] += by_body
    states[:, :b, -k:] = by_load
    states[:, b:, :-k] = slope[:, memory]
    readings = np.concatenate(
        [slope[:, memory.stop :], np.zeros((len(slope), slope.shape[1] - memory.stop, k))], axis=-1
    )
    return LinearLoops(states[:, :, :x], states[:, :, x:], readings[:, :, :x], readings[:, :, x:], k, w)


def one_period(
    period: PeriodMap, state: Array, w: Array, gains: Array, setting: OperatingPoint, plant: Plant
) -> PeriodStep:
    """Fly one period from states (n, x) and differentiate it.

    The terms give w (n, terms), under gains (n, g).
    The plant's part is that about its balance, which all candidates share.
    """
    none = np.zeros((len(gains), N_CHANNELS))
    outputs, entries, values = period.decide(
        np.concatenate([state, none, w, none], axis=1), gains, setting.nominal, setting.reference
    )
    body, speed = state[:, :BODY], outputs[:, :ROTORS]
    memory = slice(ROTORS, ROTORS + state.shape[1] - BODY)
    row, _ = period.decide.where
    of_speed = np.flatnonzero(row < ROTORS)
    entries[:, of_speed] *= (speed / plant.command)[:, row[of_speed]]
    following = np.concatenate([plant.after(body, speed), outputs[:, memory]], axis=1)
    return PeriodStep(period, plant, following, outputs[:, memory.stop :], values, entries)
