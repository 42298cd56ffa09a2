"""Starting points of a search: the default, by which everything is measured, and points known to be good before flying.

Points of earlier runs fill at most half of the first generation, and points around them a third, from which a model learns
where the front goes; a Latin hypercube is left for a search that they mislead, and of it, what fails pre-screening goes to
further points of earlier runs. `benchmarks/results/transfer.md` measures both.
"""

from collections.abc import Callable
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from plant.quadrotor.sensors import SensorSpec
from plant.records import flatten
from plant.seeds import generator
from plant.ties import first_smallest
from tuner.search.initial_design import first_passing
from tuner.study.starts import merged_points
from tuner.study.study import SearchedStudy, Study

if TYPE_CHECKING:
    from objectives.design import AxisDesign

Array = np.ndarray
Screening = Callable[[Array], Array]
# Standard deviations of the steps from a point that fails pre-screening, shortest first, and draws for each.
WIDTHS, DRAWS = (0.01, 0.03, 0.1), 32
# Standard deviation of the steps around points of a front, and range of the blends between two of them.
AROUND, BLENDS = 0.1, (-0.25, 1.25)
# Coordinates of the unit cube that differ by less than this are the same point.
SAME = 1e-9


def study_designs(study: Study) -> "dict[str, AxisDesign]":
    """Return the axes' designs for a study's airframe, laws and loudest sensors; takes some 4 s, half of it imports."""
    from objectives.design import DesignRequirements, design_axes

    system = study.system
    requirements = DesignRequirements(sensors=loudest([entry.spec.sensors for entry in study.scenarios]))
    return design_axes(system.cascade, system.nominal, system.timing, requirements)


def loudest(sensors: list[SensorSpec]) -> SensorSpec:
    """Return the largest noise and bias of each sensor."""
    return SensorSpec(
        **{entry.name: max(getattr(spec, entry.name) for spec in sensors) for entry in fields(SensorSpec)}
    )


def design_row(study: Study, designs: "dict[str, AxisDesign]") -> Array:
    """Return the gains row (gains,) of designed axes."""
    kind = study.system.cascade.Gains
    return np.array(flatten(kind(**{axis: designs[axis].gains for axis in kind._fields})))


def without_design(designs: "dict[str, AxisDesign]") -> list[str]:
    """Return a sentence for each reason why axes keep their defaults."""
    reasons: dict[str, list[str]] = {}
    for axis, design in designs.items():
        if not design.designed:
            reasons.setdefault(design.why, []).append(axis)
    return [f"No design for {', '.join(axes)}: {why}; the default gains stand in." for why, axes in reasons.items()]


def _default(study: SearchedStudy) -> tuple[Array, list[str]]:
    return study.space.point(study.default_row), []


def _design(study: Study) -> tuple[Array, list[str]]:
    designs = study_designs(study)
    return study.space.point(design_row(study, designs)), without_design(designs)


STARTS: dict[str, Callable[[Any], tuple[Array, list[str]]]] = {"default": _default, "design": _design}
"""Functions from a study to a point (d,) of its decision space and warnings, by the names of `tuner.search.names`."""


def starting_points(study: SearchedStudy) -> tuple[Array, list[str]]:
    """Return the starting points (k, d) that `search.initial` names, and warnings.

    Each lies in the study's ranges. The default comes first whatever is named, because the search measures everything
    by it. A point that is there already is left out.
    """
    points: list[Array] = []
    warnings: list[str] = []
    for name in dict.fromkeys(("default", *study.search.initial)):
        point, texts = STARTS[name](study)
        warnings += texts
        if all(np.abs(point - other).max(initial=0.0) > SAME for other in points):
            points.append(point)
        else:
            warnings.append(f'The starting point "{name}" is one that the search starts from anyway.')
    return np.array(points), warnings


def earlier_points(
    study: SearchedStudy, starts: Array, most: int, passes_screening: Screening | None = None
) -> tuple[Array, Array, list[str]]:
    """Return earlier points (k, d) for the first generation, further ones (r, d), and warnings.

    A point that fails pre-screening is moved to the nearest one found that passes: the best points of a front stand at
    limits, and those of another vehicle or wind lie a little elsewhere.

    Args:
        study: Names the runs.
        starts: Points (s, d) that the search starts from anyway.
        most: Largest number of points.
        passes_screening: Points (n, d) -> mask (n,) of those worth a flight; None for all.
    """
    points = _without_repetitions(merged_points(study.search.starts, study.space), starts)
    first, rest = points[:most], points[most:]
    if passes_screening is None or not len(points):
        return first, rest, []
    moved = nearest_passing(first, passes_screening(first), generator(study.seed, "search/starts", 0), passes_screening)
    taken = np.concatenate([moved, first_passing(rest, most - len(moved), passes_screening)])
    spare = _without_repetitions(rest, taken)
    lost = min(most, len(points)) - len(taken)
    if not lost:
        return taken, spare, []
    count = f"{lost} of {min(most, len(points))}"
    return (
        taken,
        spare,
        [f"Starting points left out for limits known without flying, which nothing near keeps: {count}."],
    )


def surrounding_points(
    points: Array, count: int, rng: np.random.Generator, passes_screening: Screening | None
) -> Array:
    """Return at most `count` points (k, d) between and around points (n, d) that pass screening."""
    if not len(points):
        return points
    ends = points[rng.integers(len(points), size=(count * DRAWS, 2))]
    blend = rng.uniform(*BLENDS, size=(count * DRAWS, 1))
    steps = AROUND * rng.standard_normal((count * DRAWS, points.shape[1]))
    drawn = np.clip(ends[:, 0] + blend * (ends[:, 1] - ends[:, 0]) + steps, 0.0, 1.0)
    return drawn[:count] if passes_screening is None else first_passing(drawn, count, passes_screening)


def nearest_passing(points: Array, passing: Array, rng: np.random.Generator, passes_screening: Screening) -> Array:
    """Return passing points (k, d): each, or the nearest of draws around it.

    passing (n,): which of the points (n, d) pass as they are. A point that has no passing draw is left out.
    """
    result: dict[int, Array] = {i: points[i] for i in np.flatnonzero(passing).tolist()}
    for width in WIDTHS:
        missing = [i for i in range(len(points)) if i not in result]
        if not missing:
            break
        steps = width * rng.standard_normal((len(missing), DRAWS, points.shape[1]))
        drawn = np.clip(points[missing][:, None] + steps, 0.0, 1.0)
        passes = passes_screening(drawn.reshape(-1, points.shape[1])).reshape(len(missing), DRAWS)
        distances = np.where(passes, np.square(drawn - points[missing][:, None]).sum(axis=2), np.inf)
        for row, i in enumerate(missing):
            if passes[row].any():
                result[i] = drawn[row, first_smallest(distances[row])]
    return np.array([result[i] for i in sorted(result)]).reshape(-1, points.shape[1])


def _without_repetitions(points: Array, starts: Array) -> Array:
    """Return the points (k, d) that repeat neither starts (s, d) nor each other."""
    distinct: list[Array] = []
    for point in points:
        if all(np.abs(point - other).max(initial=0.0) > SAME for other in (*starts, *distinct)):
            distinct.append(point)
    return np.array(distinct).reshape(-1, starts.shape[1])
