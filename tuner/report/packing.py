"""Long series as text inside the page: little-endian binary in base64, which page scripts unpack when they need it."""

from base64 import b64encode
from typing import Any, NamedTuple

import numpy as np

# Largest number of sixteen bits; a step is 1/65535 of what a series spans, a hundredth of a pixel of a small figure.
LARGEST = 65535


class Quantised(NamedTuple):
    """Series in sixteen bits: value = low + step * q; packed: q, series after series."""

    low: float
    step: float
    packed: str

    def document(self) -> dict[str, Any]:
        """Return it as JSON-able data."""
        return {"scale": [self.low, self.step], "packed": self.packed}


def base64(values: np.ndarray, kind: str) -> str:
    """Return an array of any shape in row order, as numbers of a kind such as "<f4"."""
    return b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def singles(values: np.ndarray) -> str:
    """Return an array as numbers of 32 bits, about seven digits."""
    return base64(values, "<f4")


def quantised(values: np.ndarray) -> Quantised:
    """Return an array of finite numbers in sixteen bits, on a scale from its smallest to its largest."""
    low, high = float(values.min(axis=None)), float(values.max(axis=None))
    step = (high - low) / LARGEST
    whole = np.zeros(values.shape) if step == 0.0 else np.clip(np.round((values - low) / step), 0, LARGEST)
    return Quantised(low, step, base64(whole, "<u2"))


def finite(values: np.ndarray) -> list[float | None]:
    """Return an array (n,) as a list for JSON: unrounded, None where it is not finite."""
    return [value if np.isfinite(value) else None for value in values.tolist()]
