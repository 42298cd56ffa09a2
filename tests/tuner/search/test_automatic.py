"""The search that a study gets which names none: by its numbers of gains, objectives and candidates."""

import pytest

from tests.tuner.study.study_text import changed, write
from tuner.search.automatic import MOST_CANDIDATES, MOST_GAINS, MOST_OBJECTIVES, automatic
from tuner.search.names import ALGORITHMS
from tuner.store.inputs import RunRecord, as_recorded
from tuner.study import load_study

FEW = (MOST_GAINS, MOST_OBJECTIVES, MOST_CANDIDATES)


@pytest.mark.parametrize(
    ("size", "name"),
    [
        (FEW, "gaussian_process"),
        ((1, 1, 8), "gaussian_process"),
        ((7, 1, MOST_CANDIDATES + 1), "cmaes"),
        ((7, 2, MOST_CANDIDATES + 1), "nsga2"),
        ((MOST_GAINS + 1, 3, 100), "nsga2"),
        ((7, MOST_OBJECTIVES + 1, 100), "nsga3"),
    ],
)
def test_a_model_where_candidates_are_few_else_an_evolution(size, name):
    choice = automatic(*size)
    assert choice.algorithm == name
    # The reason names what decided.
    beyond = [count for count, most in zip(size, FEW, strict=True) if count > most]
    assert all(f"{count:,}" in choice.why for count in beyond or size)


@pytest.mark.parametrize("objectives", range(1, 9))
@pytest.mark.parametrize("gains", [0, 1, 20, 50])
@pytest.mark.parametrize("candidates", [8, 5000])
def test_what_is_chosen_takes_the_objectives(gains, objectives, candidates):
    assert ALGORITHMS[automatic(gains, objectives, candidates).algorithm].takes(objectives)


def loaded(tmp_path, search, flights=4):
    text = changed("population = 8\ngenerations = 2", search, changed("search = 4", f"search = {flights}"))
    return load_study(write(tmp_path, text)).search


def test_a_study_that_leaves_it_open_gets_the_sizes_of_its_search(tmp_path):
    search, usual = loaded(tmp_path, "", flights=32), ALGORITHMS["gaussian_process"]
    assert (search.algorithm, search.population, search.generations) == (
        "gaussian_process", usual.population, usual.generations,
    )  # fmt: skip
    assert search.first == usual.first and not search.racing
    assert f"{usual.population * usual.generations} candidates are few enough" in search.text


def test_a_large_population_gets_an_evolution_that_races(tmp_path):
    search = loaded(tmp_path, "population = 200\ngenerations = 10", flights=32)
    assert (search.algorithm, search.population, search.generations, search.first) == ("nsga2", 200, 10, None)
    assert search.racing and "2,000 candidates are more than" in search.why


@pytest.mark.parametrize(
    ("search", "flights", "first"),
    [
        ('algorithm = "nsga2"', 32, None), ('algorithm = "nsga2"\nfirst = 3', 32, 3), ("", 4, None), ("first = 9", 8, None),
        ("first = 2", 4, 2),
    ],
)  # fmt: skip
def test_few_flights_first(tmp_path, search, flights, first):
    found = loaded(tmp_path, search, flights)
    assert found.first == first
    assert found.flights_first(flights) == (first or flights)
    assert found.racing == (found.algorithm == "nsga2" and first is None)


def test_the_content_of_a_study_names_what_was_chosen(tmp_path):
    text = changed("population = 8\ngenerations = 2", "", changed("search = 4", "search = 32"))
    study = load_study(write(tmp_path, text))
    assert study.content["search"] == {"algorithm": "gaussian_process", "population": 16, "generations": 15, "first": 4}
    assert study.resolved()["search"]["why"] == study.search.why


def record(version, generations: int | None = 7):
    return RunRecord(
        format="holdfast-run",
        version=version,
        kind="tuning",
        study="inputs/a.toml",
        digest="",
        generations=generations,
        model="",
    )


def test_folders_from_before_the_rule_keep_the_search_that_they_began_with(tmp_path):
    text = changed("population = 8\ngenerations = 2", "population = 8", changed("search = 4", "search = 32"))
    path = write(tmp_path, text)
    for version in (1, 2):
        study = load_study(path, as_recorded(record(version), path))
        assert (study.search.algorithm, study.search.population, study.search.generations) == ("nsga2", 8, 7)
        assert study.search.first is None and study.search.racing
    # Since then the study in the folder names everything.
    assert as_recorded(record(3), path) == {"search.generations": 7}
