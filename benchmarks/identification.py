"""`python -m benchmarks.identification`: how often intervals of identified vehicles hold the truth.

Two simulators that share no code with the product make the logs. That of `independent_flights.py` flies
vehicles of 20 g to 7 kg whose rotors lose thrust to inflow and whose thrust goes with the 1.5th to second power of their speed,
gyros with second-order low-passes and colored noise, gusts, sagging batteries, centers of mass off the middle. RotorPy, of the
clients' environment (`rotorpy_flights.py`), flies vehicles of 30 g to 6 kg in gusts, with colored noise and centers of mass off
the middle. Priors are as far from the truth as people know a vehicle beforehand. Bands are those of predictions over windows of
half a second that the fit did not use.
"""

import argparse
import json
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import count, islice
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from benchmarks.measuring import RESULTS, machine, write_json
from plant.errors import InputError
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Rotors, Vec3
from tests.tuner.extensions.identification.independent_flights import (
    EVERY,
    GRAVITY,
    STEP,
    Recording,
    Truth,
    draw_truths,
    fly,
)
from tests.tuner.extensions.identification.known_flights import AIRFRAME, distances
from tests.tuner.extensions.identification.rotorpy_flights import SPIN, fly_rotorpy, is_installed
from tuner.extensions.identification.identify import identify_vehicle
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.vehicle_fit.random_effects import QUANTILE
from tuner.extensions.vehicle_fit.samples import OUTPUTS
from tuner.store.environment import commit

BATCH, DURATION = 20, 20.0
"""Vehicles that fly side by side, and length of a log [s]."""
DAMPING = 1.4
"""Twice the damping of the gyros' low-passes."""


class Outcome(NamedTuple):
    """An identification: by number, distance from the truth and half width of the interval, and the unidentified numbers.

    bands: shares of what was measured that the bands of the outputs hold.
    """

    distance: dict[str, float]
    half_width: dict[str, float]
    unidentified: list[str]
    bands: list[float] = []


def prior_of(truth: Truth, i: int, draw: np.random.Generator) -> Airframe:
    """Return the prior of a vehicle: mass and lengths to 2 %, the rest to 8 to 50 %."""

    def about(value: float, deviation: float) -> float:
        return float(value * np.exp(deviation * draw.normal()))

    inertia = truth.inertia[:, i]
    mass, lever = about(truth.mass[i], 0.02), about(truth.lever[i], 0.02)
    x, y = about(inertia[0], 0.3), about(inertia[1], 0.3)
    share = min(about(inertia[2] / (inertia[0] + inertia[1]), 0.08), 0.98)
    full, speed, lag = about(truth.full[i], 0.2), about(truth.speed[i], 0.1), about(truth.lag_up[i], 0.5)
    climb = 4.0 * truth.inflow[i]
    damping = about(climb * lever**2, 0.5)
    vehicle = AIRFRAME.vehicle._replace(
        mass=mass,
        inertia=Vec3(x, y, share * (x + y)),
        rotor_x=Rotors(lever, lever, -lever, -lever),
        rotor_y=Rotors(lever, -lever, lever, -lever),
        spin=Rotors(-1.0, 1.0, 1.0, -1.0),
        thrust_coefficient=full / speed**2,
        speed_max=speed,
        torque_ratio=about(truth.torque_ratio[i], 0.3),
        rotor_inertia=about(truth.rotor_inertia[i], 0.3),
        lag_up=lag,
        lag_down=1.2 * lag,
        drag_linear=Vec3(truth.side[i], truth.side[i], about(climb, 0.5)),
        drag_quadratic=Vec3(0.0, 0.0, 0.0),
        rate_damping=Vec3(damping, damping, 0.0),
        gravity=GRAVITY,
    )
    return replace(AIRFRAME, vehicle=vehicle)


def numbers_of(truth: Truth, i: int, prior: Vehicle) -> dict[str, float]:
    """Return the true numbers of a vehicle by the names of the coordinates."""
    inertia, exponent, full = truth.inertia[:, i], truth.exponent[i], truth.full[i]
    numbers = {
        "mass": truth.mass[i],
        "arm": truth.lever[i] / prior.rotor_x.r1,
        "inertia.x": inertia[0],
        "inertia.y": inertia[1],
        "inertia_share": inertia[2] / (inertia[0] + inertia[1]),
        **{f"thrust.{100 * u:.0f}": full * u**exponent for u in (0.3, 0.65, 1.0)},
        "lag_up": truth.lag_up[i],
        "lag_down": truth.lag_down[i],
        "dead_time": STEP * truth.late[i],
        "centre.x": truth.center[0, i],
        "centre.y": truth.center[1, i],
        "torque_ratio": truth.torque_ratio[i],
        "drag_linear.z": 4.0 * truth.inflow[i] + 0.2 * truth.side[i],
        "rate_damping": 4.0 * truth.inflow[i] * truth.lever[i] ** 2,
    }
    if truth.rotor_inertia[i] > 0.0:
        # The product's rotors turn as fast as its own thrust coefficient asks.
        factor = truth.rotor_inertia[i] / prior.rotor_inertia
        numbers["rotor_inertia"] = factor * truth.speed[i] / np.sqrt(full / prior.thrust_coefficient)
    if np.isfinite(truth.cutoff[i]):
        numbers["gyro_delay"] = DAMPING / (2.0 * np.pi * truth.cutoff[i])
    return numbers


def log_of(recording: Recording, i: int) -> FlightLog:
    """Return the log of a vehicle."""
    time = np.asarray(STEP * EVERY * np.arange(len(recording.rates)), np.float64)
    columns = (recording.rates[:, :, i], recording.force[:, :, i], recording.commands[:, :, i])
    return FlightLog(f"log {i}", "made", f"{i}".rjust(64, "0"), time, *columns)


def identify_log(recording: Recording, truth: Truth, seed: int, i: int) -> Outcome | None:
    """Identify a vehicle from its log; None where the log is refused."""
    return identify_from(recording, truth, i, prior_of(truth, i, np.random.default_rng((seed, i, 5))))


def identify_rotorpy_log(folder: str, duration: float, seed: int) -> Outcome | None:
    """Identify the vehicle of a seed from its log by RotorPy; None where the log is refused."""
    recording, truth = fly_rotorpy(folder, duration, seed)
    prior = prior_of(truth, 0, np.random.default_rng((seed, 6)))
    prior = replace(prior, vehicle=prior.vehicle._replace(spin=Rotors(*SPIN)))
    return identify_from(recording, truth, 0, prior)


def identify_from(recording: Recording, truth: Truth, i: int, prior: Airframe) -> Outcome | None:
    """Identify a vehicle from its log and a prior; None where the log is refused."""
    try:
        found = identify_vehicle([log_of(recording, i)], prior)
    except InputError:
        return None
    true = numbers_of(truth, i, prior.vehicle)
    deviations = dict(zip(found.space.names, np.sqrt(np.diag(found.fit.covariance)).tolist(), strict=True))
    widths = {name: QUANTILE * deviations[name] for name in true}
    unidentified = sorted(found.reasons | found.wider)
    return Outcome(distances(found, true), widths, unidentified, found.validation.covered.tolist())


def table_of(outcomes: list[Outcome]) -> list[dict[str, Any]]:
    """Return a row for each number and one for all: shares of intervals that hold the truth, and median half widths."""
    rows = []
    for name in outcomes[0].distance:
        held = np.array([abs(entry.distance[name]) <= QUANTILE for entry in outcomes])
        identified = np.array([name not in entry.unidentified for entry in outcomes])
        rows.append(
            {
                "number": name,
                "covered": float(held.mean()),
                "identified": float(identified.mean()),
                "covered_of_identified": float(held[identified].mean()) if identified.any() else None,
                "median_half_width": float(np.median([entry.half_width[name] for entry in outcomes])),
            }
        )
    return rows


def markdown(
    rows: list[dict[str, Any]], logs: int, refused: int, bands: list[float], duration: float = DURATION
) -> str:
    """Return the table of a simulator as text."""
    total = float(np.mean([row["covered"] for row in rows]))
    lines = [
        f"{logs} logs of {duration:g} s of as many vehicles, {refused} refused for they tell nothing: {100 * total:.1f} % of the "
        "95 % intervals of the others hold the truth.",
        "",
        "| number | intervals that hold it | identified in | of these, hold it | median half width (relative; s, m) |",
        "|---|---:|---:|---:|---:|",
    ]
    for row in rows:
        of_identified = "" if row["covered_of_identified"] is None else f"{100 * row['covered_of_identified']:.0f} %"
        lines.append(
            f"| `{row['number']}` | {100 * row['covered']:.0f} % | {100 * row['identified']:.0f} % | {of_identified} "
            f"| {row['median_half_width']:.2g} |"
        )
    lines += [f"| band of {name} | {100 * share:.1f} % | | | |" for name, share in zip(OUTPUTS, bands, strict=False)]
    return "\n".join(lines) + "\n"


def identify_independent(pool: ProcessPoolExecutor, logs: int, duration: float, first: int) -> Iterator[Outcome | None]:
    """Identify vehicles of `independent_flights.py`, of seeds from a first one on."""
    for seed in range(first, first + -(-logs // BATCH)):
        truth = draw_truths(np.random.default_rng(seed), BATCH)
        identify = partial(identify_log, fly(truth, duration, seed), truth, seed)
        yield from pool.map(identify, range(min(BATCH, logs - BATCH * (seed - first))))


def rotorpy_seeds(first: int, low: float, high: float) -> Iterator[int]:
    """Yield the seeds from a first one on whose vehicles of RotorPy have a mass in a range [kg]."""
    for seed in count(first):
        # The flight draws the scale of its vehicle first: 30 g to 6 kg.
        mass = 0.03 * float(np.exp(np.random.default_rng((seed, 31)).uniform(0.0, np.log(200.0))))
        if low <= mass <= high:
            yield seed


def identify_rotorpy(
    pool: ProcessPoolExecutor, logs: int, duration: float, first: int, masses: tuple[float, float] = (0.0, np.inf)
) -> Iterator[Outcome | None]:
    """Identify vehicles of RotorPy with a mass in a range [kg], of seeds from a first one on."""
    if not is_installed():
        sys.exit("RotorPy is not installed among the clients: python3 tests/clients/install.py rotorpy")
    with TemporaryDirectory() as folder:
        seeds = islice(rotorpy_seeds(first, *masses), logs)
        yield from pool.map(partial(identify_rotorpy_log, folder, duration), seeds)


SIMULATORS = {"independent": identify_independent, "rotorpy": identify_rotorpy}


def measure(tried: list[Outcome | None], duration: float) -> dict[str, Any]:
    """Return the results of a simulator's logs."""
    outcomes = [entry for entry in tried if entry is not None]
    bands = np.mean([entry.bands for entry in outcomes], axis=0).tolist()
    refused = len(tried) - len(outcomes)
    common = {"revision": commit(), "logs": len(tried), "duration": duration, "refused": refused}
    return {**common, "bands": bands, "numbers": table_of(outcomes)}


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulator", choices=SIMULATORS, default="independent", help="what makes the logs")
    parser.add_argument("--logs", type=int, default=200, help="number of vehicles, a log each")
    parser.add_argument("--duration", type=float, default=DURATION, help="of a log [s]")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--masses", type=float, nargs=2, help="range of the vehicles of RotorPy [kg], printed alone")
    parser.add_argument("--processes", type=int, default=2)
    chosen = parser.parse_args()
    tried: list[Outcome | None] = []
    with ProcessPoolExecutor(chosen.processes) as pool:
        given = (pool, chosen.logs, chosen.duration, chosen.first)
        outcomes = identify_rotorpy(*given, chosen.masses) if chosen.masses else SIMULATORS[chosen.simulator](*given)
        for outcome in outcomes:
            tried.append(outcome)
            print(f"{len(tried)} of {chosen.logs}", flush=True)
    if chosen.masses:
        entry = measure(tried, chosen.duration)
        print(markdown(*[entry[key] for key in ("numbers", "logs", "refused", "bands", "duration")]))
        return
    write_results(chosen.simulator, tried, chosen.duration)


def write_results(simulator: str, tried: list[Outcome | None], duration: float) -> None:
    """Write the results of a simulator beside those of the other."""
    path = RESULTS / "identification.json"
    kept = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    results = kept.get("simulators", {}) | {simulator: measure(tried, duration)}
    write_json(path, {"machine": machine(), "simulators": results})
    tables = [
        f"## {name}\n\n" + markdown(*[entry[key] for key in ("numbers", "logs", "refused", "bands", "duration")])
        for name, entry in results.items()
    ]
    text = "\n".join(tables)
    (RESULTS / "identification.md").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
