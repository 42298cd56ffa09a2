"""Reading of a [search] table, of a study of any kind."""

from collections.abc import Sequence
from dataclasses import replace

from objectives.problem import Objective
from objectives.risk import RISKS
from plant.errors import InputError, UnknownNameError
from tuner.search.automatic import MODEL, automatic, candidates_of
from tuner.search.front import values_by_objective
from tuner.search.names import ALGORITHMS, AUTOMATIC, CONVERGED, STARTS, STOPS, check_algorithm
from tuner.study.schema import SearchTable
from tuner.study.study import SearchSpec

SMALLEST_POPULATION = 8


def search_of(table: SearchTable, gains: int, objectives: int, flights: int, tail: float = 1.0) -> SearchSpec:
    """Return the search for so many gains and objectives; flights: most of a candidate in one scenario; tail: see `least_tail`.

    Raises InputError with the key inside [search].
    """
    choice = automatic(
        gains, objectives, candidates_of(ALGORITHMS[MODEL].sizes(tail, gains), table.population, table.generations)
    )
    named = table.algorithm != AUTOMATIC
    algorithm = table.algorithm if named else choice.algorithm
    check_algorithm(algorithm, objectives)
    usual = ALGORITHMS[algorithm].sizes(tail, gains)
    generations = table.generations or usual.generations
    # A record of a run names its generations: as many as the usual ones are the usual ones.
    converges = ALGORITHMS[algorithm].grows and generations == usual.generations
    population = usual.population if table.population is None else table.population
    smallest = max(SMALLEST_POPULATION, objectives + objectives % 2)
    if population < smallest or population % 2:
        raise InputError(f"given {population}; the population must be even and at least {smallest}", key="population")
    if not table.initial:
        raise InputError('given an empty list; write initial = ["default"]', key="initial")
    for start in table.initial:
        if start not in STARTS:
            raise UnknownNameError("starting point", start, STARTS, key="initial")
    if table.stop not in STOPS:
        raise UnknownNameError("end of a search", table.stop, STOPS, key="stop")
    first = usual.first if table.first is None else table.first
    staged = first is not None and first < flights
    growth = (
        table.first is None and ALGORITHMS[algorithm].screens if table.flight_growth is None else table.flight_growth
    )
    if growth and not ALGORITHMS[algorithm].screens:
        raise InputError(
            f'given true; the flights of "{algorithm}" do not grow, those of "{MODEL}" do', key="flight_growth"
        )
    races = table.racing and not staged and not ALGORITHMS[algorithm].screens
    return SearchSpec(
        algorithm,
        population,
        generations,
        tuple(table.initial),
        racing=races,
        first=first if staged else None,
        flight_growth=staged and growth,
        stop=CONVERGED if converges and "stop" not in table.model_fields_set else table.stop,
        why="named by the study" if algorithm != choice.algorithm else choice.why,
    )


def with_reference(search: SearchSpec, table: SearchTable, objectives: Sequence[Objective]) -> SearchSpec:
    """Return a search with the reference point that a study gives.

    Raises InputError with the key inside [search].
    """
    if not table.reference:
        return search
    if not ALGORITHMS[search.algorithm].screens:
        raise InputError(
            f'"{search.algorithm}" goes by no reference point, "{MODEL}" does; leave it out', key="reference"
        )
    labels, addresses = [entry.label for entry in objectives], [entry.metric.text for entry in objectives]
    values = values_by_objective(table.reference, labels, addresses, "reference", "reference value")
    return replace(search, reference=tuple((labels[index], values[index]) for index in sorted(values)))


def least_tail(objectives: Sequence[Objective], scenarios: int) -> float:
    """Return the least number of deciding flights per flight of a scenario.

    The least of all objectives: 1 for the mean over a scenario, the share of its tail for a CVaR; more where flights of several
    scenarios are pooled.
    """
    return min(
        RISKS[entry.risk.name].tail(entry.risk.level or 0.0) * (scenarios if entry.scenario is None else 1)
        for entry in objectives
    )
