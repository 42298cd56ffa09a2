"""Limit cycles by harmonic balance: amplitudes at which an oscillation, seen through describing functions, sustains itself.

The poles of the closed loop move with the amplitude of the terms' signals. If a pair crosses the unit circle, an
oscillation of that amplitude and frequency neither grows nor decays: a stable cycle where larger amplitudes decay (Loeb), else
the edge of what is stable. A. Gelb, W. E. Vander Velde, Multiple-Input Describing Functions, McGraw-Hill 1968, chapter 3. The
loop must be a low pass for the harmonics: against flights of the sampled loop, super-twisting with a lag comes out right to
2 %, the hybrid law to 5 %.

Terms with different signals swing in the ratio that the critical mode gives them, which is found by iteration.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from objectives.margins.closing import close_terms
from objectives.margins.describing import describing_function
from objectives.margins.linearise import LinearLoops
from objectives.margins.loop_margins import LoopMargins
from objectives.margins.period import Term

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


@dataclass(frozen=True)
class _OpenBlock:
    """A block with its nonlinear terms left open.

    Args:
        phases: Its loops (1, ...) in each control period of the common one.
        terms: Its nonlinear terms.
        constants: Constants of each term's law under the gains in question.
        control_period: Control period [s].
    """

    phases: Sequence[LinearLoops]
    terms: tuple[Term, ...]
    constants: tuple[object, ...]
    control_period: float

    def closed(self, amplitude: Array) -> list[LinearLoops]:
        """Loops closed at amplitudes (m, terms), in each control period."""
        gains = [
            describing_function(term.nonlinearity.function, constants, amplitude[:, j])[0]
            for j, (term, constants) in enumerate(zip(self.terms, self.constants, strict=True))
        ]
        return [close_terms(loops, np.stack(gains, axis=-1)) for loops in self.phases]

    def outside(self, amplitude: Array) -> NDArray[np.intp]:
        """Number of poles outside the unit circle at amplitudes (m, terms)."""
        return np.sum(np.abs(np.linalg.eigvals(_monodromy(self.closed(amplitude)))) > 1.0, axis=-1)

    def critical(self, amplitude: Array) -> tuple[float, Array]:
        """Return frequency [rad/s] and signal sizes of the most critical mode.

        Its pole is nearest to the circle at one amplitude (terms,).
        Poles over n control periods leave open which of n frequencies the mode has: it is that of most of the largest signal.
        """
        closed = self.closed(amplitude[None])
        n, (poles, modes) = len(closed), np.linalg.eig(_monodromy(closed)[0])
        at = int(np.argmin(np.abs(np.abs(poles) - 1.0)))
        state, signals = modes[:, at], []
        for loops in closed:
            signals.append(loops.c[0][loops.terms] @ state)
            state = loops.a[0] @ state
        sizes, angle = np.abs(signals).max(axis=0), np.angle(poles[at])
        if poles[at].imag == 0.0 and n == 1:
            return 0.0, sizes
        turned = np.array(signals)[:, np.argmax(sizes)] * np.exp(-1j * angle * np.arange(n) / n)
        turns = int(np.argmax(np.abs(np.fft.fft(turned))))
        turns -= n if 2 * turns > n else 0
        return abs(float(angle + 2.0 * np.pi * turns)) / (n * self.control_period), sizes


def _monodromy(phases: Sequence[LinearLoops]) -> Array:
    """State matrices (m, b, b) over a common period."""
    return reduce(lambda before, loops: loops.a @ before, phases[1:], phases[0].a)


def limit_cycles(model: LoopMargins, gains: Array) -> tuple[LimitCycle, ...]:
    """Return the limit cycles of all blocks, lowest amplitude first; none for linear laws.

    gains: a gains row (g,).
    Only oscillations are reported, not the slow drift of a real pole through 1.
    """
    row = np.asarray(gains, dtype=float)
    constants = model.constants(row[None])
    cycles: list[LimitCycle] = []
    for block, phases in model.open_blocks(row):
        if block.terms:
            terms = tuple(model.terms[i] for i in block.terms)
            of_terms = tuple(getattr(constants, term.axis) for term in terms)
            names = tuple(model.channels[i] for i in block.channels)
            cycles += _cycles(_OpenBlock(phases, terms, of_terms, model.control_period), names)
    return tuple(cycles)


def _cycles(block: _OpenBlock, channels: tuple[str, ...]) -> list[LimitCycle]:
    scan = np.geomspace(LOWEST, HIGHEST, SCANNED)
    alike = np.ones(len(block.terms))
    count = block.outside(scan[:, None] * alike)
    cycles = [
        _cycle(block, channels, scan[i], scan[i + 1], bool(count[i] > count[i + 1]))
        for i in np.nonzero(count[1:] != count[:-1])[0]
    ]
    return [cycle for cycle in cycles if cycle is not None]


def _cycle(block: _OpenBlock, channels: tuple[str, ...], low: float, high: float, stable: bool) -> LimitCycle | None:
    """Return the limit cycle at the ratio of its signals, or None.

    low, high: amplitudes between which it lies with all signals alike.
    """
    ratio, amplitude, frequency = np.ones(len(block.terms)), 0.0, 0.0
    for _ in range(ROUNDS):
        bracket = _bracket(block, ratio, low, high, stable)
        if bracket is None:
            return None
        amplitude = _crossing(block, ratio, *bracket, stable)
        frequency, signals = block.critical(amplitude * ratio)
        following = signals / signals.max(axis=0)
        settled = np.abs(following - ratio).max(axis=0) < SETTLED
        # The next round looks about the amplitude that the largest signal had.
        largest = float(amplitude * ratio[np.argmax(following)])
        low, high, ratio = largest / 3.0, largest * 3.0, following
        if settled:
            break
    if frequency == 0.0:
        return None
    amplitudes = {
        (term.axis, term.nonlinearity.name): float(amplitude * r) for term, r in zip(block.terms, ratio, strict=True)
    }
    return LimitCycle(channels, frequency, amplitudes, stable)


def _bracket(block: _OpenBlock, ratio: Array, low: float, high: float, stable: bool) -> tuple[float, float] | None:
    """Neighbouring amplitudes between which poles cross the way that is looked for."""
    scan = np.geomspace(low, high, RESCANNED)
    count = block.outside(scan[:, None] * ratio)
    change = count[:-1] > count[1:] if stable else count[:-1] < count[1:]
    at = np.nonzero(change)[0]
    return (float(scan[at[0]]), float(scan[at[0] + 1])) if len(at) else None


def _crossing(block: _OpenBlock, ratio: Array, low: float, high: float, stable: bool) -> float:
    """Amplitude at which the number of poles outside the circle changes."""
    below = int(block.outside(low * ratio[None])[0])
    for _ in range(HALVINGS):
        middle = float(np.sqrt(low * high))
        if int(block.outside(middle * ratio[None])[0]) == below:
            low = middle
        else:
            high = middle
    return float(np.sqrt(low * high))
