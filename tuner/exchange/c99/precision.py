"""The model functions run in the precision of the target: the oracle of the exported C and the source of its golden vectors.

Signals are NumPy arrays of that precision, one element a flight, constants Python floats, which NumPy rounds where the two meet.
So a run does what the C does: constants are worked out in double precision, everything else in the target's.
"""

from typing import Any

import numpy as np

from plant import primitives
from plant.backends import vector_math
from plant.backends.c_code import Real, rounded
from plant.backends.rebind import Rebinder
from plant.records import flatten, pack


def rebinder(real: Real) -> Rebinder:
    """Return a rebinder to arrays of a precision; minimum, maximum and floor treat signed zeros as Python does."""

    def held(value: Any) -> Any:
        return value if isinstance(value, np.ndarray) else real.dtype(rounded(value, real))

    def minimum(a: Any, b: Any) -> Any:
        return np.where(held(b) < held(a), held(b), held(a))

    def maximum(a: Any, b: Any) -> Any:
        return np.where(held(b) > held(a), held(b), held(a))

    def select(condition: Any, if_true: Any, if_false: Any) -> Any:
        if isinstance(condition, np.ndarray):
            return np.where(condition, held(if_true), held(if_false))
        return if_true if condition else if_false

    signals: dict[str, Any] = {
        "absolute": np.abs,
        "both": np.logical_and,
        "clip": lambda a, low, high: minimum(maximum(a, low), high),
        "either": np.logical_or,
        # Python's floor is an integer, which has no -0.
        "floor": lambda a: np.floor(a) + real.dtype(0.0),
        "maximum": maximum,
        "minimum": minimum,
        "sign": lambda a: np.sign(a) + real.dtype(0.0),
        "sqrt": np.sqrt,
    }

    def on_signals(name: str) -> Any:
        constant, signal = getattr(primitives, name), signals[name]

        def operation(*args: Any) -> Any:
            return signal(*args) if any(isinstance(arg, np.ndarray) for arg in args) else constant(*args)

        return operation

    names: dict[str, Any] = {name: on_signals(name) for name in signals} | {"select": select}
    names |= {name: getattr(primitives, name) for name in ("cos", "exp", "log", "sin", "tan", "tanh")}
    inner = Rebinder(names)
    written_out = {"atan2": inner(vector_math.atan2), "asin": inner(vector_math.asin), "hypot": inner(primitives.hypot)}
    return Rebinder(names | written_out)


def as_signals(record: Any, real: Real, lanes: int) -> Any:
    """Return a record with every leaf an array (lanes,) of the precision; floats are the same in all lanes."""

    def array(leaf: Any) -> Any:
        if isinstance(leaf, np.ndarray) and leaf.shape == (lanes,) and leaf.dtype == real.dtype:
            return leaf
        value = leaf if isinstance(leaf, np.ndarray) else real.dtype(rounded(leaf, real))
        return np.broadcast_to(value, (lanes,)).astype(real.dtype)

    return pack(type(record), [array(leaf) for leaf in flatten(record)])


def signals(kind: Any, rows: Any, real: Real) -> Any:
    """Return a record of arrays from an array (leaves, lanes)."""
    return pack(kind, [np.asarray(row, dtype=real.dtype) for row in rows])


def matrix(record: Any) -> np.ndarray:
    """Return the leaves of a record as an array (leaves, lanes)."""
    return np.array(flatten(record))
