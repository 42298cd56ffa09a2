"""Starting points of a search: the default, by which everything is measured, and points known to be good before flying."""

from collections.abc import Callable
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from plant.quadrotor.sensors import SensorSpec
from plant.records import flatten
from tuner.study.study import SearchedStudy, Study

if TYPE_CHECKING:
    from objectives.design import AxisDesign

Array = np.ndarray
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
