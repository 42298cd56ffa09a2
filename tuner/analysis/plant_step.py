"""Steps in which a study flies its plant: error of the plant step, by flying some flights with half of it, and of margins.

Steps of RK4 half as long err 2^4 times less, so what halving changes is 15/16 of the error (Hairer, Norsett, Wanner, Solving
Ordinary Differential Equations I, 2nd ed. 1993, section II.4). It is counted in standard errors of the held-out mean: an error of
a tenth of one widens an interval by half a percent. If flights do not differ, it is a share of their value. Margins of a
plant of one's own are exact; the loop that flies has those of its steps.
"""

from dataclasses import dataclass
from math import ceil
from typing import Any, NamedTuple

import numpy as np

from objectives.flown_system import FlownSystem
from objectives.problem import STATUS_ROW, Problem
from tuner.documents.parts import PlantStep
from tuner.study.searched import SearchedStudy
from tuner.study.tuning_study import TuningStudy
from tuner.text.numbers import significant

Array = np.ndarray
STREAM, FLIGHTS = "plant step", 8
LARGEST = 0.1
"""Largest error [standard errors] that is not warned of."""
LARGEST_SHARE = 1e-3
"""Largest error of a value that does not vary, or of a margin, as a share of it, that is not warned of."""
RICHARDSON = 16.0 / 15.0
# Scores that differ by less, relative to their size, are those of one flight flown again, but for rounding.
ALIKE = 1e-9
# Share of what a lost flight costs, below which values have no size of their own: steady errors that decay to rounding.
NO_SIZE = 1e-7
# Gain margins beyond this factor, 40 dB, are of frequencies where nothing acts.
REMOTE = 100.0
# Safety of advice.
SAFETY = 1.5


class Errors(NamedTuple):
    """Errors of quantities (q,): in standard errors where flights differ, as shares of values where not; else NaN."""

    standard: Array
    relative: Array


@dataclass(frozen=True)
class StepHalvingError:
    """A scenario's change by halving: errors of quantities, flights that ended otherwise."""

    errors: Errors
    ended_otherwise: int


def plant_step_of(study: TuningStudy, gains: Array | None = None) -> PlantStep:
    """Return the plant step of a study: with the error of the margins of gains rows (n, g) alone."""
    timing = study.system.timing
    margin = None if gains is None else flown_margin_error(study, gains)
    integration = PlantStep(
        step=timing.plant_step,
        steps=timing.steps,
        fixed=study.fixes_plant_step,
        flights=0,
        margin_error=None if margin is None else margin[0],
        margin=None if margin is None else margin[1],
    )
    return integration.model_copy(update={"advised": _advised(study.system, integration)})


def estimated_plant_step(problem: Problem, study: TuningStudy, gains: Array) -> PlantStep:
    """Return the plant step of a study: with the largest errors over gains rows (n, g), quantities and scenarios."""
    halvings = [halving(problem, study, entry.spec, gains, entry.held_out) for entry in study.scenarios]
    names = [str(quantity.metric) for quantity in problem.quantities]
    error, metric = _largest([entry.errors.standard for entry in halvings], names)
    relative_error, relative_metric = _largest([entry.errors.relative for entry in halvings], names)
    integration = plant_step_of(study, gains).model_copy(
        update={
            "flights": FLIGHTS * len(gains) * len(halvings),
            "error": error,
            "metric": metric,
            "relative_error": relative_error,
            "relative_metric": relative_metric,
            "ended_otherwise": sum(entry.ended_otherwise for entry in halvings),
        }
    )
    return integration.model_copy(update={"advised": _advised(study.system, integration)})


def _largest(errors: list[Array], names: list[str]) -> tuple[float | None, str | None]:
    """Return the largest of errors (scenarios, q) and the name of its quantity; None where there is none."""
    table = np.array(errors)
    if np.isnan(table).all():
        return None, None
    _, worst = np.unravel_index(np.nanargmax(table), table.shape)
    return float(np.nanmax(table)), names[int(worst)]


def halving(problem: Problem, study: SearchedStudy, spec: Any, gains: Array, held_out: int) -> StepHalvingError:
    """Fly gains rows (n, g) with the plant step and its half.

    The flights are of one scenario; held_out: flights of its mean.
    """
    system = problem.system
    inputs = system.sample(spec, study.seed, STREAM, range(FLIGHTS))
    flown = [
        flyer.fly(gains, system.nominal, inputs) for flyer in (problem.flyer, problem.flyer.at(system.timing.halved))
    ]
    (coarse, lost), (fine, still_lost) = (problem.score(results, spec) for results in flown)
    failed = flown[1].copy()
    failed[..., STATUS_ROW] = 1.0
    floor = NO_SIZE * problem.score(failed, spec)[0].max(axis=(0, 2))
    # Events are seen at control instants: one period more or less is the resolution of their times.
    times = np.array([quantity.metric.metric.censored is not None for quantity in problem.quantities])
    unseen = np.where(times, system.timing.control_period, 0.0)
    errors = mean_errors(coarse, fine, ~(lost | still_lost), held_out, floor, unseen)
    return StepHalvingError(errors, int(np.sum(lost != still_lost)))


def mean_errors(coarse: Array, fine: Array, counted: Array, held_out: int, floor: Array, unseen: Array) -> Errors:
    """Return the largest error over candidates of the mean of each quantity (q,).

    Args:
        coarse: Scores (n, q, flights) with the plant step.
        fine: The same with half of it.
        counted: Flights (n, flights) that count.
        held_out: Flights whose standard error counts.
        floor: Sizes (q,) that values are taken for at least, where an error is a share of them.
        unseen: Changes (q,) that are no errors, where an error is a share.
    """
    standard, relative = np.full((2, *coarse.shape[:2]), np.nan)
    for i, flights in enumerate(counted):
        if not flights.any():
            continue
        change = RICHARDSON * np.abs(np.mean(coarse[i][:, flights] - fine[i][:, flights], axis=1))
        seen = fine[i][:, flights]
        spread, size = np.std(seen, axis=1, ddof=min(1, flights.sum() - 1)), np.abs(seen).max(axis=1)
        differ = spread > ALIKE * size
        np.divide(change, spread / held_out**0.5, out=standard[i], where=differ)
        # Of 0 with both steps, such as the lost flights of none, nothing can be told.
        alike = ~differ & (np.maximum(size, np.abs(coarse[i][:, flights]).max(axis=1)) > 0.0)
        np.divide(np.maximum(change - unseen, 0.0), np.maximum(size, floor), out=relative[i], where=alike)
    return Errors(*[np.fmax.reduce(errors, axis=0) for errors in (standard, relative)])


def flown_margin_error(study: SearchedStudy, gains: Array) -> tuple[float, str] | None:
    """Return the largest relative error of the flown loop's margins, with name.

    It is taken over gains rows (n, g). None where the study has no margins of the loop as flown.
    """
    margins = study.flown_margins(gains)
    if margins is None:
        return None
    exact, flown = margins
    if np.any(exact.stable != flown.stable):
        return 1.0, "stability"
    shares = {
        name: _share(getattr(exact, field).value[exact.stable], getattr(flown, field).value[exact.stable])
        for name, field in COMPARED.items()
    }
    worst = max(shares, key=lambda name: shares[name])
    return shares[worst], worst


COMPARED = {"ms": "sensitivity", "gain_up": "gain_up", "gain_down": "gain_down", "phase_margin": "phase"}


def _share(exact: Array, flown: Array) -> float:
    """Return the largest relative change of values (k,) limited in both."""
    both = np.isfinite(exact) & np.isfinite(flown) & (exact < REMOTE)
    return float(np.max(np.abs(flown[both] - exact[both]) / exact[both], initial=0.0))


def _advised(system: FlownSystem, integration: PlantStep) -> float | None:
    """Return a plant step [s] that is short enough; None where nothing is warned of."""
    worst = max((share for share, _ in _excesses(integration)), default=0.0)
    if worst <= 1.0 and not integration.ended_otherwise:
        return None
    fewest = 2 * integration.steps if integration.ended_otherwise else integration.steps
    steps = ceil(integration.steps * (SAFETY * worst) ** (1.0 / system.order))
    return system.timing.control_period / max(fewest, system.min_steps, steps)


def _excesses(integration: PlantStep) -> list[tuple[float, str]]:
    """Return errors over their warning limits, each with a description."""
    excesses = []
    if integration.error is not None:
        excess = (
            f"the mean of {integration.metric} off by {integration.error:.2g} standard errors, more than {LARGEST:g}"
        )
        excesses.append((integration.error / LARGEST, excess))
    most = f"more than {100.0 * LARGEST_SHARE:g} %"
    if integration.relative_error is not None:
        excess = f"{integration.relative_metric} off by {significant(100.0 * integration.relative_error, 2)} %, {most}"
        excesses.append((integration.relative_error / LARGEST_SHARE, excess))
    if integration.margin_error is not None:
        share = significant(100.0 * integration.margin_error, 2)
        excess = f"{integration.margin} off by {share} % in the loop as it flies, {most}"
        excesses.append((integration.margin_error / LARGEST_SHARE, excess))
    return excesses


def plant_step_warnings(integration: PlantStep, key: str = TuningStudy.plant_step_key) -> list[str]:
    """Warn of a plant step that decides more than it may; key: of a study, that changes it."""
    advised = 0.5 * integration.step if integration.advised is None else integration.advised
    remedy = f"write {key} = {advised:.12g}"
    warnings = [
        f"The plant step of {integration.step:g} s puts {excess}; {remedy}."
        for share, excess in _excesses(integration)
        if share > 1.0
    ]
    if integration.ended_otherwise:
        count = f"{integration.ended_otherwise} of {integration.flights} flights"
        warnings.append(f"{count} end otherwise with a plant step half as long; {remedy}.")
    return warnings
