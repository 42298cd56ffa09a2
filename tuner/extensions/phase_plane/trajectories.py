"""Errors of loops and their rates, by flight."""

from typing import NamedTuple

import numpy as np

from tuner.analysis.responses import Responses

Array = np.ndarray
# Jump of a reference between two instants, as a share of its range, from which on it has no rate there.
JUMP = 0.05


class Trajectories(NamedTuple):
    """Errors and rates (flights, instants) of a loop, NaN where the reference jumps; unit: of the error."""

    signal: str
    unit: str
    error: Array
    rate: Array


def trajectories(responses: Responses) -> list[Trajectories]:
    """Return the trajectories of every signal that follows a reference."""
    loops = []
    for i, (signal, unit) in enumerate(zip(responses.signals, responses.units, strict=True)):
        reference, actual = responses.reference[..., i], responses.actual[..., i]
        if np.isnan(reference).all():
            continue
        error = reference - actual
        rate = np.gradient(error, responses.time, axis=1)
        broken = np.repeat(_jumps(reference[..., : error.shape[1]]), len(error) if len(reference) == 1 else 1, axis=0)
        loops.append(Trajectories(signal, unit, np.where(broken, np.nan, error), np.where(broken, np.nan, rate)))
    return loops


def _jumps(reference: Array) -> Array:
    """Return True (flights, instants) next to a jump of the reference."""
    size = np.ptp(reference, axis=1, keepdims=True)
    change = np.abs(np.diff(reference, axis=1))
    jumps = (change > JUMP * size) & (change > 0.0)
    edge = np.zeros((len(reference), 1), dtype=bool)
    return np.concatenate([jumps, edge], axis=1) | np.concatenate([edge, jumps], axis=1)
