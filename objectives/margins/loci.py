"""Characteristic loci of a lifted channel: eigenvalues of T(e^jwH) over frequency, their crossings and the delay margin.

A. G. J. MacFarlane, I. Postlethwaite, Int. J. Control 25(1), 1977; the meaning of
crossings is in `objectives.margins.multirate`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

# Halvings that find a crossing.
HALVINGS = 60
# Eigenvalues so close to 0 and to -1 belong to gain factors beyond 60 dB; the sign of what is left of them is rounding.
NOUGHT = 1e-3
# Distance from 0 and -1 beyond which an eigenvalue near the line Re T = -1/2 is looked at by itself.
NEAR_LINE = 0.25
# Halvings of cells of the grid in which several eigenvalues may cross: two crossings in one leave the sign of the product.
MAX_SPLITS = 8
NEWTON, SOLVED, NUDGE = 30, 1e-11, 1e-7


@dataclass(frozen=True)
class TransferMatrix:
    """Answers from some signals of one lifted loop to some readings: poles (b,), shown (o, b), driven (b, u), direct (o, u)."""

    poles: Complex
    shown: Complex
    driven: Complex
    direct: Array

    def at(self, z: Complex) -> Complex:
        """Return the matrices (f, o, u) at points z (f,)."""
        inverse = 1.0 / (z[:, None] - self.poles)
        return (self.shown * inverse[:, None, :]) @ self.driven + self.direct


class CharacteristicLoci:
    """Eigenvalues of T(e^jwH) of a channel with q instants, `step` [s] apart."""

    def __init__(self, part: TransferMatrix, period: float, step: float, instants: int) -> None:
        self._part, self._period, self._step = part, period, step
        self._turns = 2.0 * np.pi / period * np.arange(instants)

    def matrices(self, w: Array) -> Complex:
        """T (f, q, q) at frequencies (f,)."""
        return self._part.at(np.exp(1j * w * self._period))

    def values(self, w: Array) -> Complex:
        """Eigenvalues (f, q), in no order."""
        return np.linalg.eigvals(self.matrices(w)).astype(complex)

    def harmonics(self, w: float) -> Array:
        """Return the possible frequencies (q,) of a lifted signal at w, within +-pi/step."""
        top = np.pi / self._step
        return np.mod(w + self._turns + top, 2.0 * top) - top

    def waves(self, w: float) -> Complex:
        """Signals (q, q) of those frequencies, instants by harmonics, each of length 1."""
        at = self._step * np.arange(len(self._turns))
        return np.exp(1j * at[:, None] * self.harmonics(w)) / np.sqrt(len(at))

    def frequency(self, w: float, value: complex) -> tuple[float, complex]:
        """Return the frequency of an eigenvalue at w, and the eigenvalue.

        It is the frequency of the largest part of its eigenvector.
        """
        values, vectors = np.linalg.eig(self.matrices(np.array([w]))[0])
        vector = vectors[:, np.argmin(np.abs(values - value))]
        return float(self.harmonics(w)[np.argmax(np.abs(self.waves(w).conj().T @ vector))]), value

    def delayed(self, w: float, delay: float) -> complex:
        """Return det(I - (D - I) T) for a delay of the commands.

        It is 0 where the delay [s] leaves an oscillation of frequency w.
        """
        waves, turned = self.waves(w), np.exp(-1j * self.harmonics(w) * delay)
        late = (waves * (turned - 1.0)) @ waves.conj().T
        return complex(np.linalg.det(np.eye(len(turned)) - late @ self.matrices(np.array([w]))[0]))


def _separate(loci: CharacteristicLoci, w: Array, t: Complex, level: float | None) -> tuple[Array, Complex]:
    """Return frequencies (f,) and eigenvalues (f, q) with one crossing a cell.

    Cells of the grid given are halved. Eigenvalues are in the order of their distances from 0 and -1; two whose signs differ
    between the ends of a cell may both cross in it, or have changed places.
    """
    for _ in range(MAX_SPLITS):
        distance = np.minimum(np.abs(t), np.abs(1.0 + t))
        order = np.argsort(-distance, axis=-1)
        away = np.take_along_axis(t.imag if level is None else t.real - level, order, axis=-1)
        is_far = np.take_along_axis(distance, order, axis=-1) > (NOUGHT if level is None else NEAR_LINE)
        turned = ((away[:-1] < 0.0) != (away[1:] < 0.0)) & is_far[:-1] & is_far[1:]
        cells = np.flatnonzero(np.count_nonzero(turned, axis=-1) > 1)
        if not len(cells):
            break
        middle = 0.5 * (w[cells] + w[cells + 1])
        w, t = np.insert(w, cells + 1, middle), np.insert(t, cells + 1, loci.values(middle), axis=0)
    return w, t


def find_crossings(loci: CharacteristicLoci, w: Array, t: Complex, level: float | None) -> list[tuple[float, complex]]:
    """Return the frequencies and eigenvalues at crossings, in ]0, pi/H[.

    There an eigenvalue is real, or its real part is a level. The sign of the product needs no order among eigenvalues.
    """
    w, t = _separate(loci, w, t, level)

    def parts(values: Complex) -> Array:
        return values.imag if level is None else values.real - level

    def products(values: Complex) -> tuple[Array, NDArray[np.int_]]:
        """Return the signs of products (f, q + 1) of eigenvalues, and counts (f,).

        They begin with those farthest from 0 and -1; counts are of those that are not too close to either.
        """
        distance = np.minimum(np.abs(values), np.abs(1.0 + values))
        order = np.argsort(-distance, axis=-1)
        signs = np.ones((len(values), values.shape[-1] + 1))
        # A crossing at a point of the grid has one side, or it would be in neither cell.
        side = np.where(np.take_along_axis(parts(values), order, axis=-1) < 0.0, -1.0, 1.0)
        np.cumprod(side, axis=-1, out=signs[:, 1:])
        count = np.count_nonzero(distance >= (NOUGHT if level is None else 0.0), axis=-1)
        return signs, count

    inside = slice(1, -1) if level is None else slice(None)
    w, (signs, count) = w[inside], products(t[inside])
    # Both ends of a cell take the same number, for one that comes too close in between would turn the sign.
    fewest = np.minimum(count[:-1], count[1:])
    cells = np.arange(len(fewest))
    starts = np.flatnonzero(signs[cells, fewest] * signs[cells + 1, fewest] < 0.0)
    if not len(starts):
        return []
    low, high, used = w[starts], w[starts + 1], fewest[starts]
    first, rows = signs[starts, used], np.arange(len(starts))
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        same = products(loci.values(middle))[0][rows, used] == first
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    values = loci.values(high)
    small = np.minimum(np.abs(values), np.abs(1.0 + values)) < NOUGHT
    away = np.where(small & (level is None), np.inf, np.abs(parts(values)))
    nearest = np.argmin(away, axis=-1)
    return list(zip(high.tolist(), values[rows, nearest].tolist(), strict=True))


def delay_margin(
    loci: CharacteristicLoci, base: list[float], crossed: list[tuple[float, complex]]
) -> tuple[float, float]:
    """Delay margin [s] and its frequency; base: of the crossings in the common period, crossed: as they are and |L| = 1."""
    delays = []
    for w, (frequency, value) in zip(base, crossed, strict=True):
        lag = np.pi - 2.0 * np.arctan(2.0 * np.copysign(1.0, frequency) * value.imag)
        delays.append((_solve_delay(loci, w, float(lag) / abs(frequency)), abs(frequency)))
    return min(delays, default=(np.inf, 0.0))


def _solve_delay(loci: CharacteristicLoci, w: float, delay: float) -> float:
    """Return the delay at which the determinant vanishes, or the given one.

    Newton's method in frequency and delay starts from those of the curve.
    """
    point, sizes = np.array([w, delay]), np.array([w, delay])
    for _ in range(NEWTON):
        value = loci.delayed(*point)
        if abs(value) < SOLVED:
            break
        slope = [(loci.delayed(*(point + NUDGE * sizes * unit)) - value) / NUDGE for unit in np.eye(2)]
        table = np.array([[part.real for part in slope], [part.imag for part in slope]])
        if abs(np.linalg.det(table)) < 1e-300:
            break
        point = point - sizes * np.linalg.solve(table, [value.real, value.imag])
    solved = abs(loci.delayed(*point)) < 1e-8 and 0.5 * delay < point[1] < 2.0 * delay
    return float(point[1]) if solved else delay
