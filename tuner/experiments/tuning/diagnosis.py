"""Diagnosis of a limit that no candidate keeps: the loop, the value reached, the gains that move it, what a design reaches.

A margin is asked of several loops at once; here each loop answers for itself. Nothing is flown: what is known without flying is
asked again of the best candidates and of points about them; of flights, only those of the search are used.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import isfinite, sqrt
from statistics import NormalDist

import numpy as np

from objectives.margins.requirement import MarginRequirement
from objectives.mission import OFF_KEY
from objectives.problem import Constraint
from objectives.requirements import Requirement, Screen
from objectives.scales import SCALES
from plant.quadrotor.gains import GainAddress
from plant.ties import first_largest, first_smallest, mean_ranks
from tuner.documents.obstacles import DesignReach, GainAt, UnmetConstraint
from tuner.experiments.tuning.conflicts import number_text
from tuner.experiments.tuning.starts import design_row, study_designs
from tuner.study.margins import MarginAnalysis
from tuner.study.study import SearchedStudy, Study
from tuner.study.trim import hover_of
from tuner.text.sentences import BOUNDS

Array = np.ndarray

# Candidates whose loops are looked at one by one, the closest to a limit first.
MAX_CANDIDATES = 128
# Places of a variable in its range at which a quantity is asked again; factors by which a fixed gain is changed for that.
PLACES, FACTORS = (0.0, 0.25, 0.5, 0.75, 1.0), (0.5, 0.8, 1.25, 2.0)
# Share of the excess over a limit that a gain has to take away alone to be named as the one that moves it.
HELPS = 0.1
# Change of a quantity, as a share of its limit, from which on a gain moves it.
MOVED = 1e-3
# Loops that a position loop flies by.
INNER = {"x": ("pitch",), "y": ("roll",)}
# Chance that a gain without influence is named as moving a flown quantity, over all gains of a study.
ERROR = 0.01


@dataclass(frozen=True)
class Probe:
    """A number that a requirement limits; loop: the one it is read of, None where it is no margin of single loops."""

    requirement: Requirement
    loop: str | None

    def broken(self, values: Array) -> Array:
        """Return by how much values (n,) break the limit, in limits."""
        return self.requirement.violations(values)

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes whose gains close the loop: that of x flies by pitch, that of y by roll."""
        return () if self.loop is None else (self.loop, *INNER.get(self.loop, ()))

    def is_unstable(self, value: float) -> bool:
        """Return True if a value is that of an unstable loop."""
        worst = value <= 0.0 if self.requirement.sense == "min" else not isfinite(value)
        return self.loop is not None and worst

    def moves(self, values: Array, base: float) -> bool:
        """Return True if any of the values (n,) differs significantly from a base; one of an unstable loop does not."""
        if not isfinite(base):
            return bool(np.isfinite(values).any(axis=0))
        least = MOVED * (abs(self.requirement.limit) or 1.0)
        return any(abs(value - base) > least and not self.is_unstable(value) for value in values.tolist())

    def relief(self, values: Array, base: float) -> float:
        """Return the largest share of a violation that values (n,) take away.

        The violation is that at a base.
        """
        before = float(self.broken(np.array([base]))[0])
        return 1.0 - float(self.broken(values).min(axis=0)) / before if before > 0.0 else 0.0


class Diagnosis:
    """The requirements of a study, asked loop by loop. probes: what `values` are of; at_hover: in hover alone, whatever trims."""

    def __init__(self, study: Study, at_hover: bool = False) -> None:
        self._study = study
        self._addresses = study.system.gains
        self._others, self._loops = _split(study)
        specs = tuple(entry.spec for entry in study.scenarios)
        required = tuple(entry for _, entry in self._loops)
        states = hover_of(specs, study.system.timing) if at_hover else None
        self._margins = MarginAnalysis(required, study.system, specs, study.path, states)
        self._read = self._margins.at_hover if at_hover else self._margins.values
        self.probes = (
            *[Probe(requirement, None) for _, _, requirement in self._others],
            *[Probe(requirement, entry.axes[0]) for requirement, entry in self._loops],
        )

    def values(self, gains: Array) -> Array:
        """Return the values (n, probes) of gains rows (n, gains)."""
        return self._values(gains, self._read)

    def exact(self, gains: Array) -> Array:
        """Return the exact values (n, probes) of gains rows (n, gains)."""
        return self._values(gains, self._margins.exact)

    def _values(self, gains: Array, margins: Callable[[Array], Array]) -> Array:
        by_screen = {id(screen): screen.analyse(gains) for screen, _, _ in self._others}
        others = [by_screen[id(screen)][:, i] for screen, i, _ in self._others]
        loops = margins(gains) if self._loops else np.empty((len(gains), 0))
        return np.concatenate([np.reshape(others, (len(others), len(gains))).T, loops], axis=1)

    def worst_states(self, row: Array) -> list[str | None]:
        """Return the worst steady state of a gains row (gains,) by probe; None where there is one state alone."""
        return [None] * len(self._others) + (self._margins.worst_states(row) if self._loops else [])

    @cached_property
    def designed(self) -> Array | None:
        """Gains row (gains,) of `tuner design`, None where no axis can be designed."""
        designs = study_designs(self._study)
        return design_row(self._study, designs) if any(rows.designed for rows in designs.values()) else None

    def obstacles(self, points: Array, names: Sequence[str], labels: Sequence[str]) -> list[UnmetConstraint]:
        """Return the diagnoses of requirements `labels` at points (n, d).

        The points lie in the unit cube and have names. Of the loops of a margin those are named that none of the points
        keeps; where each is kept by some, the worst of the closest point.
        """
        values = self.values(self._study.space.gains(points))
        broken = np.stack([probe.broken(values[:, i]) for i, probe in enumerate(self.probes)], axis=1)
        rows = []
        for label in labels:
            mine = [i for i, probe in enumerate(self.probes) if probe.requirement.label == label]
            closest = first_smallest(broken[:, mine].max(axis=1))
            worst = mine[first_largest(broken[closest, mine])]
            never = [(i, first_smallest(broken[:, i])) for i in mine if (broken[:, i] > 0.0).all()]
            for i, best in never or [(worst, closest)]:
                rows.append(self._obstacle(i, points[best], float(values[best, i]), names[best], len(points)))
        return rows

    def _obstacle(self, i: int, point: Array, value: float, name: str, tried: int) -> UnmetConstraint:
        required, moved = self.probes[i].requirement, self._moved_by(i, point, value, HELPS)
        fixed = [] if moved else self._fixed(i, point, value)
        if not moved and not fixed:
            moved = self._moved_by(i, point, value, None)
        return UnmetConstraint(
            label=required.label,
            loop=self.probes[i].loop,
            **required.units(),
            sense=required.sense,
            limit=required.in_file(required.limit),
            reached=required.in_file(_finite(value)),
            point=name,
            tried=tried,
            moved_by=moved,
            fixed=fixed,
            design=self._design(i),
            automatic="",
        )

    def _moved_by(self, i: int, point: Array, value: float, least: float | None) -> list[str]:
        """Return the searched gains that reduce a probe's violation by a share.

        Each goes through its range from a point (d,), alone. The value of an unstable loop has no information on a stable one:
        its gains count then. least: the share; None: all that move the probe.
        """
        probe = self.probes[i]
        variables, places = self._study.space.variables, len(PLACES)
        changed = np.repeat(point[None], len(variables) * places, axis=0)
        for k in range(len(variables)):
            changed[k * places : (k + 1) * places, k] = PLACES
        values = self.values(self._study.space.gains(changed))[:, i].reshape(len(variables), places)
        owned = {g.address for g in self._addresses if g.axis in probe.axes} if probe.is_unstable(value) else set()
        return [
            variable.name
            for variable, row in zip(variables, values, strict=True)
            if owned & set(variable.addresses)
            or (probe.moves(row, value) if least is None else probe.relief(row, value) >= least)
        ]

    def _fixed(self, i: int, point: Array, value: float) -> list[GainAt]:
        """Return the fixed gains that reduce a probe's violation, the strongest first.

        They are changed at a point (d,). Those of its loop alone, if there are any; all of these where the loop is not stable.
        """
        probe = self.probes[i]
        searched = {column for group in self._study.space.columns for column in group}
        gains = [gain for gain in self._addresses if gain.column not in searched and not gain.info.airframe]
        row = self._study.space.gains(point[None])[0]
        changed = np.repeat(row[None], len(gains) * len(FACTORS), axis=0)
        for k, gain in enumerate(gains):
            changed[k * len(FACTORS) : (k + 1) * len(FACTORS), gain.column] *= FACTORS
        values = self.values(changed)[:, i].reshape(len(gains), len(FACTORS))
        relief = {gain: probe.relief(one, value) for gain, one in zip(gains, values, strict=True)}
        owned = probe.is_unstable(value)
        moving = [gain for gain in gains if relief[gain] >= HELPS or (owned and gain.axis in probe.axes)]
        moving.sort(key=lambda gain: -relief[gain])
        return [_value(gain, row) for gain in [gain for gain in moving if gain.axis == probe.loop] or moving]

    def _design(self, i: int) -> DesignReach | None:
        if self.designed is None:
            return None
        space = self._study.space
        rows = np.stack([self.designed, space.gains(space.point(self.designed)[None])[0]])
        value = self.values(rows)[:, i]
        own_gains = [gain for gain in self._addresses if gain.axis == self.probes[i].loop]
        is_met, in_ranges = (self.probes[i].broken(value) <= 0.0).tolist()
        return DesignReach(
            value=self.probes[i].requirement.in_file(_finite(float(value[0]))),
            kept=is_met,
            in_ranges=in_ranges,
            gains=[_value(gain, self.designed) for gain in own_gains],
        )


Column = tuple[Screen, int, Requirement]


def _split(study: Study) -> tuple[list[Column], list[tuple[Requirement, MarginRequirement]]]:
    """Return requirements by screen and column, and margin requirements by loop."""
    margins = {entry.label: entry for entry in study.loop_requirements()}
    columns = [(screen, i, entry) for screen in study.screens for i, entry in enumerate(screen.requirements)]
    loops = [
        (entry, replace(margins[entry.label], axes=(axis,)))
        for _, _, entry in columns
        if entry.label in margins
        for axis in margins[entry.label].axes
    ]
    return [column for column in columns if column[2].label not in margins], loops


def _value(gain: GainAddress, row: Array) -> GainAt:
    return GainAt(gain=gain.address, value=float(row[gain.column]), unit=gain.unit)


def _finite(value: float) -> float | None:
    return value if isfinite(value) else None


def flown_obstacle(
    study: SearchedStudy, constraint: Constraint, points: Array, values: Array, names: Sequence[str]
) -> UnmetConstraint:
    """Return the diagnosis of a constraint that no flown point satisfies.

    Points are (n, d), the constraint's values there (n,). Gains that move it are those whose rank correlation with it
    is no chance, the strongest first.
    """
    best, objective = first_smallest(values), constraint.objective
    return UnmetConstraint(
        label=objective.label,
        loop=None,
        unit=objective.metric.unit,
        sense="max",
        limit=constraint.most,
        reached=_finite(float(values[best])),
        point=names[best],
        tried=len(points),
        moved_by=_correlated(study, points, values),
        fixed=[],
        design=None,
        automatic=constraint.floor,
    )


def _correlated(study: SearchedStudy, points: Array, values: Array) -> list[str]:
    variables = study.space.variables
    if len(points) < 8 or np.ptp(values) == 0.0:
        return []
    ranks = mean_ranks(values) - 0.5 * (len(values) + 1)
    strength = []
    for i in range(len(variables)):
        own_gains = mean_ranks(points[:, i]) - 0.5 * (len(values) + 1)
        length = float(np.linalg.norm(own_gains) * np.linalg.norm(ranks))
        strength.append(abs(float(own_gains @ ranks)) / length if length > 0.0 else 0.0)
    # Under independence a rank correlation of n pairs has variance 1 / (n - 1); the error is shared among all gains, both signs.
    least = NormalDist().inv_cdf(1.0 - 0.5 * ERROR / len(variables)) / sqrt(len(values) - 1)
    order = sorted(range(len(variables)), key=lambda i: -strength[i])
    return [variables[i].name for i in order if strength[i] > least]


def obstacle_texts(obstacles: Sequence[UnmetConstraint]) -> list[str]:
    """Return obstacles in sentences."""
    return [_obstacle_text(entry, _reached_text(entry)) for entry in obstacles]


def unreached_texts(obstacles: Sequence[UnmetConstraint]) -> list[str]:
    """Return limits that no draw keeps in sentences."""
    return [_obstacle_text(entry, _unreached_text(entry)) for entry in obstacles]


def _of_loop(rows: UnmetConstraint) -> str:
    return "" if rows.loop is None else f" in the {rows.loop} loop"


def _reached_text(rows: UnmetConstraint) -> str:
    looked = "the candidate" if rows.tried == 1 else f"{rows.tried} candidates"
    return (
        f"{rows.label}{_of_loop(rows)} reaches {_shown(rows.reached, rows)} at best ({rows.point}, of {looked} looked at); "
        f"{BOUNDS[rows.sense]} {_shown(rows.limit, rows)} is asked."
    )


def _unreached_text(rows: UnmetConstraint) -> str:
    draws = "with the gains of the study" if rows.tried == 1 else f"in {rows.tried} draws"
    return (
        f"{rows.label} {BOUNDS[rows.sense]} {_shown(rows.limit, rows)} is not reached{_of_loop(rows)} {draws}: "
        f"{_shown(rows.reached, rows)} at best ({rows.point})."
    )


def _obstacle_text(rows: UnmetConstraint, head: str) -> str:
    words = [head]
    if rows.automatic:
        moves = "" if rows.automatic == OFF_KEY else f"{rows.automatic} moves it, "
        off = rows.label.split("(", 1)[1].rsplit(")", 1)[0]
        words.append(
            f'This limit is automatic: {moves}mission.off = ["{off}"] takes it away, and a [[constraint]] '
            "of your own on the same quantity replaces it."
        )
    words.append(_moves_text(rows))
    if rows.design is not None:
        words.append(_design_text(rows.design, rows))
    return " ".join(word for word in words if word)


def _moves_text(rows: UnmetConstraint) -> str:
    if rows.moved_by:
        return f"Searched gains that move it: {', '.join(rows.moved_by)}."
    if rows.fixed:
        return _fixed_text(rows.fixed, "it" if rows.loop is None else "this loop")
    return "No searched gain is seen to move it."


def _fixed_text(fixed: Sequence[GainAt], decided: str) -> str:
    keys = ", ".join(f'"{entry.gain}" = {{}}' for entry in fixed)
    if len(fixed) == 1:
        return f"{_listed(fixed)} is fixed by the study and decides {decided}: write {keys} to search it."
    return f"{_listed(fixed)} are fixed by the study and decide {decided}: write {keys} to search them."


def _design_text(design: DesignReach, rows: UnmetConstraint) -> str:
    reached = f"`tuner design` reaches {_shown(design.value, rows)}"
    own_gains = f" with {_listed(design.gains)}" if design.gains else ""
    if not design.is_satisfied:
        return f"{reached}{own_gains}, which is not enough either: this design cannot meet the limit."
    if design.in_ranges:
        return f'{reached}{own_gains}: let the search start there, search.initial = ["default", "design"].'
    return f"{reached}{own_gains}: give these gains a range in [gains], or these values."


def _listed(values: Sequence[GainAt]) -> str:
    return ", ".join(f"{entry.gain} = {number_text(entry.value, entry.unit)}" for entry in values)


def _shown(value: float | None, rows: UnmetConstraint) -> str:
    if value is None:
        return "no bound"
    scale = SCALES.get(rows.shown_unit or "")
    return number_text(value if scale is None else float(scale.shown(value)), rows.shown_unit or rows.unit)
