"""The matrices of a block from the derivatives of one instant, compiled.

The controller's derivative has some hundred entries that are not zero; each moves few entries of a block's matrices, always in
the same proportions. These are worked out once, from the block and the plant, so the loop of all states need not be written down
for each candidate.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from objectives.margins.linearise import LinearLoops, PeriodStep, Plant
from objectives.margins.period import BODY, N_CHANNELS, ROTORS
from objectives.margins.structure import Block
from plant.backends.cache import keep_file
from plant.backends.compiling import kernel

Array = NDArray[np.float64]

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": {"contract", "nsz"}}


class Assembly:
    """Matrices of one block of a plant's loops under any gains: `block.part(step.loops)`, without those loops.

    where: rows and columns of the entries of the controller's derivative; size: number of its rows and columns.
    """

    def __init__(
        self,
        block: Block,
        plant: Plant,
        n_terms: int,
        where: tuple[NDArray[np.intp], NDArray[np.intp]],
        size: tuple[int, int],
    ) -> None:
        self._block, (b, x), k = block, block.into.shape, len(block.channels)
        channels, terms = np.array(block.channels, dtype=int), np.array(block.terms, dtype=int)
        parts = [channels, N_CHANNELS + terms, N_CHANNELS + n_terms + channels]
        inputs = np.concatenate(parts)
        outputs = np.concatenate([*parts, 2 * N_CHANNELS + n_terms + channels])
        by_body, by_speed, by_load = np.split(plant.slope, [BODY, BODY + ROTORS], axis=-1)
        rows, columns = np.zeros((b + len(outputs), size[0])), np.zeros((size[1], b + len(inputs) + k))
        memory = ROTORS + x - BODY
        rows[:b, :ROTORS] = block.into[:, :BODY] @ by_speed
        rows[:b, ROTORS:memory] = block.into[:, BODY:]
        rows[b + np.arange(len(outputs)), memory + outputs] = 1.0
        columns[:x, :b] = block.out_of
        columns[x + inputs, b + np.arange(len(inputs))] = 1.0
        fixed = np.zeros((len(rows), columns.shape[1]))
        fixed[:b, :b] = block.into[:, :BODY] @ by_body @ block.out_of[:BODY]
        fixed[:b, b + len(inputs) :] = block.into[:, :BODY] @ by_load[:, channels]
        self._fixed, self._states = fixed, b
        self._entry, self._place, self._weight = _shares(rows, columns, *where)

    def __call__(self, step: PeriodStep, chosen: NDArray[np.bool_]) -> LinearLoops:
        """Loops of some of the candidates of a step, terms left open."""
        rows = np.flatnonzero(chosen)
        matrices = np.empty((len(rows), *self._fixed.shape))
        places = matrices.reshape(len(rows), -1)
        assemble(step.entries, rows, self._entry, self._place, self._weight, self._fixed.ravel(), places)
        b = self._states
        return LinearLoops(
            matrices[:, :b, :b],
            matrices[:, :b, b:],
            matrices[:, b:, :b],
            matrices[:, b:, b:],
            len(self._block.channels),
            len(self._block.terms),
        )


def _shares(
    rows: Array, columns: Array, row: NDArray[np.intp], column: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Return the entries, the places each moves, and their weights.

    Places are those of a block's matrices, as one row; an entry moves a place by its weight times itself.
    """
    seen = np.nonzero(np.any(rows[:, row], axis=0) & np.any(columns[column], axis=1))[0]
    left, right = rows[:, row[seen]].T, columns[column[seen]]
    is_moved = (left != 0.0)[:, :, None] & (right != 0.0)[:, None]
    entry, place = np.nonzero(is_moved.reshape(len(seen), -1))
    at_row, at_column = np.divmod(place, columns.shape[1])
    return seen[entry], place, left[entry, at_row] * right[entry, at_column]


def assemble(
    entries: Array,
    rows: NDArray[np.intp],
    entry: NDArray[np.intp],
    place: NDArray[np.intp],
    weight: Array,
    fixed: Array,
    out: Array,
) -> None:
    """Fill `out` (n, places) with fixed (places,) and the entries' shares.

    The shares are those of some rows (n,) of entries (..., m).
    """
    for i in range(len(rows)):
        for j in range(len(fixed)):
            out[i, j] = fixed[j]
        for j in range(len(entry)):
            out[i, place[j]] += weight[j] * entries[rows[i], entry[j]]


assemble = keep_file(kernel(OPTIONS)(assemble), Path(__file__))
