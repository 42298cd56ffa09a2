"""One model function evaluated by each backend on the same table of inputs: rows are leaves, columns are cases."""

from collections.abc import Callable, Sequence
from typing import Any

import numba
import numpy as np

from plant.backends import array, lanes
from plant.backends.symbolic import symbolic_function
from plant.records import flatten, pack, paths, size
from tests.plant.harness import Array

Function = Callable[..., Any]


def leaves(kind: Any) -> int:
    """Return the number of rows that an argument takes."""
    return 1 if kind is float else size(kind)


def arguments(kinds: Sequence[Any], rows: Sequence[Any]) -> list[Any]:
    """Split rows into records and scalars."""
    stream = iter(rows)
    return [next(stream) if kind is float else pack(kind, [next(stream) for _ in range(size(kind))]) for kind in kinds]


def flat(result: Any) -> list[Any]:
    """Return the leaves of a record, of a tuple of records, or a scalar as a list."""
    return flatten(result) if isinstance(result, tuple) else [result]


def in_python(function: Function, kinds: Sequence[Any], table: Array) -> Array:
    """Evaluate case by case in plain floats."""
    return np.array([flat(function(*arguments(kinds, case))) for case in table.T.tolist()], dtype=float).T


def in_numpy(function: Function, kinds: Sequence[Any], table: Array) -> Array:
    """Evaluate all cases as arrays."""
    result = array.rebinder()(function)(*arguments(kinds, list(table)))
    return np.array([np.broadcast_to(leaf, table.shape[1]) for leaf in flat(result)], dtype=float)


def in_casadi(function: Function, kinds: Sequence[Any], table: Array) -> Array:
    """Evaluate the symbolic function at all cases."""
    bounds = np.cumsum([leaves(kind) for kind in kinds])[:-1]
    symbolic = symbolic_function("case", function, kinds)
    return np.array([np.array(symbolic(*np.split(case, bounds))).ravel() for case in table.T]).T


def compiled(function: Function, kinds: Sequence[Any], result: Sequence[Any]) -> Callable[[Array], Array]:
    """Return the function as the lanes backend compiles it, over a table; result: the kinds that it returns."""
    names: dict[str, Any] = {"function": lanes.rebinder()(function), "inline": lanes._inline}
    loaders, given, row = [], [], 0
    for i, kind in enumerate(kinds):
        if kind is float:
            given.append(f"a[{row}, l]")
        else:
            loaders.append(lanes.loader(kind, f"load_{i}", lanes.LANE, row, names))
            given.append(f"load_{i}(a, l)")
        row += leaves(kind)
    parts = ["r"] if len(result) == 1 else [f"r[{i}]" for i in range(len(result))]
    found = [part + ("" if kind is float else f".{path}") for part, kind in zip(parts, result, strict=True)
             for path in ([""] if kind is float else paths(kind))]  # fmt: skip
    stores = "".join(f"        out[{i}, l] = {leaf}\n" for i, leaf in enumerate(found))
    loop = f"def run(a, out):\n    for l in range(a.shape[1]):\n        r = function({', '.join(given)})\n{stores}"
    exec("\n".join([*loaders, loop]), names)
    run = numba.njit(fastmath=lanes.FAST_MATH, error_model="numpy")(names["run"])

    def over(table: Array) -> Array:
        out = np.empty((len(found), table.shape[1]))
        run(np.ascontiguousarray(table), out)
        return out

    return over


def difference(a: Array, b: Array) -> float:
    """Return the largest difference, each leaf scaled by the larger of 1 and its own size."""
    return float(np.max(np.abs(a - b) / np.maximum(1.0, np.abs(a)), axis=(0, 1)))
