"""Which search a study may ask for: the numbers of objectives that each takes, errors that say which do, the listing."""

import pytest

from plant.errors import InputError, UnknownNameError
from tests.tuner.experiments.inference import asked as inference
from tests.tuner.study.study_text import changed, write
from tuner.api.catalogue import LISTINGS
from tuner.search.names import ALGORITHMS, check_algorithm
from tuner.study import load_study
from tuner.study.kinds import load_any

SECOND = '\n[[objective]]\nmetric = "travel"\n'


def asked(tmp_path, name, objectives):
    text = changed("population = 8", f'population = 8\nalgorithm = "{name}"')
    return load_study(write(tmp_path, text if objectives == 2 else changed(SECOND, "", text)))


@pytest.mark.parametrize("name", ALGORITHMS)
@pytest.mark.parametrize("objectives", [1, 2])
def test_a_study_gets_a_search_for_its_number_of_objectives(tmp_path, name, objectives):
    single, several = ("cmaes", "differential_evolution"), ("nsga3", "age_moea")
    if name in (single if objectives == 2 else several):
        with pytest.raises(InputError) as caught:
            asked(tmp_path, name, objectives)
        message = str(caught.value)
        assert caught.value.key == "search.algorithm" and caught.value.file is not None
        assert f"'{name}' takes {'1 objective' if name in single else '2 or more objectives'}" in message
        allowed = ["gaussian_process", "nsga2", "random", "sobol", *(several if objectives == 2 else single)]
        assert f"write one of {', '.join(sorted(allowed))}" in message
    else:
        assert asked(tmp_path, name, objectives).search.algorithm == name


def test_an_inference_has_an_objective_for_each_metric_of_its_cells(tmp_path):
    text = changed("[search]", '[search]\nalgorithm = "cmaes"', inference.STUDY) + inference.CELLS
    path = inference.write(tmp_path, text)
    with pytest.raises(InputError, match="'cmaes' takes 1 objective, and here are 2") as caught:
        load_any(path)
    assert caught.value.key == "search.algorithm" and caught.value.file == str(path)


def test_an_unknown_search_is_named():
    with pytest.raises(UnknownNameError, match="did you mean 'cmaes'"):
        check_algorithm("cma-es", 1)


def test_a_population_has_a_candidate_for_each_objective(tmp_path):
    extra = "".join(
        f'\n[[objective]]\nmetric = "rms.{axis}"\n' for axis in ("x", "y", "z", "roll", "pitch", "yaw", "tilt")
    )
    text = changed(SECOND, SECOND + extra)
    with pytest.raises(InputError, match="must be even and at least 10") as caught:
        load_study(write(tmp_path, text))
    assert caught.value.key == "search.population"


def test_the_listing_has_every_search():
    rows = LISTINGS["searches"]()
    assert [row["search"] for row in rows] == ["auto", *ALGORITHMS]
    assert {str(row["objectives"]) for row in rows} == {"1", "1 or more", "2 or more"}
    assert all(row["about"] for row in rows)
