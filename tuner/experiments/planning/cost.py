"""Time, memory and disk of a run, from its counts and pilot.

The fixed parts are those of runs of the quickstart, measured on two shared x86 cores.
"""

from objectives.engine import keeps
from objectives.problem import chunk_size
from plant.backends.lane_layout import LANES
from tuner.documents.plan import PlannedSeconds, PlannedTail
from tuner.experiments.planning.counts import (
    CONFIRMED,
    flights_of,
    judged_at_most,
    scenario_flights,
    survivors_at_most,
)
from tuner.experiments.planning.pilot import Pilot
from tuner.experiments.tuning.finalist_limits import estimator, has_rare_limits
from tuner.search.initial_design import MAX_EXTRA_HYPERCUBES
from tuner.search.names import ALGORITHMS
from tuner.store.flights import GATHERED
from tuner.study.study import TuningStudy

# What a run takes besides its flights: interpreter and libraries, responses, figures and report.
FIXED_BYTES, FIXED_DISK, FIXED_SECONDS = 330e6, 1.9e6, 3.5
# What margins as requirements hold beside them.
MARGIN_BYTES = 250e6
# While a chunk is laid out in lanes its inputs stand in memory this many times more, and results while they are written.
LAYING_OUT, WRITING = 3, 4
NUMBER = 8
# A model takes so long to pick a candidate [s], and asks for so many margins: that of the quickstart, on one core.
MODEL_SECONDS, MODEL_ASKS = 0.010, 19


def seconds_of(study: TuningStudy, pilot: Pilot, compilation: float | None = None) -> PlannedSeconds:
    """Return the expected duration of a run; compilation [s]: None where the kernel was there."""
    spec = study.search
    # The first generation asks for further hypercubes until enough points are worth a flight.
    redrawn = (
        0.0
        if pilot.worthy_share == 1.0
        else min(MAX_EXTRA_HYPERCUBES, 1.0 / max(pilot.worthy_share, 1.0 / MAX_EXTRA_HYPERCUBES))
    )
    models = ALGORITHMS[spec.algorithm].screens
    requests = spec.population * (spec.generations * (MODEL_ASKS if models else 1) + redrawn)
    search, held_out = requests * pilot.screen_seconds + models * spec.candidates * MODEL_SECONDS, 0.0
    finalists = flights_of(study).finalists_at_most + 1
    for entry, flown in zip(study.scenarios, pilot.scenarios, strict=True):
        first = spec.flights_first(entry.search)
        times = 1 if keeps(first, entry.spec.steps(study.system.timing)) else spec.generations
        search += (times * first + entry.search - first) * flown.draw_seconds
        held_out += 2 * entry.held_out * flown.draw_seconds
        rounds = spec.generations * _rounds(spec.population, first, pilot.threads)
        rounds += _rounds(survivors_at_most(study), entry.search - first, pilot.threads)
        search += rounds * flown.block_seconds
        rounds = sum(_rounds(count, entry.held_out, pilot.threads) for count in (finalists, CONFIRMED))
        held_out += rounds * flown.block_seconds
    tails = sum(tail.points_at_most * tail.seconds for tail in planned_tails(study, pilot))
    return PlannedSeconds(
        compilation=compilation,
        search=search,
        held_out_at_most=held_out,
        tails_at_most=tails,
        writing=FIXED_SECONDS,
        total_at_most=search + held_out + tails + FIXED_SECONDS,
    )


def planned_tails(study: TuningStudy, pilot: Pilot) -> list[PlannedTail]:
    """Return the estimates of rare losses."""
    if not has_rare_limits(study):
        return []
    flights_per_second = {
        flown.spec.name: pilot.threads / (flown.draw_seconds + flown.block_seconds / LANES) for flown in pilot.scenarios
    }
    return estimator().planned(study, flights_per_second)


def _rounds(candidates: int, flights: int, threads: int) -> int:
    """Return the number of blocks per thread; a block is full of lanes even where there are fewer flights."""
    return -(-candidates // threads) * -(-flights // LANES)


def memory_of(study: TuningStudy, pilot: Pilot) -> float:
    """Return the largest memory that a run holds [bytes]."""
    candidates, held, largest, results = study.search.population, 0.0, 0.0, 0.0
    finalists = flights_of(study).finalists_at_most + 1
    for entry, flown in zip(study.scenarios, pilot.scenarios, strict=True):
        steps = entry.spec.steps(study.system.timing)
        for count, flying in ((entry.search, candidates), (entry.held_out, finalists), (entry.held_out, CONFIRMED)):
            held += flown.input_bytes * (count if keeps(count, steps) else 0)
            chunk = min(count, chunk_size(steps))
            largest = max(largest, flown.input_bytes * chunk)
            results = max(results, NUMBER * pilot.rows * flying * chunk)
    waiting = min(WRITING * results, WRITING * (GATHERED + results))
    margins = MARGIN_BYTES if study.table.margin else 0.0
    return FIXED_BYTES + margins + held + LAYING_OUT * largest + waiting


def disk_of(study: TuningStudy, pilot: Pilot) -> float:
    """Return the maximum size [bytes] of the results folder; every flight is stored, so that none is made twice."""
    judged = judged_at_most(flights_of(study).finalists_at_most)
    flights = sum(
        flown.stored_bytes * (scenario_flights(study, entry) + judged * entry.held_out)
        for entry, flown in zip(study.scenarios, pilot.scenarios, strict=True)
    )
    return FIXED_DISK + flights
