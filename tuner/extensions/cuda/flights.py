"""Fly many candidates through many scenarios on a graphics card; see `plant.backends.flyer` for the processor.

The bits of a flight depend on its gains and its scenario, on the card's kind and on the compilers, not on its thread, block or
launch: threads share nothing and nothing is summed across flights.

Scenarios stay on the card until others need the room. Copying them there is not overlapped with flying: 256 flights of 10 s are
77 MB, some milliseconds on the bus, and drawing them takes the processor a hundred times as long.
"""

import warnings
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from plant.backends import array
from plant.backends.flyer import FlightInputs
from plant.backends.lane_layout import result_rows
from plant.loop import ClosedLoop, Timing
from plant.records import flatten, pack
from tuner.extensions.cuda.card import card, free_memory
from tuner.extensions.cuda.kernel import BLOCK, BLOCKS, REALS, CudaKernel, kernel_of

# Flights of a launch at most: some waves of a large card, a second of its time; and share of the free memory for its results.
LARGEST_LAUNCH, RESULTS_SHARE = 2**18, 0.5
# Scenarios that stay on the card, as a share of what was free before them and in bytes: their source stays on the processor.
SCENARIOS_SHARE, SCENARIOS_BYTES = 0.25, 1e9


@dataclass(frozen=True)
class CardInputs:
    """Scenarios on the card, the scenario as the last axis.

    dynamics and starts (rows, scenarios); disturbances and noises (K, rows, scenarios); references (K, 14);
    source: where they came from.
    """

    dynamics: Any
    starts: Any
    disturbances: Any
    noises: Any
    references: Any
    source: FlightInputs

    @property
    def bytes(self) -> int:
        """Size on the card."""
        return sum(getattr(self, entry.name).nbytes for entry in fields(self) if entry.name != "source")


def by_scenario(blocks: np.ndarray, count: int) -> np.ndarray:
    """Turn blocks of lanes (blocks, ..., lanes) into (..., scenarios), without padding."""
    moved = np.moveaxis(blocks, 0, -2)
    return moved.reshape(*moved.shape[:-2], blocks.shape[0] * blocks.shape[-1])[..., :count]


def launcher(run: Any, flights: int) -> Any:
    """Return the launcher of a kernel: no warning of launches that do not fill a card."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*Grid size")  # Numba may begin it with a colour.
        return run[-(-flights // BLOCK), BLOCK]


class CudaFlyer:
    """A closed loop compiled for the card. precision: float64 or float32; blocks: see `tuner.extensions.cuda.kernel`.

    rows: of a flight's result. resident: flights that the card works on at once. kernel_seconds: that the card has flown.
    fly(gains (candidates, n), nominal, inputs) -> results (candidates, scenarios, rows) in float64, as `Flyer`
    has them.
    """

    def __init__(
        self, loop: ClosedLoop, limits: Any, timing: Timing, precision: str, blocks: int | None = None
    ) -> None:
        self.loop, self.precision = loop, precision
        self.card = card()
        self._blocks = blocks or BLOCKS[precision]
        self.resident = self.card.processors * self._blocks * BLOCK
        rows = result_rows(loop)
        self.rows = rows.stop - rows.start
        self.kernel_seconds = 0.0
        self._real = REALS[precision]
        self._limits, self._timing = self._record(loop.records.Limits, limits), timing
        self._prepare = array.rebinder()(loop.prepare)
        self._kernels: dict[tuple[int, int], CudaKernel] = {}
        self._on_card: OrderedDict[int, CardInputs] = OrderedDict()

    def kernel(self, inputs: FlightInputs) -> CudaKernel:
        """Return the kernel for scenarios like these."""
        rows = (inputs.disturbances.shape[2], inputs.noises.shape[2])
        if rows not in self._kernels:
            self._kernels[rows] = kernel_of(self.loop, *rows, self.precision, self._blocks)
        return self._kernels[rows]

    def fly(
        self,
        gains: np.ndarray,
        nominal: Any,
        inputs: FlightInputs,
        on_flights_done: Callable[[int], None] | None = None,
    ) -> np.ndarray:
        """Fly every candidate through every scenario; on_flights_done(n) is called as n more flights end."""
        kinds = self.loop.records
        kernel, on_card = self.kernel(inputs), self._inputs(inputs)
        shared = self._record(kinds.Nominal, nominal), self._record(kinds.Targets, inputs.targets)
        out = np.empty((len(gains), inputs.count, self.rows))
        each = self._candidates(inputs.count)
        for first in range(0, len(gains), each):
            part = slice(first, first + each)
            out[part] = self._launch(kernel, gains[part], shared, on_card).reshape(-1, inputs.count, self.rows)
            if on_flights_done is not None:
                on_flights_done(len(gains[part]) * inputs.count)
        return out

    def constants(self, gains: np.ndarray) -> np.ndarray:
        """Return the law constants (candidates, n) of gains (candidates, g), worked out in double precision."""
        with np.errstate(all="ignore"):
            record = self._prepare(pack(self.loop.records.Gains, gains.T), self._timing.control_period)
        columns = [np.broadcast_to(leaf, len(gains)) for leaf in flatten(record)]
        return np.ascontiguousarray(np.stack(columns, axis=1), dtype=self._real)

    def _launch(self, kernel: CudaKernel, gains: np.ndarray, shared: tuple[Any, Any], inputs: CardInputs) -> np.ndarray:
        from numba import cuda

        nominal, targets = shared
        control_period, plant_step = self._timing
        flights = len(gains) * inputs.source.count
        constants = cuda.to_device(self.constants(gains))
        out = cuda.device_array((flights, self.rows), dtype=self._real)  # pyright: ignore[reportArgumentType]
        begin, end = cuda.event(), cuda.event()
        begin.record()
        launcher(kernel.run, flights)(
            constants,
            nominal,
            inputs.dynamics,
            inputs.starts,
            inputs.disturbances,
            inputs.noises,
            inputs.references,
            targets,
            self._limits,
            self._real(control_period),
            self._real(plant_step),
            np.int32(self._timing.steps),
            out,
        )
        end.record()
        results = out.copy_to_host()
        self.kernel_seconds += 1e-3 * begin.elapsed_time(end)
        return results

    def _candidates(self, scenarios: int) -> int:
        """Return the number of candidates of one launch."""
        room = RESULTS_SHARE * free_memory() / (self.rows * np.dtype(self._real).itemsize)
        return max(int(min(room, LARGEST_LAUNCH)) // scenarios, 1)

    def _inputs(self, inputs: FlightInputs) -> CardInputs:
        """Return scenarios on the card; those that were not flown for longest make room."""
        on_card = self._on_card.pop(id(inputs), None)
        if on_card is None:
            on_card = self._copied(inputs)
        self._on_card[id(inputs)] = on_card
        held = sum(entry.bytes for entry in self._on_card.values())
        most = min(SCENARIOS_SHARE * (free_memory() + held), SCENARIOS_BYTES)
        while len(self._on_card) > 1 and held > most:
            held -= self._on_card.popitem(last=False)[1].bytes
        return on_card

    def _copied(self, inputs: FlightInputs) -> CardInputs:
        from numba import cuda

        def copied(values: np.ndarray) -> Any:
            # No kernel reads an empty array, but every argument needs an address.
            filled = values if values.size else np.zeros((1,) * values.ndim)
            return cuda.to_device(np.ascontiguousarray(filled, dtype=self._real))

        air, noise = (
            copied(by_scenario(inputs.disturbances, inputs.count)),
            copied(by_scenario(inputs.noises, inputs.count)),
        )
        return CardInputs(
            copied(by_scenario(inputs.dynamics, inputs.count)),
            copied(by_scenario(inputs.starts, inputs.count)),
            air,
            noise,
            copied(inputs.references),
            inputs,
        )

    def _record(self, kind: Any, record: Any) -> Any:
        return pack(kind, [self._real(leaf) for leaf in flatten(record)])
