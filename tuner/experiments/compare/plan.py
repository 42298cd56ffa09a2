"""From entrants to a contest: the same scenarios, objectives and limits for all, each with its own controller and airframe.

A comparison is a contest whose contenders all fly as given, on scenarios of a stream of its own, which no search, no held-out
check and no confirmation has seen.
"""

from collections import Counter
from dataclasses import dataclass, replace
from functools import singledispatch

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.plant_system import PlantSystem
from objectives.problem import System
from objectives.risk import minimum_samples
from objectives.risk.measures import TAIL_SCENARIOS
from plant.errors import InputError
from plant.loop import Timing
from plant.model.plan import Channel, plan_loop
from plant.nominal import nominal
from tuner.experiments.compare.entrants import Entrant
from tuner.experiments.contest.flying import ContestPoint, comparison_problem
from tuner.experiments.contest.tuning import Prepared
from tuner.experiments.tuning.ending import contender_ending
from tuner.gains import Controller
from tuner.study.contest import Contender, Contest
from tuner.study.contest_reading import slug_of
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study, TuningStudy
from tuner.study.tuned_loops import TunedLoops
from tuner.text.input_errors import located
from tuner.text.sentences import listing

COMPARE = "compare"
"""Name of the stream of scenarios."""
MOST_POINTS = 40
"""Points of a front that are flown at most; more do not show."""
# Two control periods are the same within rounding.
SAME = 1e-9


@dataclass(frozen=True)
class ComparisonPlan:
    """A comparison that can be flown. contenders: of the contest, in the order of the entrants, with the fronts behind them."""

    contest: Contest
    entrants: list[Entrant]
    contenders: list[Prepared]
    warnings: list[str]

    @property
    def entries(self) -> list[ContestPoint]:
        """The points compared."""
        return [own.entry for own in self.contenders]

    @property
    def flights(self) -> int:
        """Number of flights."""
        return self.contest.flights_each * sum(1 + len(own.offered or ()) for own in self.contenders)


def plan_comparison(entrants: list[Entrant], base: TuningStudy) -> ComparisonPlan:
    """Check entrants against the scenarios of a study; InputError names one that cannot fly them."""
    contest = contest_of(entrants, base)
    warnings = differences(entrants, base)
    contenders = []
    for entrant, contender in zip(entrants, contest.contenders, strict=True):
        shown = thinned(entrant, np.arange(len(entrant.points))) if same_objectives(entrant, base) else None
        if shown is not None and len(shown.points) < len(entrant.points):
            warnings.append(f"Of the {len(entrant.points)} points of {entrant.name} {len(shown.points)} were flown.")
        contenders.append(_prepared(entrant, shown, contender, contest, base))
    return ComparisonPlan(contest, entrants, contenders, warnings)


def _prepared(
    entrant: Entrant, shown: Entrant | None, contender: Contender, contest: Contest, base: TuningStudy
) -> Prepared:
    """Return an entrant at its gains; shown: with the points of its front that are flown, None where it has none here."""
    row = row_in(contender.study, entrant)
    entry = ContestPoint(contender, entrant.point, row, comparison_problem(contest, contender))
    # Who has no front of its own in these objectives is one point among the fronts of the others.
    front = [] if shown is None else entries_of(shown, entry, same_flights(entrant, base))
    ending = () if entrant.feasible else tuple(contender_ending(entrant.name, entrant.point))
    return Prepared(entry, entrant.why, front or None, None, 0, [], ending)


def base_study(entrants: list[Entrant], given: TuningStudy | None, seeds: int | None) -> TuningStudy:
    """Return the study whose scenarios are flown: the one given, else that of the first results folder.

    seeds: flights of each scenario, by default the study's held_out. InputError where there is no study at all.
    """
    found = given or next((entrant.study for entrant in entrants if entrant.study is not None), None)
    if found is None:
        raise InputError(
            "gains files hold no scenarios, and no results folder is given; add --study FILE, for instance "
            "--study quickstart",
            key="--study",
        )
    if seeds is None:
        return found
    return replace(found, scenarios=tuple(replace(entry, held_out=seeds) for entry in found.scenarios))


def contest_of(entrants: list[Entrant], base: TuningStudy) -> Contest:
    """Return the contest of all entrants on the scenarios of a study; InputError names an entrant that cannot fly them."""
    contenders = tuple(
        Contender(entrant.name, f"{i + 1}-{slug_of(entrant.name)}", entrant_study(entrant, base), {})
        for i, entrant in enumerate(entrants)
    )
    title = f"{' / '.join(entrant.name for entrant in entrants)} on {base.title}"
    return Contest(base.path, title, "", base.seed, contenders, (), (), {}, COMPARE)


def entrant_study(entrant: Entrant, base: TuningStudy) -> TuningStudy:
    """Return the base study with an entrant's controller in it, and its airframe; InputError where it is for another kind."""
    if isinstance(base, PlantStudy) != isinstance(entrant.controller, TunedLoops):
        kinds = ("a plant of one's own", "a quadrotor")
        mine, its = kinds if isinstance(entrant.controller, TunedLoops) else kinds[::-1]
        raise InputError(
            f"controls {mine}, and {base.path} flies {its}; compare controllers of one kind", file=entrant.source
        )
    period, shared = entrant.controller.control_period, base.system.timing.control_period
    if abs(period - shared) > SAME * shared:
        raise InputError(
            f"given a control period of {period:g} s; the scenarios of {base.path} are drawn at {shared:g} s, and air is the "
            "same for all only at one period; choose another --study",
            file=entrant.source, key=f"{'' if isinstance(base, PlantStudy) else 'controller.'}control_period",
        )  # fmt: skip
    own, found = entrant.study or base, under(base, entrant)
    space = DecisionSpace((), (), tuple(row_in(found, entrant).tolist())) if entrant.study is None else own.space
    return replace(found, space=space, search=own.search, pick=own.pick, screens=())


def row_in(study: TuningStudy, entrant: Entrant) -> np.ndarray:
    """Return the gains row (g,) of an entrant in the columns of a study under its controller."""
    controller = entrant.controller
    return (
        controller.row(study.system, entrant.source)
        if isinstance(controller, TunedLoops)
        else np.array(controller.gains)
    )


@singledispatch
def under(base: TuningStudy, entrant: Entrant) -> TuningStudy:
    """Return a study under the controller of an entrant."""
    raise TypeError(f"no {base.kind} under {entrant.name}")


@under.register
def _(base: Study, entrant: Entrant) -> Study:
    controller = entrant.controller
    assert isinstance(controller, Controller)
    vehicle, period = controller.airframe.vehicle, controller.control_period
    knowledge = nominal(vehicle, controller.options, period)
    timing = Timing(base.system.timing.control_period, controller.plant_step)
    system = System(vehicle, controller.cascade, knowledge, base.system.limits, timing)
    return replace(base, airframe=controller.airframe, options=controller.options, system=system)


@under.register
def _(base: PlantStudy, entrant: Entrant) -> PlantStudy:
    loops = entrant.controller
    assert isinstance(loops, TunedLoops)
    with located(entrant.source, ""):
        return replace(base, system=system_under(loops, base))


def system_under(loops: TunedLoops, base: PlantStudy) -> PlantSystem:
    """Return the plant of a study under other loops, lost at the errors of the study's own; InputError where they do not fit."""
    system = base.system
    limits = {(each.name, each.output): each.limit for each in system.plan.outer}
    channels = [replace(each, limit=limits.get((each.name, each.output), each.limit)) for each in loops.channels]
    plan = plan_loop(system.plant, channels, system.plan.actuators)
    asked = {
        axis
        for quantity in (*base.objectives, *[each.objective for each in base.constraints])
        for axis in quantity.metric.axes
    }
    missing = sorted(asked - set(plan.names))
    if {(each.name, each.output) for each in plan.outer} != set(limits) or missing:
        raise InputError(
            f"its loops follow references in {_words(plan.outer)}, those of {base.path} in {_words(system.plan.outer)}"
            f"{f', and it judges {listing(missing)}' if missing else ''}; compare loops for the same outputs",
            key="channels",
        )
    return replace(system, plan=plan)


def _words(channels: tuple[Channel, ...]) -> str:
    return listing(f"{each.name} (output {each.output})" for each in channels)


def thinned(entrant: Entrant, objective: np.ndarray) -> Entrant:
    """Return an entrant with at most `MOST_POINTS` points of its front, evenly along the values (n,) of an objective.

    The point it recommends stays, wherever it lies.
    """
    count = len(entrant.points)
    if count <= MOST_POINTS:
        return entrant
    order = np.argsort(objective, kind="stable")
    kept = set(order[np.linspace(0, count - 1, MOST_POINTS).round().astype(int)].tolist())
    kept |= {i for i, point in enumerate(entrant.points) if point == entrant.point}
    rows = sorted(kept)
    return replace(
        entrant, points=tuple(entrant.points[i] for i in rows), rows=entrant.rows[rows], picked=entrant.picked[rows]
    )


def entries_of(entrant: Entrant, at: ContestPoint, same_flights: bool) -> list[ContestPoint]:
    """Return an entry for each point of a front; at: the entry of the same controller at its recommended point.

    same_flights: whether its run flew what is flown here, so that its held-out values are values of the same thing.
    """
    return [
        replace(at, point=point, row=row, picked=values if same_flights else None)
        for point, row, values in zip(entrant.points, entrant.rows, entrant.picked, strict=True)
    ]


def same_objectives(entrant: Entrant, base: TuningStudy) -> bool:
    """Return whether an entrant has a front in the objectives of a study."""
    if entrant.study is None or not entrant.points:
        return False
    return [entry.label for entry in entrant.study.objectives] == [entry.label for entry in base.objectives]


def differences(entrants: list[Entrant], base: TuningStudy) -> list[str]:
    """Return what a reader must know of entrants that were not made for these flights, and of too few flights."""
    warnings = []
    for entrant in entrants:
        if entrant.study is not None and not same_flights(entrant, base):
            warnings.append(f"{entrant.name} was tuned on other scenarios than those flown here.")
        if entrant.study is not None and entrant.points and not same_objectives(entrant, base):
            warnings.append(f"{entrant.name} was tuned for other objectives, so its front is not laid over the others.")
        if entrant.study is not None and _plant(entrant.study) != _plant(base):
            warnings.append(f"{entrant.name} was tuned on another plant, or other actuators, than those flown here.")
    controllers = [entrant.controller for entrant in entrants]
    frames = Counter(each.airframe.name for each in controllers if isinstance(each, Controller))
    if len(frames) > 1:
        warnings.append(
            f"The airframes differ ({', '.join(frames)}): what differs is not due to the controllers alone."
        )
    return [*warnings, *_few_flights(base)]


def same_flights(entrant: Entrant, base: TuningStudy) -> bool:
    """Return whether the run of an entrant flew scenarios of the kind that a study flies, however many."""
    return entrant.study is not None and _flown(entrant.study) == _flown(base)


def _flown(study: TuningStudy) -> list[dict[str, object]]:
    scenarios = study.comparable()["scenario"]
    return [{key: value for key, value in entry.items() if key not in ("search", "held_out")} for entry in scenarios]


def _plant(study: TuningStudy) -> object:
    """Return what flies under the loops of a study of a plant of the user's own; nothing for a quadrotor's airframe."""
    values = study.comparable() if isinstance(study, PlantStudy) else {}
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
