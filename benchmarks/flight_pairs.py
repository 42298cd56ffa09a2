"""`python -m benchmarks.flight_pairs`: how often two flights of a vehicle are said to contradict each other.

Logs are those of `benchmarks.identification`: two flights of the same vehicle, and two between which its propellers have lost
thrust. `--crazyflie FOLDER` takes the flights log10 and log15 of a real vehicle (Eschmann, Albani and Loianno, arXiv 2404.07837)
in pieces, too, and counts differences beyond 1.96 standard deviations, without and with the scatter between them.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.identification import BATCH, DURATION, QUANTILE, log_of, prior_of
from benchmarks.measuring import RESULTS, machine, write_json
from plant.errors import InputError
from plant.quadrotor.airframes import load
from tests.tuner.extensions.identification.independent_flights import Recording, Truth, draw_truths, fly
from tuner.extensions.identification.identify import identify_vehicle
from tuner.extensions.logs.reading import read_log
from tuner.extensions.vehicle_fit.random_effects import FlightEstimate, between_flight_std
from tuner.store.environment import commit

FIRST_SEED, LOST_THRUST, PIECE = 60, 0.15, 10.0
"""Seed of the first batch of vehicles; share of the thrust that worn propellers lose; length of a piece of a real log [s]."""
SPANS = {"log10": (35.0, 45.0, 55.0), "log15": (55.0, 65.0, 75.0, 85.0)}
"""Begins of the pieces [s]: where the authors used the logs."""


def probability_of(first: Recording, second: Recording, truth: Truth, seed: int, i: int) -> float | None:
    """Return the probability of the test of two flights; None where a log is refused."""
    prior = prior_of(truth, i, np.random.default_rng((seed, i, 5)))
    logs = [log_of(first, i), replace(log_of(second, i), name="second", digest="f" * 64)]
    try:
        return identify_vehicle(logs, prior).tests[0].probability
    except InputError:
        return None


def rejected_shares(count: int, processes: int) -> dict[str, Any]:
    """Return the shares of rejected pairs at 1 %: of the same vehicle, and of one whose propellers are worn."""
    probabilities: dict[str, list[float]] = {"same": [], "worn": []}
    with ProcessPoolExecutor(processes) as pool:
        for batch in range(-(-count // BATCH)):
            seed = FIRST_SEED + batch
            truth = draw_truths(np.random.default_rng(seed), BATCH)
            worn = truth._replace(full=(1.0 - LOST_THRUST) * truth.full)
            first = fly(truth, DURATION, seed)
            for kind, vehicle in (("same", truth), ("worn", worn)):
                each = partial(probability_of, first, fly(vehicle, DURATION, seed + 1000), truth, seed)
                tried = pool.map(each, range(min(BATCH, count - batch * BATCH)))
                probabilities[kind] += [entry for entry in tried if entry is not None]
                print(f"{kind}: {len(probabilities[kind])} of {count}", flush=True)
    return {
        kind: {
            "pairs": len(values),
            "rejected": sum(value < 0.01 for value in values),
            "below_5_per_cent": sum(value < 0.05 for value in values),
        }
        for kind, values in probabilities.items()
    }


def beyond(pairs: list[tuple[FlightEstimate, FlightEstimate]], scatter: dict[str, float]) -> dict[str, Any]:
    """Return the number of differences in pairs of flights, and the share beyond 1.96 standard deviations."""
    distances = []
    for one, other in pairs:
        for name in set(one.names) & set(other.names):
            i, k = one.names.index(name), other.names.index(name)
            variance = one.covariance[i, i] + other.covariance[k, k] + 2.0 * scatter.get(name, 0.0) ** 2
            distances.append((one.point[i] - other.point[k]) / np.sqrt(variance))
    return {"differences": len(distances), "beyond": float(np.mean(np.abs(distances) > QUANTILE))}


def real_pairs(folder: Path) -> dict[str, Any]:
    """Return the shares of differences beyond 1.96 within and between two real flights in pieces."""
    logs = {name: read_log(folder / name) for name in SPANS}
    pieces = [logs[name].between(begin, begin + PIECE) for name, begins in SPANS.items() for begin in begins]
    flights = identify_vehicle(pieces, load("crazyflie-pybullet")).flights
    owner = [name for name, begins in SPANS.items() for _ in begins]
    pairs = {
        kind: [
            (flights[i], flights[k])
            for i, k in combinations(range(len(flights)), 2)
            if (owner[i] == owner[k]) is is_same
        ]
        for kind, is_same in (("within", True), ("between", False))
    }
    scatter = between_flight_std(flights)
    return {
        "within": beyond(pairs["within"], {}),
        "between": beyond(pairs["between"], {}),
        "between_with_scatter": beyond(pairs["between"], scatter),
        "test_of_both": identify_vehicle(
            [logs["log10"].between(35.0, 65.0), logs["log15"].between(55.0, 90.0)], load("crazyflie-pybullet")
        )
        .tests[0]
        ._asdict(),
    }


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pairs", type=int, default=60, help="number of vehicles, two flights of each kind")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--crazyflie", type=Path, help="folder with log10 and log15")
    chosen = parser.parse_args()
    result = {"machine": machine(), "revision": commit(), **rejected_shares(chosen.pairs, chosen.processes)}
    if chosen.crazyflie is not None:
        result["crazyflie"] = real_pairs(chosen.crazyflie)
    write_json(RESULTS / "flight_pairs.json", result)
    print(result)


if __name__ == "__main__":
    main()
