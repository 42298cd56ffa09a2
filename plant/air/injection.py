"""Disturbance injected directly as accelerations, without air: the way of papers that state no wind.

Six independent stationary first-order Gauss-Markov processes, gated by the window of the run, plus constant biases that
are not gated (a bias represents a lasting effect: an offset centre of mass, a weak rotor). Use it to
compare with published runs; use turbulence for anything that shall mean something outdoors.
Source: Gelb (ed.),
"Applied Optimal Estimation", MIT Press 1974, 2.2 (exponentially correlated process).
"""

from dataclasses import dataclass, fields
from functools import lru_cache
from math import inf

import numpy as np
from numpy.typing import NDArray

from plant.air import checks
from plant.air.linear_process import SampledProcess, discretize, gauss_markov, sample

Triple = tuple[float, ...]
_ZERO = (0.0, 0.0, 0.0)
_ONE = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Injection:
    """Standard deviations, correlation times [s] and biases per axis, three numbers each.

    acceleration...: along x, y, z of the world (ENU) [m/s2]. angular...: about x, y, z of the body (FLU) [rad/s2].
    Raises InputError with a key "injection...".
    """

    acceleration_sigma: Triple = _ZERO
    acceleration_time: Triple = _ONE
    acceleration_bias: Triple = _ZERO
    angular_sigma: Triple = _ZERO
    angular_time: Triple = _ONE
    angular_bias: Triple = _ZERO

    def __post_init__(self) -> None:
        for name in (field.name for field in fields(self)):
            low = -inf if name.endswith("bias") else 0.0
            triple = checks.numbers(getattr(self, name), f"injection.{name}", 3, low, above=name.endswith("time"))
            object.__setattr__(self, name, triple)

    @property
    def sigma(self) -> Triple:
        """Standard deviations of the six axes, linear first."""
        return self.acceleration_sigma + self.angular_sigma

    @property
    def time(self) -> Triple:
        """Correlation times of the six axes [s]."""
        return self.acceleration_time + self.angular_time

    @property
    def bias(self) -> Triple:
        """Biases of the six axes."""
        return self.acceleration_bias + self.angular_bias


def shape_injection(
    injection: Injection, dt: float, gate: NDArray[np.float64], normals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the injected accelerations (K, 6): linear in the world [m/s2], angular in the body [rad/s2].

    gate: factor (K,) of the window. normals (K, 6): drawn whatever the settings, so that one axis does not change another.
    """
    out = np.empty_like(normals)
    for axis, (sigma, time, bias) in enumerate(zip(injection.sigma, injection.time, injection.bias, strict=True)):
        noise = sample(_sampler(time, dt), normals[:, axis : axis + 1])[:, 0] if sigma > 0.0 else 0.0
        out[:, axis] = bias + sigma * gate * noise
    return out


@lru_cache(maxsize=64)
def _sampler(time: float, dt: float) -> SampledProcess:
    return discretize(gauss_markov(time), dt)
