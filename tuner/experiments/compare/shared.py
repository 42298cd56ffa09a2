"""From entrants to a contest: the same scenarios, objectives and limits for all, each with its own controller and airframe.

A comparison is a contest whose contenders all fly as given, on scenarios of a stream of its own, which no search, no held-out
check and no confirmation has seen.
"""

from collections import Counter
from dataclasses import replace
from pathlib import Path

from objectives.decisions import DecisionSpace
from objectives.problem import System
from objectives.risk import minimum_samples
from plant.closed_loop import Timing
from plant.errors import InputError
from plant.nominal import nominal
from tuner.experiments.compare.entrants import Entrant
from tuner.study.contest import Contender, Contest
from tuner.study.contest_reading import slug_of
from tuner.study.study import Study

COMPARE = "compare"
"""Name of the stream of scenarios."""
# Two control periods are the same within rounding.
SAME = 1e-9


def base_study(entrants: list[Entrant], given: Study | None, seeds: int | None) -> Study:
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


def contest_of(entrants: list[Entrant], base: Study) -> Contest:
    """Return the contest of all entrants on the scenarios of a study; InputError names an entrant that cannot fly them."""
    contenders = tuple(
        Contender(entrant.name, f"{i + 1}-{slug_of(entrant.name)}", entrant_study(entrant, base), {})
        for i, entrant in enumerate(entrants)
    )
    title = f"{' / '.join(entrant.name for entrant in entrants)} on {base.title}"
    return Contest(base.path, title, "", base.seed, contenders, (), (), {}, COMPARE)


def entrant_study(entrant: Entrant, base: Study) -> Study:
    """Return the base study with an entrant's controller and airframe in it."""
    controller, own = entrant.controller, entrant.study or base
    period, shared = controller.control_period, base.system.timing.control_period
    if abs(period - shared) > SAME * shared:
        raise InputError(
            f"given a control period of {period:g} s; the scenarios of {base.path} are drawn at {shared:g} s, and air is the "
            "same for all only at one period; choose another --study",
            file=entrant.source, key="controller.control_period",
        )  # fmt: skip
    vehicle = controller.airframe.vehicle
    knowledge = nominal(vehicle, controller.options, period)
    timing = Timing(shared, controller.plant_step)
    return replace(
        base,
        airframe=controller.airframe,
        options=controller.options,
        system=System(vehicle, controller.cascade, knowledge, base.system.limits, timing),
        space=DecisionSpace((), (), controller.gains) if entrant.study is None else own.space,
        search=own.search,
        pick=own.pick,
        screens=(),
    )


def same_objectives(entrant: Entrant, base: Study) -> bool:
    """Return whether an entrant has a front in the objectives of a study."""
    if entrant.study is None or not entrant.points:
        return False
    return [entry.label for entry in entrant.study.objectives] == [entry.label for entry in base.objectives]


def what_differs(entrants: list[Entrant], base: Study) -> list[str]:
    """Return what a reader must know of entrants that were not made for these flights, and of too few flights."""
    said = []
    for entrant in entrants:
        if entrant.study is not None and not same_flights(entrant, base):
            said.append(f"{entrant.name} was tuned on other scenarios than those flown here.")
        if entrant.study is not None and entrant.points and not same_objectives(entrant, base):
            said.append(f"{entrant.name} was tuned for other objectives, so its front is not laid over the others.")
    frames = Counter(entrant.controller.airframe.name for entrant in entrants)
    if len(frames) > 1:
        said.append(f"The airframes differ ({', '.join(frames)}): what differs is not due to the controllers alone.")
    return [*said, *_few_flights(base)]


def same_flights(entrant: Entrant, base: Study) -> bool:
    """Return whether the run of an entrant flew scenarios of the kind that a study flies, however many."""
    return entrant.study is not None and _flown(entrant.study) == _flown(base)


def _flown(study: Study) -> list[dict[str, object]]:
    scenarios = study.comparable()["scenario"]
    return [{key: value for key, value in entry.items() if key not in ("search", "held_out")} for entry in scenarios]


def _few_flights(base: Study) -> list[str]:
    said = []
    for objective in base.objectives:
        have = sum(entry.held_out for entry in base.scenarios if objective.scenario in (None, entry.spec.name))
        need = minimum_samples(objective.risk)
        if have < need:
            said.append(f"{objective.label} rests on {have} flights; {need} would put five into its tail (--seeds).")
    return said


def sources(entrants: list[Entrant]) -> list[tuple[Path, str]]:
    """Return where each entrant came from and of which kind that is: "results" or "gains"."""
    return [(entrant.source, "gains" if entrant.study is None else "results") for entrant in entrants]
