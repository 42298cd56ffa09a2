"""The [[margin]] tables: stability margins that gains must have before they are worth a flight.

Margins are those of hover in still air, of the loop as it is flown: laws, observers, rotor lag, delay and sampling. All tables
of a study are answered together, from one evaluation for each choice of spread and smallest amplitude that they make.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from objectives.margins.quantities import LIMITABLE, MarginQuantity
from objectives.margins.requirement import MarginRequirement, requirement_label
from objectives.problem import System
from objectives.requirements import Array, Screen
from plant.cascade import AXES, Cascade
from plant.errors import InputError, UnknownNameError
from plant.gains import GROUPS
from plant.loop import Timing
from plant.nominal import Nominal
from plant.references.spec import HOLD
from plant.scenarios import ScenarioSpec, Spread
from plant.vehicle import Vehicle
from tuner.study.schema import MarginTable
from tuner.text.units import after_number

if TYPE_CHECKING:
    from objectives.margins.describing import Case
    from objectives.margins.margins import MarginModel


class LoopMargins(Protocol):
    """Margins of a loop that limits are put on, such as `MarginModel`."""

    def limited(self, gains: Array, requirements: Sequence[MarginRequirement]) -> Array:
        """Return the values (n, requirements) of gains rows (n, gains)."""
        ...


BuildMargins = Callable[[bool, "tuple[Case, ...]"], LoopMargins]

# Axes whose loops attitude mode leaves open.
OPEN = ("x", "y")
# Largest amplitude that margins may be asked from; the largest that is looked at anyway.
LARGEST_AMPLITUDE = 2.0


def margin_requirement(table: MarginTable, timing: Timing, scenarios: tuple[ScenarioSpec, ...]) -> MarginRequirement:
    """Return the requirement of a [[margin]] table; raises InputError with the key inside the table."""
    if table.quantity not in LIMITABLE:
        raise UnknownNameError("margin", table.quantity, LIMITABLE, key="quantity")
    quantity = LIMITABLE[table.quantity]
    axes, limit = _axes(table, quantity, holds_place(scenarios, timing)), margin_limit(table, quantity)
    if table.spread and not any(_spreads(spec) for spec in scenarios):
        raise InputError(
            "no scenario spreads the airframe; write a [scenario.spread], or leave spread out", key="spread"
        )
    check_amplitude(table)
    label = requirement_label(
        quantity.name, table.axis, hard=table.hard, spread=table.spread, amplitude=table.amplitude
    )
    return MarginRequirement(quantity, label, axes, limit, table.hard, table.spread, table.amplitude)


def margin_screen(
    asked: tuple[MarginRequirement, ...], path: Path, system: System, scenarios: tuple[ScenarioSpec, ...]
) -> Screen:
    """Return all requirements on margins as one screen; errors of its analysis name path and the key "margin"."""
    analysis = MarginAnalysis(asked, system, scenarios, path)
    return Screen(tuple(entry.requirement for entry in asked), analysis.values)


@lru_cache(maxsize=4)
def nominal_margins(cascade: Cascade, nominal: Nominal, timing: Timing, vehicle: Vehicle, held: bool) -> "MarginModel":
    """Margins of the nominal vehicle in all amplitudes, holding a place or not; a run asks for them several times."""
    from objectives.margins.margins import MarginModel
    from objectives.margins.trim import Trim

    return MarginModel(cascade, nominal, timing, vehicle, Trim(hold=held))


class MarginValues:
    """Values of requirements on margins; models are built when they are first needed, which takes 0.3 s each.

    build(spread, cases): the margins of a study's loop. Errors of its building name path and the key "margin".
    """

    def __init__(self, asked: tuple[MarginRequirement, ...], build: BuildMargins, path: Path) -> None:
        self._asked, self._build, self._path = asked, build, path
        self._models: dict[tuple[bool, float], LoopMargins] = {}
        # A candidate is asked for by the search, before its flights and among the finalists.
        self._known: dict[bytes, Array] = {}

    def values(self, gains: Array) -> Array:
        """Return the values (n, requirements) of gains rows (n, gains).

        Infinite are gain, phase and delay margins that no crossing limits, and peaks of loops that are not stable.
        """
        new = {row.tobytes(): row for row in gains if row.tobytes() not in self._known}
        if new:
            self._known |= dict(zip(new, self._values(np.array(list(new.values()))), strict=True))
        found = [self._known[row.tobytes()] for row in gains]
        return np.array(found).reshape(len(gains), len(self._asked))

    def _values(self, gains: Array) -> Array:
        values = np.zeros((len(gains), len(self._asked)))
        for choice in sorted({_choice(entry) for entry in self._asked}):
            columns = [i for i, entry in enumerate(self._asked) if _choice(entry) == choice]
            values[:, columns] = self.model(*choice).limited(gains, [self._asked[i] for i in columns])
        return values

    def model(self, spread: bool, amplitude: float) -> LoopMargins:
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


class MarginAnalysis(MarginValues):
    """Values of requirements on the margins of a quadrotor."""

    def __init__(
        self, asked: tuple[MarginRequirement, ...], system: System, scenarios: tuple[ScenarioSpec, ...], path: Path
    ) -> None:
        super().__init__(asked, self._margins, path)
        self._system, self._scenarios = system, scenarios

    def _margins(self, spread: bool, cases: "tuple[Case, ...]") -> "MarginModel":
        from objectives.margins.describing import DEFAULT_CASES
        from objectives.margins.margins import MarginModel, spread_corners
        from objectives.margins.trim import Trim

        system, found = self._system, dict.fromkeys([self._system.vehicle])
        for spec in self._scenarios if spread else ():
            found |= dict.fromkeys(spread_corners(system.vehicle, spec.spread))
            found |= dict.fromkeys(() if spec.uncertainty is None else spec.uncertainty.extremes(system.vehicle))
        held = holds_place(self._scenarios, system.timing)
        first, *others = found
        if not others and cases is DEFAULT_CASES:
            return nominal_margins(system.cascade, system.nominal, system.timing, first, held)
        return MarginModel(
            system.cascade, system.nominal, system.timing, first, Trim(hold=held), others=others, cases=cases
        )


def _choice(entry: MarginRequirement) -> tuple[bool, float]:
    return entry.spread, entry.amplitude


def holds_place(scenarios: tuple[ScenarioSpec, ...], timing: Timing) -> bool:
    """Return whether any scenario closes the position loops of x and y; attitude mode leaves them open."""
    return any(bool(np.any(spec.track(timing).samples[:, HOLD] > 0.5)) for spec in scenarios)


def _spreads(spec: ScenarioSpec) -> bool:
    return spec.spread != Spread() or spec.uncertainty is not None


def _axes(table: MarginTable, quantity: MarginQuantity, held: bool) -> tuple[str, ...]:
    if quantity.whole:
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
    """Raise InputError for a smallest amplitude that margins are not looked at from."""
    if not 0.0 <= table.amplitude <= LARGEST_AMPLITUDE:
        raise InputError(f"given {table.amplitude:g}; allowed: 0 to {LARGEST_AMPLITUDE:g}", key="amplitude")


def margin_limit(table: MarginTable, quantity: MarginQuantity) -> float:
    """Return the limit that a table puts on a quantity, in its unit of limits; InputError with the key inside the table."""
    given, other = ("min", "max") if quantity.sense == "least" else ("max", "min")
    if getattr(table, other) is not None:
        better = "larger" if quantity.sense == "least" else "smaller"
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
