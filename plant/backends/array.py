"""The numpy backend: the model on arrays, one element a flight. The oracle of the others, and for plots of a single law."""

from functools import cache
from typing import Any

import numpy as np

from plant.backends.rebind import Rebinder


def _clip(a: Any, low: Any, high: Any) -> Any:
    return np.minimum(np.maximum(a, low), high)


def _hypot(a: Any, b: Any) -> Any:
    return np.sqrt(a * a + b * b)


NAMES: dict[str, Any] = {
    "absolute": np.abs,
    "asin": np.arcsin,
    "atan2": np.arctan2,
    "both": np.logical_and,
    "clip": _clip,
    "cos": np.cos,
    "either": np.logical_or,
    "exp": np.exp,
    "floor": np.floor,
    "hypot": _hypot,
    "log": np.log,
    "maximum": np.maximum,
    "minimum": np.minimum,
    "select": np.where,
    "sign": np.sign,
    "sin": np.sin,
    "sqrt": np.sqrt,
    "tan": np.tan,
    "tanh": np.tanh,
}


@cache
def rebinder() -> Rebinder:
    """Return the rebinder to NumPy ufuncs."""
    return Rebinder(NAMES)
