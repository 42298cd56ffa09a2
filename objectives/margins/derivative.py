"""CasADi functions of columns with exact derivatives, on batches in NumPy arrays."""

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from plant.records import flatten, pack

Array = NDArray[np.float64]


class Batch:
    """A CasADi function of columns for batches.

    Called with arrays (n, columns), or (columns,) where all share one, it returns one array (n, rows) for each output.
    """

    def __init__(self, name: str, arguments: list[Any], outputs: list[Any]) -> None:
        self._function = ca.Function(name, arguments, [ca.densify(output) for output in outputs])
        self._mapped: dict[int, Any] = {}

    def __call__(self, *arguments: Array) -> list[Array]:
        """Evaluate a batch."""
        n = max([len(a) for a in arguments if a.ndim == 2], default=1)
        if n not in self._mapped:
            self._mapped[n] = self._function.map(n)
        # CasADi reads and writes the arrays themselves: a column of a batch is a row of ours.
        given: list[Any] = [np.ascontiguousarray(np.broadcast_to(a, (n, a.shape[-1]))) for a in arguments]
        results: list[Any] = [np.empty((n, self._function.size1_out(i))) for i in range(self._function.n_out())]
        buffer, evaluate = self._mapped[n].buffer()
        for i, array in enumerate(given):
            buffer.set_arg(i, memoryview(array))
        for i, array in enumerate(results):
            buffer.set_res(i, memoryview(array))
        evaluate()
        return results


class Derivative:
    """A CasADi function of columns with its derivative by `by`.

    It takes batches as `Batch` does.
    It returns outputs (n, rows), the entries (n, m) of their derivative that are not always 0 and what is not differentiated
    (n, more). where: rows and columns of the entries; shape: rows and columns of the derivative.
    """

    def __init__(self, name: str, by: Any, arguments: list[Any], outputs: Any, others: Any) -> None:
        slope: Any = ca.jacobian(outputs, by)
        row, column = slope.sparsity().get_triplet()
        self.where = (np.array(row), np.array(column))
        self.shape = (outputs.numel(), by.numel())
        self._batch = Batch(name, arguments, [outputs, ca.vertcat(*slope.nonzeros()), others])

    def __call__(self, *arguments: Array) -> tuple[Array, Array, Array]:
        """Evaluate a batch."""
        outputs, entries, others = self._batch(*arguments)
        return outputs, entries, others

    def full(self, entries: Array) -> Array:
        """Return derivatives (n, rows, columns) of entries (n, m)."""
        slope = np.zeros((len(entries), *self.shape))
        slope[:, *self.where] = entries
        return slope


def columns(*sizes: int) -> list[Any]:
    """Return symbols, a column of each size."""
    return [ca.SX.sym(f"a{i}", rows) for i, rows in enumerate(sizes)]


def record_of(kind: Any, column: Any) -> Any:
    """Return the record whose leaves are the rows of a column."""
    return pack(kind, ca.vertsplit(column) if column.numel() else [])


def column_of(parts: Any) -> Any:
    """Return the column of a record's leaves."""
    return ca.vertcat(*flatten(parts)) if parts else ca.SX(0, 1)
