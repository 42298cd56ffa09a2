"""Starting points of a search from earlier runs: matched gain by gain, ordered, clipped into the ranges.

A study names results folders and gains.json files; what it takes from them becomes part of the study, so that a run is the same
without them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, zip_longest
from math import isfinite
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from objectives.decisions import DecisionSpace, Variable
from plant.errors import InputError, UnknownNameError
from tuner.search.front import select_subset
from tuner.study.earlier_front import FrontTable, gains_file_of, read_front
from tuner.study.schema import StartTable
from tuner.study.shipped_fronts import ShippedFront
from tuner.text.input_errors import located
from tuner.text.sentences import listing
from tuner.text.toml_text import SHIPPED

Point = Mapping[str, float]
# Points of a front that a study keeps: more than half of any first generation that is flown with a model.
MAX_POINTS = 64
# Rounding of a value that stood at the end of a range.
ROUNDING = 1e-9


class EarlierGains(NamedTuple):
    """Gains of a file that mean the same in a study.

    values: all of them by address, in the file's units. factors: by address, what makes them gains of the study.
    """

    values: Mapping[str, float]
    factors: Mapping[str, float]


class GainsSource(Protocol):
    """A study that says which gains mean the same in it; InputError where none does."""

    def earlier_gains(self, file: Path) -> EarlierGains:
        """Return the gains of a file."""
        ...

    def shipped_front(self) -> ShippedFront:
        """Return the front that comes with the tool."""
        ...


@dataclass(frozen=True)
class StartSet:
    """Points of one origin, best spread first: values of searched gains by variable, the default where one is missing."""

    origin: str
    points: tuple[Point, ...] = field(hash=False)

    def units(self, space: DecisionSpace) -> np.ndarray:
        """Return the points (n, d) in the unit cube, clipped into the ranges."""
        default = space.point(np.array(space.base))
        rows = [
            [_unit(variable, point, usual) for variable, usual in zip(space.variables, default, strict=True)]
            for point in self.points
        ]
        return np.array(rows)

    @property
    def table(self) -> StartTable:
        """The entry of search.starts that holds the points themselves."""
        return StartTable(origin=self.origin, points=[dict(point) for point in self.points])

    def texts(self, space: DecisionSpace) -> list[str]:
        """Return sentences on origin, lacking gains and clipped points."""
        number = len(self.points)
        texts = [f"The search starts from {self.origin} ({number} {'point' if number == 1 else 'points'})."]
        lacking = [each.name for each in space.variables if not any(each.name in point for point in self.points)]
        if lacking:
            texts.append(
                f"{_upper(self.origin)} says nothing of {listing(lacking)}, which there starts at the default."
            )
        outside = [[_is_outside(each, point) for each in space.variables] for point in self.points]
        clipped = sum(map(any, outside))
        if clipped:
            names = [
                each.name
                for each, column in zip(space.variables, zip(*outside, strict=True), strict=True)
                if any(column)
            ]
            texts.append(f"{clipped} of these points are clipped into the ranges of the study: {listing(names)}.")
        return texts


def _upper(text: str) -> str:
    return text[:1].upper() + text[1:] if text.startswith("the ") else text


def _unit(variable: Variable, point: Point, usual: float) -> float:
    return variable.unit(point[variable.name]) if variable.name in point else float(usual)


def _is_outside(variable: Variable, point: Point) -> bool:
    value = point.get(variable.name, variable.low)
    slack = ROUNDING * max(abs(variable.low), abs(variable.high))
    return not variable.low - slack <= value <= variable.high + slack


def merged_points(sets: Sequence[StartSet], space: DecisionSpace) -> np.ndarray:
    """Return the points (n, d) of all sets, the first of each set first."""
    in_turn = chain.from_iterable(zip_longest(*[entry.units(space) for entry in sets]))
    return np.array([row for row in in_turn if row is not None]).reshape(-1, len(space.variables))


def start_sets(
    entries: Sequence[str | StartTable], folder: Path, space: DecisionSpace, study: GainsSource
) -> tuple[StartSet, ...]:
    """Return the starting points that entries of search.starts name.

    Args:
        entries: Paths, from the folder of the study or from the working directory, the name of what comes with the tool, or
            points by themselves.
        folder: Folder of the study.
        space: Searched gains.
        study: Says which gains mean the same in it.

    Raises:
        InputError: With the key inside [search].
    """
    if not space.variables:
        return ()
    return tuple(_start_set(entry, f"starts[{i}]", folder, space, study) for i, entry in enumerate(entries))


def _start_set(entry: str | StartTable, key: str, folder: Path, space: DecisionSpace, study: GainsSource) -> StartSet:
    if isinstance(entry, StartTable):
        return _given_set(entry, key, space)
    if entry == SHIPPED:
        with located(None, key):
            return shipped_set(study.shipped_front(), space)
    path = folder / entry if (folder / entry).exists() else Path(entry)
    if not path.exists():
        message = f"there is no results folder or gains.json {entry}; the path is relative to the study file or to this folder"
        raise InputError(message, key=key)
    try:
        points = _points_of(path, space, study.earlier_gains(gains_file_of(path)))
    except InputError as error:
        raise InputError(f"{path}: {error}" if error.file is None else str(error), key=key) from None
    return StartSet(entry, points)


def shipped_set(front: ShippedFront, space: DecisionSpace) -> StartSet:
    """Return the points of a front that comes with the tool; InputError where it has none of the searched gains."""
    points = tuple(_point(space, point, dict.fromkeys(point, 1.0)) for point in front.points)
    if not any(points):
        searched = listing([each.name for each in space.variables])
        raise InputError(f"{front.origin} has none of the gains of this study ({searched}); leave starts out")
    return StartSet(front.origin, points)


def _given_set(table: StartTable, key: str, space: DecisionSpace) -> StartSet:
    names = [variable.name for variable in space.variables]
    if not table.points or not all(table.points):
        raise InputError(
            'given no point; write points = [{ "roll.k1" = 20.0 }], with searched gains', key=f"{key}.points"
        )
    for i, point in enumerate(table.points):
        for name in point:
            if name not in names:
                raise UnknownNameError("searched gain", name, names, key=f"{key}.points[{i}].{name}")
    return StartSet(table.origin, tuple(table.points))


def _points_of(path: Path, space: DecisionSpace, gains: EarlierGains) -> tuple[Point, ...]:
    """Return the points of a results folder or gains.json for a study; best spread first."""
    if not path.is_dir():
        points = [_point(space, gains.values, gains.factors)]
        rows = np.zeros(1, dtype=int)
    else:
        front = read_front(path)
        points = [_point(space, front.gains(row), gains.factors) for row in range(len(front.rows))]
        rows = spread_order(front)
    if not any(points):
        searched = listing([each.name for each in space.variables])
        raise InputError(f"it searched none of the gains of this study ({searched}); give a run that did")
    return tuple(points[row] for row in rows)


def spread_order(front: FrontTable) -> np.ndarray:
    """Return at most `MAX_POINTS` rows of a front: those that add most to the hypervolume first."""
    number = len(front.values)
    if number < 2:
        return np.arange(number)
    first = select_subset(front.values, front.baseline, min(MAX_POINTS, number - 1))
    last = [row for row in range(number) if row not in first.tolist()][: MAX_POINTS - len(first)]
    return np.array([*first.tolist(), *last], dtype=int)


def _point(space: DecisionSpace, values: Mapping[str, float], factors: Mapping[str, float]) -> Point:
    """Return the values of variables, each from its first gain at hand."""
    point = dict[str, float]()
    for variable in space.variables:
        addresses = [address for address in variable.addresses if address in values and address in factors]
        if addresses:
            value = values[addresses[0]] * factors[addresses[0]]
            if not isfinite(value):
                raise InputError(f"its {addresses[0]} is {value}, which is no gain; give an undamaged folder")
            point[variable.name] = value
    return point
