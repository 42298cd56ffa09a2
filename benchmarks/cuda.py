"""Closed-loop plant steps per second on a graphics card, and how far its flights are from those of the processor.

    python -m benchmarks.cuda --json

The full cascade (hybrid under ladrc, the quickstart's) with motor lag, noise, meters, RK4 at 1 kHz and control at 250 Hz, flights
of 10 s; a rate is the median of several rounds, from gains on the processor to results on the processor, scenarios on the card
already. `kernel` is the share of it that the card flew, by its own clock.

Recorded on an H200 in `benchmarks/results/cuda.json`: 1.5e10 steps/s in single and 3.0e9 in double precision. The assembled
instructions (sm_90: 668 a plant step and 369 a quarter of a control step in single precision) bound it by 2.8e10 and 1.5e10.
"""

import argparse
import json
import sys
from dataclasses import replace
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np

from objectives import meters
from plant.air.air import AirSpec
from plant.backends.flyer import FlightInputs, Flyer
from plant.law_registry import law
from plant.loop import MeterModel, Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import Limits, close_loop
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.scenarios import SEARCH, ScenarioSpec, sample_scenarios
from plant.references.steps import Steps
from tuner.extensions.cuda.card import card, missing
from tuner.extensions.cuda.flights import CudaFlyer
from tuner.extensions.cuda.kernel import BLOCK, BLOCKS, compiler, simulated

TIMING, LIMITS = Timing(0.004, 0.001), Limits(5.0, 0.17)
VEHICLE = load("hummingbird").vehicle
NOMINAL = nominal(VEHICLE, ControlOptions(), TIMING.control_period)
CASCADE = close_cascade(law("ladrc"), law("hybrid"))
LOOP = close_loop(CASCADE, MeterModel(meters.Meters, meters.start, meters.update))
# Candidates and scenarios that are flown on the processor too.
COMPARED = (2, 16)


def scenarios(count: int, seconds: float) -> FlightInputs:
    """Draw the scenarios of the benchmark."""
    spec = ScenarioSpec("bench", seconds, Steps(x=1.0, time=1.0), AirSpec(intensity="moderate", mean_wind=False))
    return sample_scenarios(spec, VEHICLE, TIMING, 1, SEARCH, range(count))


def candidates(count: int) -> np.ndarray:
    """Return gains rows around the default, one percent apart in all."""
    return np.array(default_row(CASCADE)) * np.linspace(0.995, 1.005, count)[:, None]


def measured(
    precision: str, inputs: FlightInputs, gains: np.ndarray, rounds: int, blocks: int | None
) -> dict[str, Any]:
    """Return the figures of one precision."""
    flyer = CudaFlyer(LOOP, LIMITS, TIMING, precision, blocks)
    begin = perf_counter()
    first = flyer.fly(gains[: COMPARED[0]], NOMINAL, inputs)
    compiled = perf_counter() - begin
    steps = len(gains) * inputs.count * len(inputs.references) * TIMING.steps
    seconds, on_card = [], []
    for _ in range(rounds):
        begin, before = perf_counter(), flyer.kernel_seconds
        flyer.fly(gains, NOMINAL, inputs)
        seconds.append(perf_counter() - begin)
        on_card.append(flyer.kernel_seconds - before)
    return {
        "steps_per_s": steps / median(seconds),
        "kernel_steps_per_s": steps / median(on_card),
        "first_flight_seconds": compiled,
        "blocks": blocks or BLOCKS[precision],
        "resident_flights": flyer.resident,
        **resources(flyer.kernel(inputs).run),
        "difference": difference(first, gains, inputs),
    }


def resources(run: Any) -> dict[str, int]:
    """Return registers and bytes of local memory of a thread."""
    return {
        "registers": max(run.get_regs_per_thread().values()),
        "local_bytes": max(run.get_local_mem_per_thread().values()),
    }


def difference(results: np.ndarray, gains: np.ndarray, inputs: FlightInputs) -> float:
    """Return the largest difference from the processor's flights, of each number or of 1 where it is smaller."""
    rows, flights = COMPARED
    head = first_block(inputs, flights)
    wanted = Flyer(LOOP, LIMITS, TIMING).fly(gains[:rows], NOMINAL, head)
    return float(np.max(np.abs(results[:, : head.count] - wanted) / np.maximum(np.abs(wanted), 1.0), axis=None))


def first_block(inputs: FlightInputs, flights: int) -> FlightInputs:
    """Return the first block of lanes, which holds so many scenarios or more."""
    count = min(flights, inputs.count)
    return replace(
        inputs,
        dynamics=inputs.dynamics[:1],
        starts=inputs.starts[:1],
        disturbances=inputs.disturbances[:1],
        noises=inputs.noises[:1],
        count=count,
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.cuda", description="Plant steps per second on the card."
    )
    parser.add_argument("--candidates", type=int, default=1024)
    parser.add_argument("--scenarios", type=int, default=256)
    parser.add_argument("--seconds", type=float, default=10.0, help="duration of a flight")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--blocks", type=int, help="blocks that shall fit a multiprocessor at once")
    parser.add_argument("--precision", choices=tuple(BLOCKS), action="append", help="both by default")
    parser.add_argument("--json", action="store_true", help="print figures as JSON and nothing else")
    asked = parser.parse_args()
    why = "the simulator is no card" if simulated() else missing()
    if why is not None:
        sys.exit(f"{why}; nothing was measured")
    inputs, gains = scenarios(asked.scenarios, asked.seconds), candidates(asked.candidates)
    here = card()
    figures: dict[str, Any] = {
        "command": " ".join(["python -m benchmarks.cuda", *sys.argv[1:]]),
        "card": here.name,
        "capability": f"{here.capability[0]}.{here.capability[1]}",
        "multiprocessors": here.processors,
        "cuda": f"{here.driver[0]}.{here.driver[1]}",
        "driver": here.release,
        "compiler": compiler(),
        "flights": asked.candidates * asked.scenarios,
        "flight_seconds": asked.seconds,
        "threads_a_block": BLOCK,
    }
    for precision in asked.precision or BLOCKS:
        figures[precision] = measured(precision, inputs, gains, asked.rounds, asked.blocks)
    if asked.json:
        print(json.dumps(figures, indent=2))
        return
    for key, value in figures.items():
        for name, entry in value.items() if isinstance(value, dict) else ((None, value),):
            label = key if name is None else f"{key} {name}"
            print(f"{label:32} {f'{entry:,.4g}' if isinstance(entry, float) else entry}")


if __name__ == "__main__":
    main()
