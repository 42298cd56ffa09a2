"""The search that a study gets which names none: by its numbers of gains, objectives and candidates."""

from dataclasses import replace
from typing import Any

import pytest

from tests.tuner.study.study_text import STUDY, changed, write
from tuner.search.automatic import MAX_CANDIDATES, MAX_GAINS, MAX_OBJECTIVES, automatic
from tuner.search.names import ALGORITHMS, CONVERGED
from tuner.store.inputs import RunRecord, as_recorded
from tuner.study.build import load_study
from tuner.study.search_reading import least_tail

FEW = (MAX_GAINS, MAX_OBJECTIVES, MAX_CANDIDATES)


@pytest.mark.parametrize(
    ("size", "name"),
    [
        (FEW, "gaussian_process"),
        ((1, 1, 8), "gaussian_process"),
        ((7, 1, MAX_CANDIDATES + 1), "cmaes"),
        ((7, 2, MAX_CANDIDATES + 1), "nsga2"),
        ((MAX_GAINS + 1, 3, 100), "nsga2"),
        ((7, MAX_OBJECTIVES + 1, 100), "nsga3"),
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
    assert ALGORITHMS[automatic(gains, objectives, candidates).algorithm].supports(objectives)


def loaded(tmp_path, search, flights=4):
    text = changed("population = 8\ngenerations = 2", search, changed("search = 4", f"search = {flights}"))
    return load_study(write(tmp_path, text)).search


# An objective of the study's, the sizes that its search gets, and the flights that decide it then, of a mean all of them.
@pytest.mark.parametrize(
    ("risk", "first", "in_tail"),
    [
        ('risk = "mean"', 4, 4),
        ('risk = "cvar"\nlevel = 0.5', 4, 2),
        ('risk = "quantile"\nlevel = 0.5', 4, 2),
        ('risk = "cvar"\nlevel = 0.8', 8, 1.6),
        ('risk = "cvar"\nlevel = 0.9', 8, 0.8),
        ('risk = "worst"', 8, 1.1),
    ],
)
def test_a_study_that_leaves_it_open_gets_the_sizes_of_its_search(tmp_path, risk, first, in_tail):
    text = changed("population = 8\ngenerations = 2", "", changed("search = 4", "search = 32"))
    study = load_study(write(tmp_path, text.replace('risk = "cvar"\nlevel = 0.9', risk, 1)))
    search = study.search
    assert search.algorithm == "gaussian_process" and not search.racing
    assert (search.population, search.generations, search.first, search.stop) == (16, 26, first, CONVERGED)
    assert search.first and least_tail(study.objectives, 1) * search.first == pytest.approx(in_tail, rel=0.05)
    assert f"choice for 1 gain, 2 objectives and {search.candidates} candidates" in search.text


def test_pooled_scenarios_fill_a_tail(tmp_path):
    objectives = load_study(write(tmp_path, STUDY)).objectives
    alone, pooled = least_tail(objectives, 1), least_tail(objectives, 3)
    assert pooled == pytest.approx(3.0 * alone)
    named = [replace(entry, scenario="calm") for entry in objectives]
    assert least_tail(named, 3) == alone


@pytest.mark.parametrize(
    ("gains", "generations"),
    # 13 for each four gains, at least 26, and no more than a model was measured to serve.
    [(1, 26), (7, 26), (8, 26), (12, 39), (16, 52), (40, MAX_CANDIDATES // 16)],
)
def test_generations_grow_with_gains(gains, generations):
    sizes = ALGORITHMS["gaussian_process"].sizes(1.0, gains)
    assert sizes.generations == generations
    assert automatic(gains, 2, sizes.population * sizes.generations).algorithm == "gaussian_process"


def test_a_large_population_gets_an_evolution_that_races(tmp_path):
    search = loaded(tmp_path, "population = 200\ngenerations = 10", flights=32)
    assert (search.algorithm, search.population, search.generations, search.first) == ("nsga2", 200, 10, None)
    assert search.racing and "2,000 candidates are more than" in search.why


@pytest.mark.parametrize(
    ("search", "flights", "first"),
    [
        ('algorithm = "nsga2"', 32, None),
        ('algorithm = "nsga2"\nfirst = 3', 32, 3),
        ("", 4, None),
        ("first = 9", 8, None),
        ("first = 2", 4, 2),
    ],
)
def test_few_flights_first(tmp_path, search, flights, first):
    found = loaded(tmp_path, search, flights)
    assert found.first == first
    assert found.flights_first(flights) == (first or flights)
    assert found.racing == (found.algorithm == "nsga2" and first is None)


def test_the_content_of_a_study_names_what_was_chosen(tmp_path):
    text = changed("population = 8\ngenerations = 2", "", changed("search = 4", "search = 32"))
    study = load_study(write(tmp_path, text))
    sizes = {"population": 16, "generations": 26, "first": 8}
    model = {"algorithm": "gaussian_process", "flight_growth": True, "starts": [], "stop": CONVERGED}
    assert study.content["search"] == {**sizes, **model}
    resolved: dict[str, Any] = study.resolved()
    assert resolved["search"]["why"] == study.search.why


def record(version, generations: int | None = 7):
    return RunRecord(
        format="gainproof-run",
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


def test_folders_from_before_shipped_fronts_begin_from_none(tmp_path):
    path = write(tmp_path, changed("starts = []\n", ""))
    for version in (1, 2, 3):
        assert load_study(path, as_recorded(record(version), path)).search.starts == ()
    assert len(load_study(path, as_recorded(record(4), path)).search.starts) == 1
    given = write(tmp_path, changed("starts = []", 'starts = ["shipped"]'))
    assert len(load_study(given, as_recorded(record(3), given)).search.starts) == 1
