"""Numbers with wide intervals, and an experiment that would narrow them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tuner.extensions.plant_fit.estimate import Projection
from tuner.extensions.plant_fit.intervals import NORMAL_QUANTILE, FittedPlant, Number
from tuner.extensions.plant_fit.noise import whiten
from tuner.extensions.plant_fit.response import Grid
from tuner.extensions.plant_fit.slopes import slopes_of
from tuner.extensions.plant_fit.study_file import Signals
from tuner.text.numbers import significant

Array = np.ndarray
TARGET_WIDTH = 0.1
"""Half-width of an interval over its number that an experiment is planned for."""
MAX_CELLS = 20_000
"""Most samples of a planned experiment."""
ROUNDS = 8
SEED = 1


@dataclass(frozen=True)
class Plan:
    """An experiment: kind, amplitude over the range in the data, duration and time between moves [s]."""

    kind: str
    duration: float
    hold: float
    reached: float


def notes_of(plant: FittedPlant, signals: Signals, i: int, numbers: Sequence[Number]) -> list[str]:
    """Return notes on wide intervals and on an experiment that narrows them."""
    unknown = list(dict.fromkeys(number.name for number in numbers if not number.is_identified))
    wide = [number for number in numbers if not _is_narrow(plant, number)]
    notes = [f"Not identified: {', '.join(unknown)}."] if unknown else []
    if not wide:
        return notes
    plans = [each for each in (_plan(plant, kind) for kind in ("steps", "PRBS")) if each is not None]
    if not plans:
        return [
            *notes,
            "No experiment of the amplitude in the data would give every interval +-10 %; move the input more.",
        ]
    best = min(plans, key=lambda each: each.duration)
    names = ", ".join(dict.fromkeys(number.name for number in wide))
    sizes = ", ".join(
        f"{name} +-{significant(0.5 * (high - low), 2)}"
        for name, (low, high) in zip(signals.inputs, signals.ranges, strict=True)
    )
    how = f"steps up and down every {significant(best.hold, 2)} s" if best.kind == "steps" else (
        f"a PRBS that may switch every {significant(best.hold, 2)} s"
    )  # fmt: skip
    return [
        *notes,
        f"Intervals of {names} are wider than +-10 % of the number. {how[0].upper()}{how[1:]} over "
        f"{significant(best.duration, 2)} s with the amplitude of these data ({sizes}) would give about "
        f"+-{100.0 * best.reached:.0f} %.",
    ]


def _is_narrow(plant: FittedPlant, number: Number) -> bool:
    """Whether an interval is as narrow as wanted; a dead time is compared with the response time of the plant."""
    scale = abs(number.value)
    if number.name == "L":
        scale = max(scale, _response_time(plant))
    return bool(number.high - number.low <= 2.0 * TARGET_WIDTH * scale)


def _response_time(plant: FittedPlant) -> float:
    solution = plant.solution
    times = [1.0 / abs(root) for each in solution.denominators for root in np.roots(each) if abs(root) > 0.0]
    return max([*times, *solution.dead_times.tolist(), 10.0 * plant.chosen.problem.period])


def _plan(plant: FittedPlant, kind: str) -> Plan | None:
    """Return the shortest experiment of a kind that suffices, or None."""
    period, slow = plant.chosen.problem.period, _response_time(plant)
    hold = 3.0 * slow if kind == "steps" else 0.5 * slow
    cells = max(round(hold / period), 1)
    for doubling in range(1, ROUNDS):
        n = cells * 2 ** (doubling + (0 if kind == "steps" else 2))
        if n > MAX_CELLS:
            return None
        reached = _reached(plant, _moves(plant, kind, cells, n), n)
        if reached <= TARGET_WIDTH:
            return Plan(kind, n * period, cells * period, reached)
    return None


def _moves(plant: FittedPlant, kind: str, cells: int, n: int) -> Array:
    """Return inputs (n, inputs) that move by the ranges in the data."""
    rng = np.random.default_rng(SEED)
    count = n // cells + 1
    columns = []
    for grid in np.vstack([each.inputs for each in plant.chosen.problem.grids]).T:
        signs = np.arange(count) % 2 if kind == "steps" else rng.integers(0, 2, count)
        signs[0] = 0
        columns.append(np.ptp(grid) * np.repeat(signs, cells)[:n])
        # Inputs that move together could not be told from each other.
        columns[-1] = np.roll(columns[-1], (len(columns) - 1) * max(cells // 2, 1))
    return np.column_stack(columns)


def _reached(plant: FittedPlant, inputs: Array, n: int) -> float:
    """Return the widest relative half-width that an experiment would leave."""
    problem, solution = plant.chosen.problem, plant.solution
    empty = (np.zeros(0, dtype=int),)
    planned = replace(
        problem,
        grids=(Grid(problem.period, inputs, None),),
        outputs=(np.zeros(n),),
        outliers=empty,
        has_start=(False,),
        rows=None,
    )
    projection = Projection(planned, solution.structure)
    first = projection.solve(solution.shape, solution.dead_times, solution.noise)
    shared = solution.numerators.size
    linear = np.zeros(len(first.linear))
    linear[:shared] = solution.linear[:shared]
    used = whiten(slopes_of(projection, replace(first, linear=linear))[0], solution.noise)
    size = np.linalg.norm(used, axis=0)
    size[size == 0.0] = 1.0
    inverse = np.linalg.pinv(used / size)
    deviation = NORMAL_QUANTILE * np.sqrt(plant.variance * np.sum(inverse**2, axis=1)) / size
    # Shapes are logarithms; a dead time counts against the response time.
    scale = np.ones(plant.n_plant)
    scale[solution.shape.size : -shared] = _response_time(plant)
    scale[-shared:] = np.maximum(np.abs(solution.numerators.ravel()), 1e-300)
    return float(np.max(deviation[: plant.n_plant] / scale))
