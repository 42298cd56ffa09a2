"""`tuner bench`: closed-loop plant steps per second of the backends, measured side by side in one run, flights, time of margins.

The full hybrid cascade with motor lag, noise, metrics, RK4 at 1 kHz and control at 250 Hz, flights of 10 s. Backends are measured
in turn, and the median of several rounds is reported: compare ratios. Flights per second are those of the lanes with a study's
default plant step. Margins are the quickstart's limits in all six channels for gains from their search ranges, by processor time
on one thread. A candidate of the quickstart costs one evaluation of margins and 8 flights of 8 s.
"""

from collections.abc import Callable
from dataclasses import replace
from statistics import median
from time import perf_counter, process_time
from typing import Any

import numpy as np

from objectives import meters
from objectives.margins.frequency import POINTS
from objectives.margins.margins import MarginModel
from objectives.margins.quantities import LIMITABLE
from objectives.margins.requirement import MarginRequirement
from objectives.margins.trim import Trim
from objectives.requirements import Screen, known_values, worst_value
from plant.air.air import AirSpec
from plant.backends.array import rebinder as numpy_rebinder
from plant.backends.flyer import FlightInputs, Flyer
from plant.backends.stepping import Inputs, fly_steps
from plant.law_registry import law
from plant.loop import MeterModel, Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import AXES, close_cascade
from plant.quadrotor.closed_loop import CascadeLoop, Limits, close_loop
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions, Nominal, nominal
from plant.quadrotor.scenarios import SEARCH, ScenarioSpec, sample_scenarios
from plant.records import flatten, pack
from plant.references.steps import Steps
from plant.seeds import generator
from plant.threads import available_threads, threads_used, use_threads
from plant.vectors import Vec3
from tuner.extensions.bench.scalar import scalar_kernel
from tuner.gains.ranges import usual_timing
from tuner.store.environment import simd

DURATION, SCENARIOS, ROUNDS = 10.0, 64, 3
# NumPy needs many flights at once to hide its call overhead, and few steps because it is slow; its speed does not depend on
# the length of the flight.
NUMPY_FLIGHTS, NUMPY_DURATION = 1024, 0.2
# The scalar kernel flies a share of the flights, enough for a second or so.
SCALAR_SHARE = 4
# Candidates whose margins are worked out at once, and what a candidate of the quickstart flies.
MARGIN_BATCH, QUICKSTART_FLIGHTS, QUICKSTART_DURATION = 1000, 8, 8.0
# What a search that asks for a few candidates at a time has worked out at once.
SMALL_BATCH = 32
# Limits of the quickstart, each in the unit of its limits.
QUICKSTART_LIMITS = {"phase_margin": 35.0, "gain_margin": 6.0, "ms": 2.0, "delay_periods": 2.0}


def bench(flights: int, threads: int | None = None) -> dict[str, float | str]:
    """Return steps per second of lanes, scalar (one flight at a time, same functions and threads) and numpy; margins."""
    timing, limits = Timing(0.004, 0.001), Limits(5.0, 0.17)
    vehicle = load("hummingbird").vehicle
    knowledge = nominal(vehicle, ControlOptions(), timing.control_period)
    cascade = close_cascade(law("hybrid"), law("hybrid"))
    loop = close_loop(cascade, MeterModel(meters.Meters, meters.start, meters.update))
    spec = ScenarioSpec("bench", DURATION, Steps(x=1.0, time=1.0), AirSpec(intensity="moderate", mean_wind=False))
    inputs = sample_scenarios(spec, vehicle, timing, 1, SEARCH, range(SCENARIOS))
    count = threads or available_threads()
    gains = np.tile(np.array(default_row(cascade)), (max(1, flights // SCENARIOS), 1))
    steps = len(inputs.references) * timing.steps
    flyer = Flyer(loop, limits, timing, count)
    scalar = scalar_kernel(loop)

    def lanes() -> float:
        return _rate(lambda: flyer.fly(gains, knowledge, inputs), len(gains) * SCENARIOS * steps)

    def flights_a_second() -> float:
        usual = flyer.at(usual_timing(timing.control_period, load("hummingbird")))
        return _rate(lambda: usual.fly(gains, knowledge, inputs), len(gains) * SCENARIOS)

    def one_by_one() -> float:
        few = gains[: max(1, len(gains) // SCALAR_SHARE)]
        return _rate(lambda: scalar.fly(few, knowledge, inputs, limits, timing, count), len(few) * SCENARIOS * steps)

    def arrays() -> float:
        return _numpy_rate(loop, gains[0], knowledge, spec, limits, timing)

    margins = MarginBench()
    flyer.fly(gains[:1], knowledge, _head(inputs, 2))
    scalar.fly(gains[:1], knowledge, _head(inputs, 2), limits, timing, count)
    rounds = [(lanes(), one_by_one(), arrays(), margins.wall(), flights_a_second()) for _ in range(ROUNDS)]
    lanes_rate, scalar_rate, numpy_rate, _, flights_rate = (median(column) for column in zip(*rounds, strict=True))
    quickstart_flights = QUICKSTART_FLIGHTS * QUICKSTART_DURATION / DURATION
    return {
        "lanes_steps_per_s": lanes_rate,
        "lanes_flights_per_s": flights_rate,
        "scalar_steps_per_s": scalar_rate,
        "numpy_steps_per_s": numpy_rate,
        "threads": count,
        "simd": simd(),
        "flights": len(gains) * SCENARIOS,
        "flight_seconds": DURATION,
        "lanes_per_thread_steps_per_s": lanes_rate / count,
        "lanes_over_scalar": median(entry[0] / entry[1] for entry in rounds),
        "lanes_per_thread_over_numpy": median(entry[0] / count / entry[2] for entry in rounds),
        **margins.figures(),
        "margins_over_flights": median(entry[3] * entry[4] / quickstart_flights for entry in rounds),
    }


# Mean wind of the quickstart [m/s], from two directions, in which a search judges what keeps its limits at hover.
WIND = 8.5


class MarginBench:
    """Times margins of a batch of candidates; made once, because CasADi takes a moment to build the model."""

    def __init__(self) -> None:
        timing, vehicle = Timing(0.004, 0.001), load("hummingbird").vehicle
        cascade = close_cascade(law("ladrc"), law("hybrid"))
        begin = perf_counter()
        knowledge = nominal(vehicle, ControlOptions(delay=True), timing.control_period)
        self._model = MarginModel(cascade, knowledge, timing, vehicle)
        self._build_seconds = perf_counter() - begin
        winds = (Vec3(WIND, 0.0, 0.0), Vec3(0.0, WIND, 0.0))
        self._trimmed = [MarginModel(cascade, knowledge, timing, vehicle, Trim(wind=wind)) for wind in winds]
        addresses = gain_addresses(cascade)
        spans = [gain.span for gain in addresses]
        low, high = (np.array([getattr(span, end) for span in spans]) for end in ("low", "high"))
        draws = generator(1, "bench/margins", 0).uniform(size=(MARGIN_BATCH, len(spans)))
        self._gains = low + draws * (high - low)
        # One value for all axes of a loop, as in the quickstart: then y is x and pitch is roll, turned.
        first = {(gain.loop, gain.info.name): gain.column for gain in reversed(addresses)}
        self._shared = self._gains[:, [first[gain.loop, gain.info.name] for gain in addresses]]
        self._limits = [MarginRequirement(LIMITABLE[name], name, AXES, at) for name, at in QUICKSTART_LIMITS.items()]
        stable = self._model.evaluate(self._shared).stable.all(axis=1)
        self._stable = np.resize(self._shared[stable], self._shared.shape)
        self._model.limited(self._shared[:2], self._limits)

    def wall(self) -> float:
        """Return wall seconds a candidate, gains shared."""
        begin = perf_counter()
        self._model.limited(self._shared, self._limits)
        return (perf_counter() - begin) / MARGIN_BATCH

    def figures(self) -> dict[str, float | int]:
        """Return processor milliseconds a candidate.

        With gains shared by the axes of a loop and with own gains for each axis, of stable loops alone, in small batches and one
        by one, and for every quantity in place of those limited.
        """

        def limited(gains: np.ndarray) -> np.ndarray:
            return self._model.limited(gains, self._limits)

        requirements = tuple(limit.requirement for limit in self._limits)

        def in_trims(gains: np.ndarray) -> np.ndarray:
            return worst_value(requirements, np.stack([at.limited(gains, self._limits) for at in self._trimmed]))

        screens = (Screen(requirements, limited, in_trims),)
        few = self._shared[: 4 * SMALL_BATCH]
        return {
            "margins_ms_per_candidate": _busy(limited, self._shared, MARGIN_BATCH),
            "margins_ms_per_candidate_with_trims": _busy(
                lambda gains: known_values(screens, gains), self._shared, MARGIN_BATCH
            ),
            "margins_ms_per_candidate_own_gains": _busy(limited, self._gains, MARGIN_BATCH),
            "margins_ms_per_candidate_stable": _busy(limited, self._stable, MARGIN_BATCH),
            f"margins_ms_per_candidate_by_{SMALL_BATCH}": _busy(limited, few, SMALL_BATCH),
            "margins_ms_per_candidate_one_by_one": _busy(limited, few, 1),
            "margins_ms_per_candidate_every_quantity": _busy(self._model.evaluate, few, len(few)),
            "margins_batch": MARGIN_BATCH,
            "margins_frequencies": POINTS,
            "margins_amplitudes": len(self._model.cases),
            "margins_build_seconds": self._build_seconds,
        }


def _busy(work: Callable[[np.ndarray], Any], gains: np.ndarray, batch: int) -> float:
    """Return processor milliseconds per candidate of work on gains (n, g): in batches, on one thread."""

    def once() -> float:
        begin = process_time()
        for i in range(0, len(gains), batch):
            work(gains[i : i + batch])
        return 1e3 * (process_time() - begin) / len(gains)

    usual = threads_used()
    use_threads(1)
    try:
        return median(once() for _ in range(ROUNDS))
    finally:
        use_threads(usual)


def _rate(work: Any, count: int) -> float:
    begin = perf_counter()
    work()
    return count / (perf_counter() - begin)


def _head(inputs: FlightInputs, steps: int) -> FlightInputs:
    return replace(
        inputs,
        disturbances=np.ascontiguousarray(inputs.disturbances[:, :steps]),
        noises=np.ascontiguousarray(inputs.noises[:, :steps]),
        references=inputs.references[:steps],
    )


def _numpy_rate(
    loop: CascadeLoop, gains: np.ndarray, knowledge: Nominal, spec: ScenarioSpec, limits: Limits, timing: Timing
) -> float:
    """Return plant steps per second of the numpy backend: over many flights at once, on one thread."""
    vehicle = knowledge.vehicle
    short = ScenarioSpec("bench", NUMPY_DURATION, spec.reference.__class__(x=1.0, time=0.1), spec.air)  # pyright: ignore[reportCallIssue]
    blocks = sample_scenarios(short, vehicle, timing, 1, SEARCH, range(NUMPY_FLIGHTS))
    flat = Inputs(
        np.concatenate(list(blocks.dynamics), axis=-1),
        np.concatenate(list(blocks.starts), axis=-1),
        np.concatenate(list(blocks.disturbances), axis=-1),
        np.concatenate(list(blocks.noises), axis=-1),
        blocks.references,
    )
    record = pack(loop.cascade.Gains, gains.tolist())
    steps = NUMPY_FLIGHTS * len(blocks.references) * timing.steps
    bind = numpy_rebinder()
    assert len(flatten(record)) == len(gains)
    with np.errstate(all="ignore"):
        return _rate(lambda: fly_steps(loop, bind, record, knowledge, flat, blocks.targets, limits, timing), steps)
