"""Chains from a log to gains, judged on the vehicle behind the log: `python -m benchmarks.chains`.

Logs are those of `benchmarks.identification`, of a simulator that shares no code with the product. From each an airframe is
identified and a PID attitude loop tuned over it, with vehicles drawn from [uncertainty] and margins kept at its extremes. The
gains are then linearized and flown on the truth: its thrust, lags, inflow, dead time, gyro and center of mass. Results go to
benchmarks/results/chains.json.
"""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import tuner
from benchmarks.identification import BATCH, DAMPING, DURATION, log_of, prior_of
from benchmarks.measuring import RESULTS, machine, write_json
from benchmarks.over_the_set import margins_broken, margins_on
from objectives.margins.requirement import MarginRequirement
from objectives.problem import FlightBatch, Problem
from objectives.risk import clopper_pearson
from plant.errors import InputError
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.airframes.schema import GROUPS, SCALARS, Sourced
from plant.quadrotor.scenarios import HELD_OUT
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Rotors, Vec3
from tests.tuner.extensions.identification.independent_flights import GRAVITY, STEP, Recording, Truth, draw_truths, fly
from tests.tuner.extensions.identification.known_flights import AIRFRAME
from tuner.extensions.identification.identify import identify_vehicle
from tuner.extensions.identification.onward import identified_text
from tuner.extensions.vehicle_fit.parameters import low_pass_delay
from tuner.gains import read_gains
from tuner.store.environment import commit

FIRST_SEED, FLIGHTS = 44, 32
"""Seed of the first batch of vehicles, none of which set a constant of the fit; flights on the truth."""
LIMITS = {"phase_margin": ("min", 35.0), "ms": ("max", 2.0)}
"""Margins of roll and pitch [deg; 1], and the side on which the limit lies."""
UNITS = {key: entry.unit for key, entry in AIRFRAME.sources.items()} | {"gyro_cutoff": "Hz"}
TABLES: dict[str, Any] = {
    "title": "A vehicle from a log",
    "seed": 2026,
    "airframe": {"file": "mine.toml", "allow_unphysical": True},
    "controller": {"position": "ladrc", "attitude": "pid", "control_period": 0.002, "delay": True},
    "gains": {
        "tilt.kp": {"low": 10, "high": 400, "scale": "log"},
        "tilt.ki": {"low": 1, "high": 400, "scale": "log"},
        "tilt.kd": {"low": 3, "high": 60, "scale": "log"},
    },
    "scenario": [
        {
            "name": "steps",
            "duration": 4.0,
            "search": 4,
            "held_out": 16,
            "reference": {"kind": "steps", "x": 0.5, "y": -0.5, "time": 0.5},
            "air": {"intensity": 2.0, "altitude": 3.0, "minimum_airspeed": 1.0},
            "spread": {"from": "airframe"},
        }
    ],
    "objective": [{"metric": "rms.tilt"}],
    "constraint": [{"metric": "failure", "max": 0.0}],
    "margin": [
        {"quantity": name, "axis": "tilt", side: limit, "spread": True} for name, (side, limit) in LIMITS.items()
    ],
    "search": {"algorithm": "cmaes", "population": 12, "generations": 12},
}


@dataclass(frozen=True)
class Chain:
    """A chain: its end, and margins of the gains.

    Attributes:
        end: "flown", "refused" where the log shows nothing, "infeasible" where no gains keep the limits.
        predicted: Margins on the identified vehicle.
        actual: Margins on the truth.
        broken: Margins that the truth breaks.
        lost: Share of the flights on the truth that were lost.
        mass: Of the truth [kg].
    """

    end: str
    mass: float
    predicted: dict[str, float]
    actual: dict[str, float]
    broken: list[str]
    lost: float


def cutoff_of(truth: Truth, i: int) -> float:
    """Return the gyro's cut-off in the product's terms [Hz]: of the same delay."""
    return low_pass_delay(DAMPING / (2.0 * np.pi * truth.cutoff[i]))


def vehicle_of(truth: Truth, i: int, airframe: Vehicle) -> Vehicle:
    """Return the truth as the product's vehicle, with rotor speeds in the scale of an airframe.

    Its thrust has the truth's value and slope at hover.
    """
    exponent, weight = truth.exponent[i], 0.25 * truth.mass[i] * GRAVITY
    hover = (weight / truth.full[i]) ** (1.0 / exponent)
    linear = hover * (2.0 - exponent) / (exponent - 1.0 + hover * (2.0 - exponent))
    full = weight / ((1.0 - linear) * hover**2 + linear * hover)
    inertia, lever, (x, y) = truth.inertia[:, i], truth.lever[i], truth.center[:, i]
    climb = 4.0 * truth.inflow[i]
    damping = climb * lever**2
    return airframe._replace(
        mass=truth.mass[i],
        inertia=Vec3(*inertia.tolist()),
        rotor_x=Rotors(lever - x, lever - x, -lever - x, -lever - x),
        rotor_y=Rotors(lever - y, -lever - y, lever - y, -lever - y),
        thrust_coefficient=full / airframe.speed_max**2,
        thrust_linear=linear,
        torque_ratio=truth.torque_ratio[i],
        lag_up=truth.lag_up[i],
        lag_down=truth.lag_down[i],
        dead_time=STEP * float(truth.late[i]),
        drag_linear=Vec3(truth.side[i], truth.side[i], climb),
        rate_damping=Vec3(damping, damping, 0.0),
        gyro_cutoff=cutoff_of(truth, i),
    )


def prior_airframe(truth: Truth, i: int, seed: int) -> Airframe:
    """Return the prior of a vehicle as of an airframe file: with its gyro's cut-off, which its firmware sets."""
    prior = prior_of(truth, i, np.random.default_rng((seed, i, 5)))
    # Spins as the simulator has them; the prior's file is that of a cross.
    vehicle = prior.vehicle._replace(gyro_cutoff=cutoff_of(truth, i), drag_height=0.0)
    values = {name: getattr(vehicle, name) for name in (*SCALARS, "gyro_cutoff")} | {
        "arm": np.sqrt(2.0) * vehicle.rotor_x.r1
    }
    for group in GROUPS:
        values |= {f"{group}.{axis}": value for axis, value in getattr(vehicle, group)._asdict().items()}
    sources = {key: Sourced(float(value), UNITS[key], "assumed: before the log") for key, value in values.items()}
    return replace(prior, vehicle=vehicle, sources=sources)


def fly_chain(recording: Recording, truth: Truth, seed: int, i: int) -> Chain:
    """Return the chain of a vehicle."""
    prior = prior_airframe(truth, i, seed)
    mass = float(truth.mass[i])
    with TemporaryDirectory() as name:
        folder = Path(name)
        try:
            text = identified_text(identify_vehicle([log_of(recording, i)], prior), "From a made log")
        except InputError:
            return Chain("refused", mass, {}, {}, [], 0.0)
        # Some of the drawn vehicles have propellers that turn with less torque than any on sale.
        (folder / "mine.toml").write_text(f"allow_unphysical = true\n{text}", "utf-8")
        study = tuner.make_study(TABLES, "chain", folder, kind=tuner.Study)
        if not tuner.run(study, folder / "run", threads=1).feasible:
            return Chain("infeasible", mass, {}, {}, [], 0.0)
        gains = np.array(read_gains(folder / "run" / "gains.json").gains)[None]
        system = replace(study.system, vehicle=vehicle_of(truth, i, study.airframe.vehicle))
        problem = Problem(system, study.space, study.objectives, study.constraints, study.seed, 1)
        spec = replace(study.scenarios[0].spec, uncertainty=None)
        flown = problem.evaluate_gains(gains, (FlightBatch(spec, HELD_OUT, FLIGHTS),), fly_all=True)
        lost = max(float(flown.violations[0, 0]), 0.0)
        predicted, actual = (margins_on(study, each, spec, gains) for each in (study.system, system))
        return Chain("flown", mass, values_of(predicted), values_of(actual), margins_broken(actual), lost)


def values_of(margins: Sequence[tuple[MarginRequirement, float]]) -> dict[str, float]:
    """Return the values of margins by their names."""
    return {entry.quantity.name: value for entry, value in margins}


def summary_of(chains: list[Chain]) -> dict[str, Any]:
    """Return the shares of broken limits with Clopper-Pearson intervals, and errors of the predicted margins."""
    flown = [entry for entry in chains if entry.end == "flown"]
    broken, count = sum(bool(entry.broken) for entry in flown), len(flown)
    errors = np.array([entry.actual["phase_margin"] - entry.predicted["phase_margin"] for entry in flown])
    error = errors[np.isfinite(errors)]
    return {
        "chains": len(chains),
        "flown": count,
        "refused": sum(entry.end == "refused" for entry in chains),
        "infeasible": sum(entry.end == "infeasible" for entry in chains),
        "broken": broken,
        "broken_at_most": float(clopper_pearson(broken, count).high),
        "phase_margin_bias": float(error.mean()),
        "phase_margin_bias_error": float(error.std(ddof=1) / np.sqrt(len(error))),
        "phase_margin_spread": float(error.std(ddof=1)),
        "lost": float(np.mean([entry.lost for entry in flown])),
    }


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--chains", type=int, default=60)
    parser.add_argument("--processes", type=int, default=2)
    chosen = parser.parse_args()
    chains: list[Chain] = []
    with ProcessPoolExecutor(chosen.processes) as pool:
        for batch in range(-(-chosen.chains // BATCH)):
            seed = FIRST_SEED + batch
            truth = draw_truths(np.random.default_rng(seed), BATCH)
            each = partial(fly_chain, fly(truth, DURATION, seed), truth, seed)
            for chain in pool.map(each, range(min(BATCH, chosen.chains - len(chains)))):
                chains.append(chain)
                print(f"{len(chains)} {chain.end} {chain.predicted} {chain.actual} {chain.lost}", flush=True)
    result = summary_of(chains)
    rows = [asdict(entry) for entry in chains]
    write_json(RESULTS / "chains.json", {"machine": machine(), "revision": commit(), **result, "rows": rows})
    print(result)


if __name__ == "__main__":
    main()
