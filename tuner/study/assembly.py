"""Assembly of a study, one order of steps for quadrotors and plants."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from objectives.decisions import DecisionSpace
from objectives.metrics import MetricAddress
from objectives.mission import Mission
from objectives.own_meters import metering
from objectives.problem import Constraint, Objective
from objectives.requirements import Screen
from tuner.study.judged_reading import constraint_of, held_with, pick_rule, searched_objective_of, unique
from tuner.study.plant_schema import PlantStudyTable
from tuner.study.schema import StudyTable
from tuner.study.search_reading import least_tail, search_of, with_reference
from tuner.study.size import ScenarioSize, check_size, flight_steps
from tuner.study.study import StudyScenario, TuningStudy
from tuner.text.input_errors import listed, located

S = TypeVar("S", bound=TuningStudy)


@dataclass(frozen=True)
class Judging:
    """Scenarios of a study, and what is wanted of the flights. system: with the meters that this needs."""

    system: Any
    scenarios: tuple[StudyScenario, ...]
    objectives: tuple[Objective, ...]
    constraints: tuple[Constraint, ...]

    @property
    def metrics(self) -> list[MetricAddress]:
        """Metrics of objectives and constraints."""
        return [entry.metric for entry in (*self.objectives, *(each.objective for each in self.constraints))]


def judging_of(
    path: Path, table: StudyTable | PlantStudyTable, system: Any, scenario_of: Callable[[Any], StudyScenario]
) -> Judging:
    """Return scenarios, objectives and constraints of the tables of a study; errors name path and key."""
    scenarios = tuple(listed("scenario", path, table.scenario, scenario_of))
    unique("scenario", [entry.spec.name for entry in scenarios], ".name")
    objectives = tuple(
        listed("objective", path, table.objective, lambda entry: searched_objective_of(entry, scenarios, system))
    )
    unique("objective", [entry.label for entry in objectives])
    constraints = tuple(
        listed("constraint", path, table.constraint, lambda entry: constraint_of(entry, scenarios, system))
    )
    unique("constraint", [entry.objective.label for entry in constraints])
    judging = Judging(system, scenarios, objectives, constraints)
    with located(path, ""):
        metered = metering(system, judging.metrics)
        if metered is not system:
            _ = metered.loop  # here, so that a metric for other systems is refused as a key of the study
    return Judging(metered, scenarios, objectives, constraints)


def assembled(
    kind: type[S],
    path: Path,
    table: StudyTable | PlantStudyTable,
    space: DecisionSpace,
    judging: Judging,
    mission: Mission,
    constraints: tuple[Constraint, ...],
    screens: tuple[Screen, ...],
    **parts: Any,
) -> S:
    """Return a study of a kind; errors name path and key.

    constraints: those of `judging` with the automatic limits behind them. screens: requirements that need no flight. parts:
    fields that this kind has beyond those of `TuningStudy`.
    """
    objectives, scenarios = judging.objectives, judging.scenarios
    with located(path, "search"):
        most = max(entry.search for entry in scenarios)
        tail = least_tail(objectives, len(scenarios))
        search = search_of(table.search, len(space.variables), len(objectives), most, tail)
        search = with_reference(search, table.search, objectives)
        timing = judging.system.timing
        sizes = [ScenarioSize(flight_steps(entry.spec, timing), entry.search, entry.held_out) for entry in scenarios]
        check_size(search.population, search.generations, sizes)
    with located(path, "pick"):
        rule = pick_rule(table.pick, objectives)
    fields = {
        "path": path,
        "table": table,
        "title": table.title,
        "description": table.description,
        "seed": table.seed,
        "system": judging.system,
        "space": space,
        "scenarios": scenarios,
        "objectives": objectives,
        "mission": mission,
        "constraints": held_with(table.confidence, constraints),
        "screens": screens,
        "search": search,
        "pick": rule,
    }
    return kind(**fields, **parts).with_starts()
