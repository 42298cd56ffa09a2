"""Guarantees of theory for gains."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from plant.loop import Timing
from plant.quadrotor.cascade import AXES
from plant.quadrotor.nominal import nominal
from tuner.analysis.responses import LIMITS, system_of, usual_scenario
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import GainsLike, as_gains
from tuner.api.studies import StudyLike, tuning_study
from tuner.extensions.theory.guarantees import rate_from_observer
from tuner.extensions.theory.theorems import THEOREMS, Setting, Theorem
from tuner.extensions.theory.theorems.disturbance_rate import worst_rates
from tuner.extensions.theory.theorems.guarantee import Guarantee, law_of, loop_of
from tuner.gains import Controller
from tuner.store.document import DocumentPart

if TYPE_CHECKING:
    import pandas as pd

SEED = 1
"""Root seed of the air where no study gives one, as in `fly`."""


class TheoremRow(DocumentPart):
    """A theorem on an axis; value null where infinite; holds: value over disturbance_rate, null for a bound."""

    axis: str
    law: str
    theorem: str
    quantity: str
    value: float | None
    unit: str
    disturbance_rate: float
    rate_unit: str
    holds: bool | None
    assumes: str
    source: str


class TheoryDocument(DocumentPart):
    """Guarantees of theory. level: quantile of the disturbance rates, which are given by axis [rad/s^3 or m/s^3]."""

    scenarios: list[str]
    level: float
    axes: list[str]
    rates: dict[str, float]
    theorems: list[TheoremRow]


@dataclass(frozen=True)
class Theory(Documented):
    """Guarantees of theory for one controller; document: as `tuner theory --json` prints it; control_period [s]."""

    document: TheoryDocument
    control_period: float

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each axis and theorem: value, disturbance rate, and whether the first exceeds the second."""
        return frame(self.document.theorems, ("axis", "theorem"))

    def _repr_html_(self) -> str:
        return shown("Guarantees of theory", (), self.table.reset_index())


def theory(gains: GainsLike, *, study: StudyLike | None = None, level: float = 0.99) -> Theory:
    """Evaluate the theorems for gains on each axis.

    The guarantees are against the disturbance rate of the air.

    Args:
        gains: Gains, or a gains.json.
        study: Study in whose scenarios the disturbance is measured; by default that of `fly`.
        level: Quantile of the measured disturbance rate.

    Returns:
        A row for each axis and theorem that speaks of its law.

    Raises:
        InputError: The gains or the study are wrong, or the gains are those of a plant of your own.

    Examples:
        >>> tuner.theory(gains).document.level
        0.99

    """
    controller = as_gains(gains).quadrotor(
        "holds gains of a plant of one's own, and theorems speak of a quadrotor's axes; `tuner margins` with --certificates "
        "tells what is proved of a plant"
    )
    if study is None:
        specs, seed = (usual_scenario(system_of(controller, LIMITS)),), SEED
    else:
        judging = tuning_study(study, "tuner theory --study")
        specs, seed = tuple(entry.spec for entry in judging.scenarios), judging.seed
    timing = Timing(controller.control_period, controller.plant_step)
    rates = worst_rates(specs, controller.airframe.vehicle, timing, seed, level)
    names = [spec.name for spec in specs]
    rows = theory_rows(controller, rates)
    document = TheoryDocument(scenarios=names, level=level, axes=list(AXES), rates=rates, theorems=rows)
    return Theory(document, timing.control_period)


def theory_rows(controller: Controller, rates: Mapping[str, float]) -> list[TheoremRow]:
    """Return a row for each axis and each applicable theorem.

    holds is None where there is nothing to hold.
    """
    knowledge = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
    rows = []
    for axis in AXES:
        law = law_of(controller.cascade, axis).name
        for theorem in THEOREMS.values():
            if theorem.speaks_of(law, rate_from_observer(knowledge, axis)):
                rows.append(theory_row(theorem, controller, axis, rates[axis]))
    return rows


def theory_row(theorem: Theorem, controller: Controller, axis: str, rate: float) -> TheoremRow:
    """Return the row of one theorem on one axis."""
    guarantee = Guarantee(theorem, controller.cascade, {axis: Setting(controller.control_period, rate)})
    value = float(guarantee.values(np.array([controller.gains]))[0, 0])
    loop = loop_of(axis)
    return TheoremRow(
        axis=axis,
        law=law_of(controller.cascade, axis).name,
        theorem=theorem.name,
        quantity=theorem.quantity,
        value=value if isfinite(value) else None,
        unit=theorem.unit_in(loop),
        disturbance_rate=rate,
        rate_unit="m/s^3" if loop == "position" else "rad/s^3",
        holds=value >= rate if theorem.sense == "min" else None,
        assumes=theorem.assumes,
        source=theorem.source,
    )
