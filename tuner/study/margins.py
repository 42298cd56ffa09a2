"""The [[margin]] tables: stability margins that gains must have before they are flown.

Margins are those of the loop as it is flown: laws, observers, rotor lag, delay and sampling, at hover and in the trims of the
study's scenarios. All tables of a study are answered together, from one evaluation for each choice of state, spread and smallest
amplitude that they make.
"""

from collections.abc import Callable, Iterable
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from objectives.margins.quantities import LIMITABLE, MarginQuantity
from objectives.margins.requirement import MarginRequirement, requirement_label
from objectives.margins.steady_state import HOVER, SteadyState
from objectives.requirements import Array, Screen, worst_place, worst_value
from objectives.system import System
from plant.errors import InputError, UnknownNameError
from plant.loop import Timing
from plant.quadrotor.cascade import AXES, Cascade
from plant.quadrotor.gains import GROUPS
from plant.quadrotor.nominal import Nominal
from plant.quadrotor.scenarios import ScenarioSpec, Spread
from plant.quadrotor.vehicle import Vehicle
from tuner.study.schema import MarginTable
from tuner.study.trim import holds_place, hover_of, steady_states
from tuner.text.units import after_number

if TYPE_CHECKING:
    from objectives.margins.describing import Case
    from objectives.margins.loop_margins import LoopMargins
    from objectives.margins.margins import MarginModel
    from objectives.margins.trim import Trim


BuildMargins = Callable[[bool, "tuple[Case, ...]"], "LoopMargins"]

# Axes whose loops attitude mode leaves open.
OPEN = ("x", "y")
# Largest amplitude that margins may be asked from; the largest that is looked at anyway.
LARGEST_AMPLITUDE = 2.0
# Share of a limit by which the margins of attitude loops inside position loops that wait are inexact in a search.
INEXACT = 0.03
# Where a limit holds.
TRIMS = "trims"
STATES = (TRIMS, HOVER)


def margin_requirement(table: MarginTable, timing: Timing, scenarios: tuple[ScenarioSpec, ...]) -> MarginRequirement:
    """Return the requirement of a [[margin]] table; raises InputError with the key inside the table."""
    if table.quantity not in LIMITABLE:
        raise UnknownNameError("margin", table.quantity, LIMITABLE, key="quantity")
    quantity = LIMITABLE[table.quantity]
    axes, limit = _axes(table, quantity, holds_place(scenarios, timing)), margin_limit(table, quantity)
    if table.spread and all(spec.spread == Spread() and spec.uncertainty is None for spec in scenarios):
        raise InputError(
            "no scenario spreads the airframe; write a [scenario.spread], or leave spread out", key="spread"
        )
    check_amplitude(table)
    if table.at not in STATES:
        raise UnknownNameError("steady state", table.at, STATES, key="at")
    in_trims = table.at == TRIMS
    label = requirement_label(
        quantity.name, table.axis, hard=table.hard, spread=table.spread, amplitude=table.amplitude, in_trims=in_trims
    )
    return MarginRequirement(quantity, label, axes, limit, table.hard, table.spread, table.amplitude, in_trims)


def margin_screen(
    limits: tuple[MarginRequirement, ...], path: Path, system: System, scenarios: tuple[ScenarioSpec, ...]
) -> Screen:
    """Return all requirements on margins as one screen; errors of its analysis name path and the key "margin"."""
    analysis = MarginAnalysis(limits, system, scenarios, path)
    requirements = tuple(entry.requirement for entry in limits)
    if len(analysis.states) == 1:
        return Screen(requirements, analysis.at_hover)
    names = tuple(state.name for state in analysis.states)
    return Screen(requirements, analysis.at_hover, analysis.in_search, analysis.values, names, analysis.by_state)


@lru_cache(maxsize=16)
def nominal_margins(
    cascade: Cascade, nominal: Nominal, timing: Timing, vehicle: Vehicle, trim: "Trim", exact: bool
) -> "MarginModel":
    """Return the nominal vehicle's margins in a trim, at all amplitudes.

    Cached, because a run needs them several times. No argument has a default: the cache takes a call that leaves one out for
    another one, and a run built two of its models twice.
    """
    from objectives.margins.margins import MarginModel

    return MarginModel(cascade, nominal, timing, vehicle, trim, exact=exact)


class MarginValues:
    """Values of requirements on margins; models are built when they are first needed, which takes 0.3 s each.

    build(spread, cases): the margins of a study's loop. Errors of its building name path and the key "margin".
    """

    def __init__(self, limits: tuple[MarginRequirement, ...], build: BuildMargins, path: Path) -> None:
        self._limits, self._build, self._path = limits, build, path
        self._models: dict[tuple[bool, float], LoopMargins] = {}
        # A candidate is asked for by the search, before its flights and among the finalists.
        self._cached: dict[bytes, Array] = {}

    def values(self, gains: Array) -> Array:
        """Return the values (n, requirements) of gains rows (n, gains).

        Infinite are gain, phase and delay margins that no crossing limits, and peaks of loops that are not stable.
        """
        new = {row.tobytes(): row for row in gains if row.tobytes() not in self._cached}
        if new:
            self._cached |= dict(zip(new, self._values(np.array(list(new.values()))), strict=True))
        rows = [self._cached[row.tobytes()] for row in gains]
        return np.array(rows).reshape(len(gains), len(self._limits))

    def _values(self, gains: Array) -> Array:
        values = np.zeros((len(gains), len(self._limits)))
        for choice in sorted({_choice(entry) for entry in self._limits}):
            columns = [i for i, entry in enumerate(self._limits) if _choice(entry) == choice]
            values[:, columns] = self.model(*choice).limited(gains, [self._limits[i] for i in columns])
        return values

    def model(self, spread: bool, amplitude: float) -> "LoopMargins":
        """Margins in all amplitudes from one on: of the nominal plant, with spread in the worst of corners or extremes too."""
        choice = (spread, amplitude)
        if choice not in self._models:
            try:
                self._models[choice] = self._build(spread, cases_from(amplitude))
            except InputError as error:
                raise InputError(error.message, file=self._path, key="margin") from None
        return self._models[choice]


def cases_from(amplitude: float) -> "tuple[Case, ...]":
    """Return the amplitudes that margins are taken over from one on."""
    # Here, because a study that asks for no margins needs no CasADi.
    from objectives.margins.describing import DEFAULT_CASES, Case

    larger = [case for case in DEFAULT_CASES if case.amplitude is not None and case.amplitude > amplitude]
    return (Case(amplitude), *larger) if amplitude > 0.0 else DEFAULT_CASES


class MarginAnalysis:
    """Requirements on the margins of a quadrotor in several steady states.

    states: by default those of its scenarios, hover first, and hover alone where no requirement holds in trims.
    """

    def __init__(
        self,
        limits: tuple[MarginRequirement, ...],
        system: System,
        scenarios: tuple[ScenarioSpec, ...],
        path: Path,
        states: tuple[SteadyState, ...] | None = None,
    ) -> None:
        self._system, self._scenarios = system, scenarios
        self._requirements = tuple(entry.requirement for entry in limits)
        trimmed = any(entry.in_trims for entry in limits)
        self.states = states or (steady_states(scenarios, system) if trimmed else hover_of(scenarios, system.timing))
        self._in_trims = np.array([entry.in_trims for entry in limits], dtype=bool)
        in_trims = tuple(entry for entry in limits if entry.in_trims)

        def analyses(exact: bool) -> list[MarginValues]:
            return [
                MarginValues(in_trims if i else limits, partial(self._margins, state, exact), path)
                for i, state in enumerate(self.states)
            ]

        self._values = analyses(exact=False)
        # Where position loops wait, exact margins of the attitude loops take 0.1 s a candidate and state.
        self._exact = analyses(exact=True) if system.cascade.position_every > 1 else []

    def at_hover(self, gains: Array) -> Array:
        """Return the values (n, requirements) of gains rows (n, gains) at hover."""
        return self._values[0].values(gains)

    def in_search(self, gains: Array) -> Array:
        """Return the worst values (n, requirements) over the trims that a search looks at."""
        trims = range(1, len(self.states))
        return self._worst([i for i in trims if not self.states[i].is_diagonal] or trims, gains)

    def values(self, gains: Array) -> Array:
        """Return the worst values (n, requirements) over all steady states."""
        values = self._worst(range(len(self.states)), gains)
        near = np.flatnonzero(np.any(np.abs(self._excess(values)) < INEXACT, axis=1)) if self._exact else []
        if len(near):
            values[near] = self.exact(gains[near])
        return values

    def exact(self, gains: Array) -> Array:
        """Return the exact worst values (n, requirements) over all steady states."""
        return worst_value(self._requirements, self.by_state(gains))

    def by_state(self, gains: Array) -> Array:
        """Return the values (states, n, requirements); of a requirement at hover alone the best value there is elsewhere."""
        analyses = self._exact or self._values
        return np.stack([self._everywhere(i, values.values(gains)) for i, values in enumerate(analyses)])

    def worst_states(self, row: Array) -> list[str | None]:
        """Return by requirement the worst steady state of a gains row (gains,).

        None where there is only one state.
        """
        if len(self.states) == 1:
            return [None] * len(self._requirements)
        values = self.by_state(row[None])[:, 0]
        worst = [worst_place(values[:, i], entry.sense) for i, entry in enumerate(self._requirements)]
        return [self.states[i].name for i in worst]

    def _worst(self, states: Iterable[int], gains: Array) -> Array:
        values = [self._everywhere(i, self._values[i].values(gains)) for i in states]
        return worst_value(self._requirements, np.stack(values))

    def _excess(self, values: Array) -> Array:
        return np.stack([entry.excess(values[:, i]) for i, entry in enumerate(self._requirements)], axis=1)

    def _everywhere(self, i: int, values: Array) -> Array:
        """Return values of the i-th state's requirements as values of all.

        Those that do not hold in this state get the best value.
        """
        if i == 0:
            return values
        best = [np.inf if entry.sense == "min" else -np.inf for entry in self._requirements]
        everywhere = np.tile(best, (len(values), 1))
        everywhere[:, self._in_trims] = values
        return everywhere

    def _margins(self, state: SteadyState, exact: bool, spread: bool, cases: "tuple[Case, ...]") -> "MarginModel":
        from objectives.margins.describing import DEFAULT_CASES
        from objectives.margins.margins import MarginModel, spread_corners

        system, vehicles = self._system, dict.fromkeys([self._system.vehicle])
        for spec in self._scenarios if spread else ():
            corners = spread_corners(system.vehicle, spec.spread)
            extremes = () if spec.uncertainty is None else spec.uncertainty.extremes(system.vehicle)
            # One that cannot hold the wind has no steady flight there whose loops could be judged.
            judged = [one for one in (*corners, *extremes) if not state.moves or state.can_hold(one, system.nominal)]
            vehicles |= dict.fromkeys(judged)
        first, *others = vehicles
        if not others and cases is DEFAULT_CASES:
            return nominal_margins(system.cascade, system.nominal, system.timing, first, state.trim, exact)
        return MarginModel(
            system.cascade,
            system.nominal,
            system.timing,
            first,
            state.trim,
            others=others,
            cases=cases,
            exact=exact,
        )


def _choice(entry: MarginRequirement) -> tuple[bool, float]:
    return entry.spread, entry.amplitude


def _axes(table: MarginTable, quantity: MarginQuantity, held: bool) -> tuple[str, ...]:
    if quantity.is_multiloop:
        if table.axis is not None:
            raise InputError(f"'{quantity.name}' takes all loops at once; leave axis out", key="axis")
        return ()
    if table.axis is not None and table.axis not in GROUPS:
        raise UnknownNameError("axis or group", table.axis, GROUPS, key="axis")
    axes = AXES if table.axis is None else GROUPS[table.axis]
    closed = axes if held else tuple(axis for axis in axes if axis not in OPEN)
    if not closed:
        raise InputError(
            f"given '{table.axis}', but every scenario flies in attitude mode, where x and y are open", key="axis"
        )
    return closed


def check_amplitude(table: MarginTable) -> None:
    """Raise InputError for a smallest amplitude that margins are not evaluated from."""
    if not 0.0 <= table.amplitude <= LARGEST_AMPLITUDE:
        raise InputError(f"given {table.amplitude:g}; allowed: 0 to {LARGEST_AMPLITUDE:g}", key="amplitude")


def margin_limit(table: MarginTable, quantity: MarginQuantity) -> float:
    """Return a table's limit on a quantity, in its unit of limits.

    Raises InputError with the key inside the table.
    """
    given, other = ("min", "max") if quantity.sense == "min" else ("max", "min")
    if getattr(table, other) is not None:
        better = "larger" if quantity.sense == "min" else "smaller"
        raise InputError(f"of '{quantity.name}' {better} values are better; give {given} instead", key=other)
    limit = getattr(table, given)
    if limit is None:
        unit = "" if quantity.limit_unit == "1" else f" in {quantity.limit_unit}"
        raise InputError(f"'{quantity.name}' needs a limit; write {given} = ...{unit}", key=given)
    assert quantity.low is not None, "a limit can be put on it"
    if not quantity.low < limit < quantity.high:
        unit = after_number(quantity.limit_unit)
        allowed = f"above {quantity.low:g}" + (f" and below {quantity.high:g}" if quantity.high < np.inf else "")
        raise InputError(f"given {limit:g}{unit}; allowed: {allowed}{unit}", key=given)
    return float(limit)
