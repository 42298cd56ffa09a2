"""Requested margins of one block of closed loops.

Each candidate and amplitude has a row.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from objectives.margins import classical, curve, disk, rejection, tracking
from objectives.margins.classical import MarginAt
from objectives.margins.frequency import SHARE, STABLE, Complex, Modes, modes_of, without_idle
from objectives.margins.linearise import LinearLoops
from objectives.margins.multiloop import multiloop_margin
from objectives.margins.quantities import LOOP_QUANTITIES
from plant.threads import parallel_map, shares

Array = NDArray[np.float64]
Fields = frozenset[str]
UNSTABLE = {entry.field: entry.unstable for entry in LOOP_QUANTITIES}
MULTILOOP = "multiloop"
EVERY: Fields = frozenset([*UNSTABLE, MULTILOOP])
"""Fields of `Margins` that can be asked for."""

# Quantities that need more than the commands' answers to signals injected, and those read where T is real or Re T = -1/2.
TRACKING = frozenset(["bandwidth", "load_index"])
REAL, LINE = frozenset(["gain_up", "gain_down"]), frozenset(["phase", "delay", "crossover"])


@dataclass(frozen=True)
class BlockReadings:
    """Margins of n loops of a block with k channels.

    modes; quantities: by field of `Margins`, value and frequency (n, k); together: disk margin (n,) in all those of its channels
    at once that are inputs of the plant, infinite where it was not asked for.
    """

    modes: Modes
    quantities: dict[str, MarginAt]
    together: MarginAt


def modes_of_loops(loops: LinearLoops, requested: Fields = EVERY) -> Modes:
    """Return the modes of loops a (n, b, b) with closed terms.

    They have the inputs and outputs that margins are read from.
    Unstable loops have no meaningful curve, only poles.
    """
    inputs, outputs = (slice(None), slice(None)) if requested & TRACKING else (loops.injected, loops.command)
    a = without_idle(loops.a, loops.b[..., loops.injected])
    return modes_of(a, loops.b[..., inputs], loops.c[..., outputs, :], radius=STABLE)


def read_block(
    loops: LinearLoops, grid: Array, h: float, skew: float, plant_inputs: list[int], requested: Fields = EVERY
) -> BlockReadings:
    """Read the margins of loops whose terms are closed, a (n, b, b).

    skew: of the disks, see `disk`; plant_inputs: which of the k channels are inputs of the plant.
    """
    return read_modes(modes_of_loops(loops, requested), loops, grid, h, skew, plant_inputs, requested)


def read_modes(
    modes: Modes, loops: LinearLoops, grid: Array, h: float, skew: float, plant_inputs: list[int], requested: Fields
) -> BlockReadings:
    """Read the margins of loops, see `read_block`, from their modes."""
    alone = requested | {"disk"} if MULTILOOP in requested else requested
    alone = alone | {"crossover"} if "group_delay" in requested else alone
    residues = modes.residues(loops.command, loops.injected)
    quantities = read_curves(modes, residues, grid, h, skew, alone)
    if "group_delay" in requested:
        crossover = quantities["crossover"].value
        quantities["group_delay"] = MarginAt(rejection.group_delay(modes, residues, crossover, h), crossover)
    if "rejection" in requested:
        wide = rejection.rejection_bandwidth(modes, residues, grid, h)
        quantities["rejection"] = MarginAt(wide, wide)
    if "bandwidth" in requested:
        wide = tracking.bandwidth(modes, modes.residues(loops.output, loops.reference), grid, h)
        quantities["bandwidth"] = MarginAt(wide, wide)
    if "load_index" in requested:
        index = tracking.load_index(modes, modes.residues(loops.error, loops.load), h)
        quantities["load_index"] = MarginAt(index, np.zeros_like(index))
    together = MarginAt(np.full(len(modes.size), np.inf), np.zeros(len(modes.size)))
    if MULTILOOP in requested and len(plant_inputs) > 1:
        together = multiloop_margin(modes, plant_inputs, grid, h, disk.center(skew))
    elif MULTILOOP in requested and plant_inputs:
        together = MarginAt(*[part[:, plant_inputs[0]] for part in quantities["disk"]])
    return BlockReadings(
        modes,
        {
            name: _or_unstable(at, modes.stable[:, None], UNSTABLE[name])
            for name, at in quantities.items()
            if name in requested
        },
        _or_unstable(together, modes.stable, UNSTABLE["disk"]),
    )


def read_curves(
    modes: Modes, residues: Complex, grid: Array, h: float, skew: float, requested: Fields = EVERY
) -> dict[str, MarginAt]:
    """Return the requested quantities (n, k) of the curves T of k loops.

    residues (n, k, b): of T.
    Of loops that are not stable it tells nothing.
    """
    n, k, size_b = residues.shape
    levels = {"sensitivity": 1.0, "complementary": 0.0, "disk": disk.center(skew)}
    levels = {name: level for name, level in levels.items() if name in requested}
    peaks, crossed = np.ones((n, k, len(levels), 2)), np.full((n, k, 2, size_b + 2, 2), np.nan)
    heights, stable = np.array(list(levels.values())), modes.stable

    def read(rows: slice) -> None:
        curve.read_all(
            grid,
            modes.poles[rows],
            residues[rows],
            stable[rows],
            h,
            heights,
            peaks[rows],
            crossed[rows],
            bool(requested & REAL),
            bool(requested & LINE),
        )

    parallel_map(read, shares(n, SHARE))
    margins = {name: MarginAt(peaks[..., j, 1], peaks[..., j, 0]) for j, name in enumerate(levels)}
    if "disk" in margins:
        margins["disk"] = MarginAt(1.0 / margins["disk"].value, margins["disk"].frequency)
    margins |= classical.read(crossed[:, :, curve.IMAGINARY], crossed[:, :, curve.REAL], requested)
    return {name: at for name, at in margins.items() if name in requested}


def _or_unstable(at: MarginAt, stable: NDArray[np.bool_], value: float) -> MarginAt:
    return MarginAt(np.where(stable, at.value, value), np.where(stable, at.frequency, 0.0))
