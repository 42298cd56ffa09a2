"""Gains for all vehicles that a log allows beside gains for the likeliest of them: `python -m benchmarks.over_the_set`.

From each of many made logs, whose vehicle is known, an airframe is identified. The loops of `studies/crazyflie_firmware.toml`
are tuned for it twice in steps of half a metre, for the least error of roll and pitch that their margins allow, by the same small
search: over the set, with vehicles drawn from [uncertainty] and margins kept at its extremes, and on the point estimate alone.
Both gains then fly on the vehicle behind the log and are judged by the same limits. Shares are of logs; their intervals are those
of Clopper and Pearson at 95 %. Results go to benchmarks/results/over_the_set.json after every log; a rerun goes on from there.
"""

import argparse
import json
import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import tuner
from benchmarks.two_masses import share
from objectives.margins.requirement import MarginRequirement
from objectives.problem import FlightBatch, Problem
from objectives.system import System
from plant.quadrotor.scenarios import HELD_OUT, ScenarioSpec
from plant.quadrotor.vehicle import Vehicle
from tests.tuner.extensions.identification.known_flights import AIRFRAME, KnownFlight, known_flights
from tuner.extensions.identification.identify import identify_vehicle
from tuner.extensions.identification.onward import identified_text
from tuner.gains import read_gains
from tuner.study.margins import MarginAnalysis, margin_requirement
from tuner.study.schema import MarginTable
from tuner.study.study import Study

STUDY = Path(__file__).parents[1] / "studies" / "crazyflie_firmware.toml"
KEPT = Path(__file__).parent / "results" / "over_the_set.json"
SECONDS, FLIGHTS = 8.0, 64
"""Length of a log [s]; flights on the truth."""
SEARCH = {"algorithm": "cmaes", "population": 12, "generations": 16}
REFERENCE = {"kind": "steps", "x": 0.5, "y": -0.5, "z": 0.3, "time": 0.5}
WAYS = ("set", "point")


def tables(airframe: Path, way: str) -> dict[str, Any]:
    """Return the tables of the study over an airframe file: of the set, or of the point estimate."""
    found = tomllib.loads(STUDY.read_text(encoding="utf-8"))
    found |= {"airframe": {"file": airframe.name}, "search": SEARCH, "objective": found["objective"][:1]}
    one = dict.fromkeys(("mass", "inertia", "thrust", "lag"), 0.0)
    for scenario in found["scenario"]:
        scenario |= {"reference": REFERENCE, "duration": 4.0, "search": 8, "held_out": 32}
        scenario["spread"] = {"from": "airframe"} if way == "set" else one
    for margin in found["margin"]:
        margin |= {"axis": "tilt", "spread": way == "set"}
    return found


def as_flown(truth: Vehicle, airframe: Vehicle) -> Vehicle:
    """Return a vehicle with its rotor speeds in the scale of the airframe that the controller knows.

    A controller asks for a speed; what goes to the motor is its share of the speed at full command.
    """
    scale = truth.speed_max / airframe.speed_max
    thrust = truth.thrust_coefficient * scale**2
    return truth._replace(speed_max=airframe.speed_max, thrust_coefficient=thrust, rotor_inertia=airframe.rotor_inertia)


def judged(study: Study, gains: np.ndarray, truth: Vehicle) -> dict[str, Any]:
    """Return the limits that gains break on a vehicle, and their first objective in flights there."""
    system = replace(study.system, vehicle=as_flown(truth, study.airframe.vehicle))
    spec, rows = replace(study.scenarios[0].spec, uncertainty=None), gains[None]
    problem = Problem(system, study.space, study.objectives, study.constraints, study.seed, 1)
    flown = problem.evaluate_gains(rows, (FlightBatch(spec, HELD_OUT, FLIGHTS),), fly_all=True)
    limits = [entry.objective.label for entry in study.constraints]
    over = [name for name, by in zip(limits, flown.violations[0].tolist(), strict=True) if by > 0.0]
    return {
        "broken": [*margins_broken(margins_on(study, system, spec, rows)), *over],
        "error": float(flown.values[0, 0]),
    }


def margins_on(
    study: Study, system: System, spec: ScenarioSpec, rows: np.ndarray
) -> list[tuple[MarginRequirement, float]]:
    """Return the margins that a study limits, of gains (1, gains) on the vehicle of a system alone."""
    plain = [
        MarginTable.model_validate(table.model_dump(exclude_unset=True) | {"spread": False})
        for table in study.table.margin
    ]
    requirements = tuple(margin_requirement(table, system.timing, (spec,)) for table in plain)
    values = MarginAnalysis(requirements, system, (spec,), study.path).values(rows)[0].tolist()
    return list(zip(requirements, values, strict=True))


def margins_broken(margins: Sequence[tuple[MarginRequirement, float]]) -> list[str]:
    """Return the names of margins beyond their limits."""
    signs = {"min": 1.0, "max": -1.0}
    return [
        entry.quantity.name for entry, value in margins if signs[entry.quantity.sense] * (value - entry.limit) < 0.0
    ]


def tried(flight: KnownFlight, folder: Path) -> dict[str, Any]:
    """Return for each way what its gains do on the truth, None where no gains keep the limits of its own study."""
    airframe, found = folder / "mine.toml", dict[str, Any]()
    airframe.write_text(identified_text(identify_vehicle([flight.log], AIRFRAME), "From a made log"), encoding="utf-8")
    for way in WAYS:
        study = tuner.make_study(tables(airframe, way), way, folder, kind=tuner.Study)
        feasible = tuner.run(study, folder / way, threads=1).feasible
        gains = folder / way / "gains.json"
        found[way] = judged(study, np.array(read_gains(gains).gains), flight.vehicle) if feasible else None
    return found


def report(kept: list[dict[str, Any]]) -> None:
    """Print the table of logs for which both ways found gains."""
    both = [entry for entry in kept if all(entry[way] for way in WAYS)]
    print(f"{len(kept)} logs; both found gains for {len(both)}")
    print("| gains | a limit broken on the truth | which |\n|---|---:|---|")
    for way in WAYS:
        broken = [entry[way]["broken"] for entry in both]
        which = ", ".join(f"{name} {count}" for name, count in Counter(sum(broken, [])).most_common())
        print(f"| {way} | {share(sum(map(bool, broken)), len(both))} | {which} |")
    only = [sum(bool(e[a]["broken"]) and not e[b]["broken"] for e in both) for a, b in (WAYS, WAYS[::-1])]
    ratio = np.median([entry["set"]["error"] / entry["point"]["error"] for entry in both], axis=0)
    print(
        f"broken by the set's alone {only[0]}, by the point's alone {only[1]}; error, set over point, median {ratio:.3f}"
    )


def main() -> None:
    """Try every log that is not there yet, and print the table."""
    parser = argparse.ArgumentParser(description="Gains over an identified set beside gains for its middle.")
    parser.add_argument("--logs", type=int, default=40)
    count = parser.parse_args().logs
    kept = json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else []
    for flight in known_flights(count, duration=SECONDS, seed=19)[len(kept) :]:
        with TemporaryDirectory() as folder:
            kept.append(tried(flight, Path(folder)))
        KEPT.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    report(kept)


if __name__ == "__main__":
    main()
