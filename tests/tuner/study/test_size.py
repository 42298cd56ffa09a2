"""Ends of the sizes of runs: the largest that is taken, and the next one, which is refused with its key."""

import pytest

from plant.errors import InputError
from tuner.study.size import MAX_CANDIDATES, MAX_POPULATION, MAX_STEPS, ScenarioSize, check_candidates, check_size


def test_a_population_has_an_end():
    assert check_candidates(MAX_POPULATION, 2) == 2 * MAX_POPULATION
    with pytest.raises(InputError, match="allowed: up to 10,000") as refused:
        check_candidates(MAX_POPULATION + 1, 2)
    assert refused.value.key == "population"


def test_a_search_has_a_largest_number_of_candidates():
    assert check_candidates(100, MAX_CANDIDATES // 100) == MAX_CANDIDATES
    with pytest.raises(InputError, match="are 1,000,100 candidates; allowed: up to 1,000,000") as refused:
        check_candidates(100, MAX_CANDIDATES // 100 + 1)
    assert refused.value.key == "generations"


# 100 candidates make 1,000 flights in the search, or some 50 finalists make as many in the held-out check.
@pytest.mark.parametrize(("search", "held_out"), [(10, 0), (0, 20)])
def test_the_plant_steps_of_all_flights_have_an_end(search, held_out):
    steps = MAX_STEPS / 1000.0
    check_size(10, 10, [ScenarioSize(steps, search, held_out)])
    with pytest.raises(InputError, match=r"about 2,000 flights of 2.0e\+12 plant steps in all"):
        check_size(10, 10, [ScenarioSize(steps, search, held_out)] * 2)
