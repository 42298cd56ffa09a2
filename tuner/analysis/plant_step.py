"""How a study steps its plant: error of the plant step, by flying a few flights with steps half as long.

Steps of RK4 half as long err 2^4 times less, so what halving changes is 15/16 of the error (Hairer, Norsett, Wanner, Solving
Ordinary Differential Equations I, 2nd ed. 1993, section II.4). It is counted in standard errors of the held-out mean: an error of
a tenth of one widens an interval by half a percent.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from objectives.problem import Problem
from tuner.documents.parts import PlantStep
from tuner.study.study import Study, TuningStudy

Array = np.ndarray
STREAM, FLIGHTS = "plant step", 8
LARGEST = 0.1
"""Largest error [standard errors] that is not warned of."""
RICHARDSON = 16.0 / 15.0
# Scores that differ by less, relative to their size, are those of one flight flown again, but for rounding.
ALIKE = 1e-9


@dataclass(frozen=True)
class Halving:
    """A scenario's change by halving: errors (quantities,) in standard errors, flights that ended otherwise."""

    errors: Array
    ended_otherwise: int


def plant_step_of(study: TuningStudy) -> PlantStep:
    """Return how a study integrates the plant, its error not estimated."""
    timing = study.system.timing
    return PlantStep(
        step=timing.plant_step, steps=timing.steps, fixed=study.fixes_plant_step, flights=0,
        error=None, metric=None, ended_otherwise=0,
    )  # fmt: skip


def estimated_plant_step(problem: Problem, study: TuningStudy, gains: Array) -> PlantStep:
    """Return how a study integrates the plant, and the largest error over gains rows (n, g), quantities and scenarios."""
    halvings = [halving(problem, study, entry.spec, gains, entry.held_out) for entry in study.scenarios]
    errors = np.max([entry.errors for entry in halvings], axis=0)
    worst = int(np.argmax(errors))
    return plant_step_of(study).model_copy(
        update={
            "flights": FLIGHTS * len(gains) * len(halvings),
            "error": float(errors[worst]),
            "metric": str(problem.quantities[worst].metric),
            "ended_otherwise": sum(entry.ended_otherwise for entry in halvings),
        }
    )


def halving(problem: Problem, study: TuningStudy, spec: Any, gains: Array, held_out: int) -> Halving:
    """Fly gains rows (n, g) through a scenario with the plant step and with half of it; held_out: flights of its mean."""
    system = study.system
    inputs = system.sample(spec, study.seed, STREAM, range(FLIGHTS))
    flyers = (problem.flyer, problem.flyer.at(system.timing.halved))
    (coarse, lost), (fine, still_lost) = (
        problem.score(flyer.fly(gains, system.nominal, inputs), spec) for flyer in flyers
    )
    return Halving(mean_errors(coarse, fine, ~(lost | still_lost), held_out), int(np.sum(lost != still_lost)))


def mean_errors(coarse: Array, fine: Array, counted: Array, held_out: int) -> Array:
    """Return the largest error over candidates of the mean of each quantity (q,), in standard errors of `held_out` flights.

    coarse, fine (n, q, flights): scores with the plant step and with half of it; counted (n, flights): those that count. 0 where
    fewer than two count, or where flights do not differ.
    """
    errors = np.zeros(coarse.shape[:2])
    for i, flights in enumerate(counted):
        if flights.sum() > 1:
            change = np.mean(coarse[i][:, flights] - fine[i][:, flights], axis=1)
            seen = fine[i][:, flights]
            spread = np.std(seen, axis=1, ddof=1)
            differ = spread > ALIKE * np.abs(seen).max(axis=1)
            np.divide(RICHARDSON * np.abs(change), spread / held_out**0.5, out=errors[i], where=differ)
    return errors.max(axis=0)


def plant_step_warnings(found: PlantStep, key: str = Study.plant_step_key) -> list[str]:
    """Warn of a plant step that decides more than it may; key: of a study, that changes it."""
    remedy = f"give a smaller {key}, for instance {0.5 * found.step:g}"
    said = []
    if found.error is not None and found.error > LARGEST:
        said.append(
            f"The plant step of {found.step:g} s puts the mean of {found.metric} off by {found.error:.2g} standard errors, more "
            f"than {LARGEST:g}; {remedy}."
        )
    if found.ended_otherwise:
        said.append(
            f"{found.ended_otherwise} of {found.flights} flights end otherwise with a plant step half as long; {remedy}."
        )
    return said
