"""Structures of transfer functions: poles by time constants, frequencies and damping ratios, and a number of zeros.

A structure has the denominator

    d(s) = s^q (T s + 1) ... (s^2 / w^2 + 2 z s / w + 1) ...

with q integrators. Its shape parameters are the logarithms of T, w and z, so all of them are positive. Coefficients of the
numerator enter the output linearly and are no shape parameters.
"""

from dataclasses import dataclass

import numpy as np

Array = np.ndarray
MAX_ORDER = 4
"""Most poles: the coefficients of a sampled filter of more poles lose their digits."""
MIN_DAMPING, MAX_DAMPING = 5e-3, 30.0


@dataclass(frozen=True)
class Structure:
    """A structure; name: what a reader knows it by.

    Attributes:
        name: Name in tables.
        lags: Number of single poles.
        pairs: Number of pairs of poles, real or complex.
        integrators: Number of poles at 0.
        zeros: Degree of the numerator.
        has_dead_time: Whether the dead time is estimated; otherwise it is 0.
    """

    name: str
    lags: int = 0
    pairs: int = 0
    integrators: int = 0
    zeros: int = 0
    has_dead_time: bool = True

    @property
    def order(self) -> int:
        """Number of poles."""
        return self.lags + 2 * self.pairs + self.integrators

    @property
    def n_shape(self) -> int:
        """Number of shape parameters."""
        return self.lags + 2 * self.pairs

    @property
    def n_free(self) -> int:
        """Number of parameters of an input: shape, numerator and dead time."""
        return self.n_shape + self.zeros + 1 + self.has_dead_time

    def denominator(self, shape: Array) -> Array:
        """Return the coefficients (order + 1,) of d(s), highest power of s first."""
        values = np.exp(shape)
        coefficients = np.array([1.0] + [0.0] * self.integrators)
        for time_constant in values[: self.lags]:
            coefficients = np.convolve(coefficients, [time_constant, 1.0])
        for i in range(self.lags, self.n_shape, 2):
            w, damping = values[i], values[i + 1]
            coefficients = np.convolve(coefficients, [1.0 / w**2, 2.0 * damping / w, 1.0])
        return coefficients

    def bounds(self, fastest: float, slowest: float) -> tuple[Array, Array]:
        """Return the ends of shape parameters; fastest, slowest: time constants [s]."""
        low = [np.log(fastest)] * self.lags + [-np.log(slowest), np.log(MIN_DAMPING)] * self.pairs
        high = [np.log(slowest)] * self.lags + [-np.log(fastest), np.log(MAX_DAMPING)] * self.pairs
        return np.array(low), np.array(high)

    @property
    def names(self) -> list[tuple[str, str]]:
        """Names and units of the shape parameters; unit "s" or "rad/s" or "1"."""
        lags = [(f"T{i + 1}" if self.lags > 1 else "T", "s") for i in range(self.lags)]
        tails = [str(i + 1) if self.pairs > 1 else "" for i in range(self.pairs)]
        return lags + [entry for tail in tails for entry in ((f"w{tail}", "rad/s"), (f"zeta{tail}", "1"))]


def extended(shapes: Array, simpler: Structure, richer: Structure, fast: float) -> Array | None:
    """Return shapes of a richer structure with a simpler one's poles.

    None: it lacks these poles.

    Args:
        shapes: Shapes (inputs, n) of the simpler structure.
        simpler: Structure with these shapes.
        richer: Structure to be described.
        fast: Time constant of the further poles [s].
    """
    further = richer.order - simpler.order
    if further < 0 or simpler.integrators != richer.integrators or simpler.pairs > richer.pairs:
        return None
    if simpler.zeros > richer.zeros or simpler.has_dead_time > richer.has_dead_time:
        return None
    rows = []
    for shape in shapes:
        lags, pairs = [*shape[: simpler.lags], *[np.log(fast)] * further], list(shape[simpler.lags :])
        for _ in range(richer.pairs - simpler.pairs):
            slow, quick = lags.pop(0), lags.pop()
            # Two lags are a pair with w^2 = 1 / (T1 T2) and 2 zeta / w = T1 + T2.
            w = -0.5 * (slow + quick)
            pairs += [w, w + np.logaddexp(slow, quick) - np.log(2.0)]
        rows.append([*lags, *pairs])
    return np.array(rows)


FIRST = Structure("first order", lags=1)
SECOND = Structure("second order", pairs=1)
SECOND_ZERO = Structure("second order with a zero", pairs=1, zeros=1)
THIRD = Structure("third order", lags=1, pairs=1)
THIRD_ZERO = Structure("third order with a zero", lags=1, pairs=1, zeros=1)
FOURTH_ZEROS = Structure("fourth order with two zeros", pairs=2, zeros=2)
INTEGRATING = Structure("integrating", integrators=1)
INTEGRATING_LAG = Structure("integrating with a lag", lags=1, integrators=1)
DOUBLE = Structure("double integrating", integrators=2)
STRUCTURES: dict[str, Structure] = {
    each.name.replace(" ", "-"): each
    for each in (
        FIRST, SECOND, SECOND_ZERO, THIRD, THIRD_ZERO, FOURTH_ZEROS, INTEGRATING, INTEGRATING_LAG, DOUBLE
    )
}  # fmt: skip
"""Structures by their name on the command line, each after those from which it starts."""
