"""From entrants to what is flown: the same scenarios, objectives and limits for all, each with its own controller and airframe.

All contenders fly as given, on scenarios of a stream of their own, which no search, no held-out
check and no confirmation has seen.
"""

from dataclasses import dataclass, replace

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.risk import minimum_samples
from objectives.risk.measures import TAIL_SCENARIOS
from plant.errors import InputError
from plant.texts import PlainTable
from plant.ties import increasing_order
from tuner.experiments.compare.entrants import Entrant
from tuner.experiments.compare.flying import ComparedPoint, PreparedContender, comparison_problem
from tuner.experiments.tuning.ending import contender_ending
from tuner.study.comparison import ComparisonStudy, Contender, slug_of
from tuner.study.study import TuningStudy
from tuner.text.toml_text import tables_in

COMPARE = "compare"
"""Name of the stream of scenarios."""
MAX_POINTS = 40
"""Points of a front that are flown at most; more do not show."""
# Two control periods are the same within rounding.
SAME = 1e-9


@dataclass(frozen=True)
class ComparisonPlan:
    """A comparison that can be flown. contenders: of the study, in the order of the entrants, with the fronts behind them."""

    study: ComparisonStudy
    entrants: list[Entrant]
    contenders: list[PreparedContender]
    warnings: list[str]

    @property
    def entries(self) -> list[ComparedPoint]:
        """The points compared."""
        return [points.entry for points in self.contenders]

    @property
    def flights(self) -> int:
        """Number of flights."""
        return self.study.flights_each * sum(1 + len(points.offered or ()) for points in self.contenders)


def plan_comparison(entrants: list[Entrant], base: TuningStudy) -> ComparisonPlan:
    """Check entrants against the scenarios of a study; InputError names one that cannot fly them."""
    study = study_of_all(entrants, base)
    warnings = differences(entrants, study, base)
    contenders = []
    for entrant, contender in zip(entrants, study.contenders, strict=True):
        shown = thinned(entrant, np.arange(len(entrant.points))) if same_objectives(entrant, base) else None
        if shown is not None and len(shown.points) < len(entrant.points):
            warnings.append(f"Of the {len(entrant.points)} points of {entrant.name} {len(shown.points)} were flown.")
        contenders.append(_prepared(entrant, shown, contender, study, base))
    return ComparisonPlan(study, entrants, contenders, warnings)


def _prepared(
    entrant: Entrant, shown: Entrant | None, contender: Contender, study: ComparisonStudy, base: TuningStudy
) -> PreparedContender:
    """Return an entrant at its gains; shown: with the points of its front that are flown, None where it has none here."""
    row = contender.study.row_of(entrant.controller, entrant.source)
    entry = ComparedPoint(contender, entrant.point, row, comparison_problem(study, contender))
    # Who has no front of its own in these objectives is one point among the fronts of the others.
    front = [] if shown is None else entries_of(shown, entry, same_flights(entrant, base))
    ending = () if entrant.feasible else tuple(contender_ending(entrant.name, entrant.point))
    return PreparedContender(entry, entrant.why, front or None, None, 0, [], ending)


def base_study(entrants: list[Entrant], given: TuningStudy | None, seeds: int | None) -> TuningStudy:
    """Return the study whose scenarios are flown: the one given, else that of the first results folder.

    seeds: flights of each scenario, by default the study's held_out. InputError where there is no study at all.
    """
    study = given or next((entrant.study for entrant in entrants if entrant.study is not None), None)
    if study is None:
        raise InputError(
            "gains files hold no scenarios, and no results folder is given; add --study FILE, for instance "
            "--study quickstart",
            key="--study",
        )
    if seeds is None:
        return study
    return replace(study, scenarios=tuple(replace(entry, held_out=seeds) for entry in study.scenarios))


def study_of_all(entrants: list[Entrant], base: TuningStudy) -> ComparisonStudy:
    """Return the comparison of all entrants on the scenarios of a study; InputError names an entrant that cannot fly them."""
    contenders = tuple(
        Contender(entrant.name, f"{i + 1}-{slug_of(entrant.name)}", entrant_study(entrant, base), {})
        for i, entrant in enumerate(entrants)
    )
    title = f"{' / '.join(entrant.name for entrant in entrants)} on {base.title}"
    return ComparisonStudy(base.path, title, "", base.seed, contenders, COMPARE)


def entrant_study(entrant: Entrant, base: TuningStudy) -> TuningStudy:
    """Return the base study with an entrant's controller and airframe; InputError for another kind or period."""
    if entrant.flies != base.flies:
        raise InputError(
            f"controls {entrant.flies}, and {base.path} flies {base.flies}; compare controllers of one kind",
            file=entrant.source,
        )
    period, shared = entrant.controller.control_period, base.system.timing.control_period
    if abs(period - shared) > SAME * shared:
        raise InputError(
            f"given a control period of {period:g} s; the scenarios of {base.path} are drawn at {shared:g} s, and air is the "
            "same for all only at one period; choose another --study",
            file=entrant.source,
            key=base.period_key,
        )
    searched, flown = entrant.study or base, base.under(entrant.controller, entrant.source)
    row = flown.row_of(entrant.controller, entrant.source)
    space = DecisionSpace((), (), tuple(row.tolist())) if entrant.study is None else searched.space
    return replace(flown, space=space, search=searched.search, pick=searched.pick, screens=())


def thinned(entrant: Entrant, objective: np.ndarray) -> Entrant:
    """Return an entrant with at most `MAX_POINTS` points of its front.

    They lie evenly along the values (n,) of an objective. The point it recommends stays, wherever it lies.
    """
    count = len(entrant.points)
    if count <= MAX_POINTS:
        return entrant
    order = increasing_order(objective)
    subset = set(order[np.linspace(0, count - 1, MAX_POINTS).round().astype(int)].tolist())
    subset |= {i for i, point in enumerate(entrant.points) if point == entrant.point}
    rows = sorted(subset)
    return replace(
        entrant, points=tuple(entrant.points[i] for i in rows), rows=entrant.rows[rows], picked=entrant.picked[rows]
    )


def entries_of(entrant: Entrant, at: ComparedPoint, same_flights: bool) -> list[ComparedPoint]:
    """Return an entry for each point of a front; at: the entry of the same controller at its recommended point.

    same_flights: whether its run flew what is flown here, so that its held-out values are values of the same thing.
    """
    return [
        replace(at, point=point, row=row, picked=values if same_flights else None)
        for point, row, values in zip(entrant.points, entrant.rows, entrant.picked, strict=True)
    ]


def same_objectives(entrant: Entrant, base: TuningStudy) -> bool:
    """Return True if an entrant has a front in a study's objectives."""
    if entrant.study is None or not entrant.points:
        return False
    return [entry.label for entry in entrant.study.objectives] == [entry.label for entry in base.objectives]


def differences(entrants: list[Entrant], study: ComparisonStudy, base: TuningStudy) -> list[str]:
    """Return warnings about differences between entrants and about too few flights."""
    warnings = []
    for entrant in entrants:
        if entrant.study is not None and not same_flights(entrant, base):
            warnings.append(f"{entrant.name} was tuned on other scenarios than those flown here.")
        if entrant.study is not None and entrant.points and not same_objectives(entrant, base):
            warnings.append(f"{entrant.name} was tuned for other objectives, so its front is not laid over the others.")
        if entrant.study is not None and _plant(entrant.study) != _plant(base):
            warnings.append(f"{entrant.name} was tuned on another plant, or other actuators, than those flown here.")
    frames = dict.fromkeys(contender.study.flown for contender in study.contenders)
    if len(frames) > 1:
        warnings.append(
            f"The airframes differ ({', '.join(frames)}): what differs is not due to the controllers alone."
        )
    return [*warnings, *_few_flights(base)]


def same_flights(entrant: Entrant, base: TuningStudy) -> bool:
    """Return True if an entrant's run flew a study's scenarios, however many."""
    return entrant.study is not None and _flown(entrant.study) == _flown(base)


def _flown(study: TuningStudy) -> list[PlainTable]:
    scenarios = tables_in(study.comparable()["scenario"])
    return [{key: value for key, value in entry.items() if key not in ("search", "held_out")} for entry in scenarios]


def _plant(study: TuningStudy) -> object:
    """Return the plant under a plant study's loops; nothing for a quadrotor's airframe."""
    values = study.comparable()
    return [values.get("plant"), values.get("actuator")]


def _few_flights(base: TuningStudy) -> list[str]:
    warnings = []
    for objective in base.objectives:
        have = sum(entry.held_out for entry in base.scenarios if objective.scenario in (None, entry.spec.name))
        need = minimum_samples(objective.risk)
        if have < need:
            warnings.append(
                f"{objective.label} rests on {have} flights; {need} would put {TAIL_SCENARIOS} into its tail (--seeds)."
            )
    return warnings
