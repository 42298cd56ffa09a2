"""Limit cycles by harmonic balance: amplitudes at which an oscillation, seen through describing functions, sustains itself.

The poles of the closed loop move with the amplitude of the terms' signals. Where a pair crosses the unit circle, an
oscillation of that amplitude and frequency neither grows nor decays: a stable cycle where larger amplitudes decay (Loeb), else
the edge of what is stable. A. Gelb, W. E. Vander Velde, Multiple-Input Describing Functions, McGraw-Hill 1968, chapter 3. The
loop must be a low pass for the harmonics: against flights of the sampled loop, super-twisting with a lag comes out right to
2 %, the hybrid law to 5 %.

Terms with different signals swing in the ratio that the critical mode gives them, which is found by iteration.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from objectives.margins.closing import close_terms
from objectives.margins.describing import describing_function
from objectives.margins.linearise import LinearLoops
from objectives.margins.period import Term
from objectives.margins.structure import Block

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Amplitudes that are scanned, each in the unit of its signal, and how many are looked at again about a crossing.
LOWEST, HIGHEST, SCANNED, RESCANNED = 1e-8, 1e2, 241, 25
# Halvings of a bracket, rounds in which the signals find their ratio, and the change of it that ends them.
HALVINGS, ROUNDS, SETTLED = 45, 25, 1e-6


@dataclass(frozen=True)
class LimitCycle:
    """channels of the block that swings; frequency [rad/s]; amplitudes: of each nonlinear term's signal, by (axis, term), in its
    unit; stable: whether the oscillation attracts.
    """

    channels: tuple[str, ...]
    frequency: float
    amplitudes: dict[tuple[str, str], float]
    stable: bool


class OpenLoops(Protocol):
    """A margin model whose blocks can be had with their nonlinear terms left open: of a quadrotor, or of a plant."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of all channels."""
        ...

    @property
    def terms(self) -> tuple[Term, ...]:
        """Nonlinear terms of the laws."""
        ...

    @property
    def period(self) -> float:
        """Control period [s]."""
        ...

    def constants(self, gains: Array) -> Any:
        """Constants of all channels for gains rows (n, g)."""
        ...

    def open_blocks(self, gains: Array) -> Sequence[tuple[Block, LinearLoops]]:
        """Blocks under a gains row (g,) with their loops (1, ...)."""
        ...


@dataclass(frozen=True)
class _Swing:
    """A block's loops with open terms, (1, ...), and its terms with their constants under the gains in question."""

    loops: LinearLoops
    terms: tuple[Term, ...]
    constants: tuple[object, ...]

    def closed(self, amplitude: Array) -> LinearLoops:
        """Loops closed at amplitudes (m, terms)."""
        gains = [
            describing_function(term.nonlinearity.function, own, amplitude[:, j])[0]
            for j, (term, own) in enumerate(zip(self.terms, self.constants, strict=True))
        ]
        return close_terms(self.loops, np.stack(gains, axis=-1))

    def outside(self, amplitude: Array) -> NDArray[np.intp]:
        """Number of poles outside the unit circle at amplitudes (m, terms)."""
        return np.sum(np.abs(np.linalg.eigvals(self.closed(amplitude).a)) > 1.0, axis=-1)

    def critical(self, amplitude: Array) -> tuple[complex, Array]:
        """Pole nearest to the circle at one amplitude (terms,), and what the signals of its mode measure."""
        closed = self.closed(amplitude[None])
        poles, modes = np.linalg.eig(closed.a[0])
        at = int(np.argmin(np.abs(np.abs(poles) - 1.0)))
        return complex(poles[at]), np.abs(closed.c[0][closed.terms] @ modes[:, at])


def limit_cycles(model: OpenLoops, gains: Array) -> tuple[LimitCycle, ...]:
    """Limit cycles of all blocks under a gains row (g,), lowest amplitude first; none for linear laws.

    Only oscillations are reported, not the slow drift of a real pole through 1.
    """
    row = np.asarray(gains, dtype=float)
    constants = model.constants(row[None])
    found = []
    for block, loops in model.open_blocks(row):
        if block.terms:
            terms = tuple(model.terms[i] for i in block.terms)
            swing = _Swing(loops, terms, tuple(getattr(constants, term.axis) for term in terms))
            names = tuple(model.channels[i] for i in block.channels)
            found += [cycle for cycle in _cycles(swing, names, model.period) if cycle is not None]
    return tuple(found)


def _cycles(swing: _Swing, channels: tuple[str, ...], h: float) -> list[LimitCycle | None]:
    scan = np.geomspace(LOWEST, HIGHEST, SCANNED)
    alike = np.ones(len(swing.terms))
    count = swing.outside(scan[:, None] * alike)
    return [
        _cycle(swing, channels, h, scan[i], scan[i + 1], bool(count[i] > count[i + 1]))
        for i in np.nonzero(count[1:] != count[:-1])[0]
    ]


def _cycle(
    swing: _Swing, channels: tuple[str, ...], h: float, low: float, high: float, stable: bool
) -> LimitCycle | None:
    """The cycle whose amplitude was found between two with all signals alike, at the signals' own ratio."""
    ratio, amplitude, pole = np.ones(len(swing.terms)), 0.0, 1.0 + 0.0j
    for _ in range(ROUNDS):
        bracket = _bracket(swing, ratio, low, high, stable)
        if bracket is None:
            return None
        amplitude = _crossing(swing, ratio, *bracket, stable)
        pole, signals = swing.critical(amplitude * ratio)
        following = signals / signals.max(axis=0)
        settled = np.abs(following - ratio).max(axis=0) < SETTLED
        # The next round looks about the amplitude that the largest signal had.
        largest = float(amplitude * ratio[np.argmax(following)])
        low, high, ratio = largest / 3.0, largest * 3.0, following
        if settled:
            break
    if pole.imag == 0.0:
        return None
    amplitudes = {
        (term.axis, term.nonlinearity.name): float(amplitude * r) for term, r in zip(swing.terms, ratio, strict=True)
    }
    return LimitCycle(channels, abs(float(np.angle(pole))) / h, amplitudes, stable)


def _bracket(swing: _Swing, ratio: Array, low: float, high: float, stable: bool) -> tuple[float, float] | None:
    """Neighbouring amplitudes between which poles cross the way that is looked for."""
    scan = np.geomspace(low, high, RESCANNED)
    count = swing.outside(scan[:, None] * ratio)
    change = count[:-1] > count[1:] if stable else count[:-1] < count[1:]
    at = np.nonzero(change)[0]
    return (float(scan[at[0]]), float(scan[at[0] + 1])) if len(at) else None


def _crossing(swing: _Swing, ratio: Array, low: float, high: float, stable: bool) -> float:
    """Amplitude at which the number of poles outside the circle changes."""
    below = int(swing.outside(low * ratio[None])[0])
    for _ in range(HALVINGS):
        middle = float(np.sqrt(low * high))
        if int(swing.outside(middle * ratio[None])[0]) == below:
            low = middle
        else:
            high = middle
    return float(np.sqrt(low * high))
