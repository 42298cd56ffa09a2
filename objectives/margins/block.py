"""All margins of one block of closed loops, one row for each candidate and amplitude."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from objectives.margins import classical, curve, disk, tracking
from objectives.margins.classical import At
from objectives.margins.frequency import Modes, modes_of, without_idle
from objectives.margins.linearise import LinearLoops
from objectives.margins.multiloop import multiloop_margin
from objectives.margins.quantities import LOOP_QUANTITIES

Array = NDArray[np.float64]
UNSTABLE = {entry.field: entry.unstable for entry in LOOP_QUANTITIES}


@dataclass(frozen=True)
class BlockReadings:
    """Margins of n loops of a block with k channels.

    modes; quantities: by field of `Margins`, value and frequency (n, k); together: disk margin (n,) in all those of its channels
    at once that are inputs of the plant.
    """

    modes: Modes
    quantities: dict[str, At]
    together: At


def read_block(loops: LinearLoops, grid: Array, h: float, skew: float, plant_inputs: list[int]) -> BlockReadings:
    """Read the margins of loops whose terms are closed, a (n, b, b).

    skew: of the disks, see `disk`; plant_inputs: which of the k channels are inputs of the plant.
    """
    modes = modes_of(without_idle(loops.a, loops.b[..., loops.injected]))
    b, c = loops.b[..., loops.injected], loops.c[..., loops.command, :]
    quantities = read_curves(modes, b, c, grid, h, skew)
    wide = tracking.bandwidth(modes, loops.b[..., loops.reference], loops.c[..., loops.output, :], grid, h)
    index = tracking.load_index(modes, loops.b[..., loops.load], loops.c[..., loops.error, :], h)
    quantities |= {"bandwidth": At(wide, wide), "load_index": At(index, np.zeros_like(index))}
    together = quantities["disk"]
    if len(plant_inputs) > 1:
        together = multiloop_margin(modes, b[..., plant_inputs], c[..., plant_inputs, :], grid, h, disk.centre(skew))
    elif plant_inputs:
        together = At(*[part[:, plant_inputs[0]] for part in together])
    else:
        together = At(np.full(len(modes.size), np.inf), np.zeros(len(modes.size)))
    return BlockReadings(
        modes,
        {name: _or_unstable(at, modes.stable[:, None], UNSTABLE[name]) for name, at in quantities.items()},
        _or_unstable(together, modes.stable, UNSTABLE["disk"]),
    )


def read_curves(modes: Modes, b: Array, c: Array, grid: Array, h: float, skew: float) -> dict[str, At]:
    """Return the quantities of the curves T of k loops, (n, k) each.

    b (n, b, k) leads from the injected, c (n, k, b) to the commanded signals.

    Of loops that are not stable it tells nothing.
    """
    n, size_b = modes.poles.shape
    k = b.shape[-1]
    peaks = np.ones((n, k, 3, 2))
    real, line = np.full((n, k, size_b + 2, 2), np.nan), np.full((n, k, size_b + 1, 2), np.nan)
    curve.read_all(grid, modes.poles, modes.residues(b, c), modes.stable, h, disk.centre(skew), peaks, real, line)
    up, down = classical.gain_margins(real)
    tops = [At(peaks[..., j, 1], peaks[..., j, 0]) for j in range(3)]
    crossover = classical.crossover(line)
    return {
        "gain_up": up,
        "gain_down": down,
        "phase": classical.phase_margin(line),
        "delay": classical.delay_margin(line),
        "sensitivity": tops[0],
        "complementary": tops[1],
        "disk": At(1.0 / tops[2].value, tops[2].frequency),
        "crossover": At(crossover, crossover),
    }


def _or_unstable(at: At, stable: NDArray[np.bool_], value: float) -> At:
    return At(np.where(stable, at.value, value), np.where(stable, at.frequency, 0.0))
