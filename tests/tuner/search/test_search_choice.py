"""Which search a study may ask for: the numbers of objectives that each takes, errors that say which do, the listing."""

from typing import Any

import numpy as np
import pytest

from plant.errors import InputError, UnknownNameError
from tests.tuner.study.study_text import changed, write
from tuner.api.catalogue import listings
from tuner.experiments.tuning.problem import problem_of
from tuner.experiments.tuning.search import algorithm_of
from tuner.search.names import ALGORITHMS, check_algorithm
from tuner.study.build import load_study

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
        assert f"'{name}' supports {'1 objective' if name in single else '2 or more objectives'}" in message
        allowed = ["gaussian_process", "nsga2", "random", "sobol", *(several if objectives == 2 else single)]
        assert f"use one of {', '.join(sorted(allowed))}" in message
    else:
        assert asked(tmp_path, name, objectives).search.algorithm == name


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
    rows = listings()["searches"]()
    assert [row["search"] for row in rows] == ["auto", *ALGORITHMS]
    assert {str(row["objectives"]) for row in rows} == {"1", "1 or more", "2 or more"}
    assert all(row["about"] for row in rows)


def with_reference(tmp_path, reference, algorithm="auto"):
    return load_study(
        write(
            tmp_path, changed("population = 8", f'population = 8\nalgorithm = "{algorithm}"\nreference = {reference}')
        )
    )


def test_a_reference_point_is_named_by_metric_or_label_and_decides_the_digest(tmp_path):
    study = with_reference(tmp_path, '{ travel = 12.0, "itae.position" = 0.5 }')
    labels = [entry.label for entry in study.objectives]
    assert study.search.reference == tuple(zip(labels, (0.5, 12.0), strict=True))
    assert f"up to {labels[0]} = 0.5 and {labels[1]} = 12" in study.search.text
    search: Any = algorithm_of(problem_of(study, 1, None), study, np.full((8, len(study.space.variables)), 0.5))
    assert search._reference.tolist() == [0.5, 12.0]
    again = with_reference(tmp_path, f'{{ "{labels[0]}" = 0.5 }}')
    assert again.search.reference == ((labels[0], 0.5),) and again.digest() != study.digest()
    assert with_reference(tmp_path, "{}").search.reference == ()


@pytest.mark.parametrize(
    ("reference", "algorithm", "key", "text"),
    [
        ("{ overshoot = 1.0 }", "auto", "search.reference.overshoot", "unknown objective"),
        ("{ travel = -1.0 }", "auto", "search.reference.travel", "0 or more"),
        ("{ travel = true }", "auto", "search.reference.travel", "finite number"),
        ("{ travel = 1.0 }", "nsga2", "search.reference", '"gaussian_process" does'),
    ],
)
def test_a_reference_point_that_cannot_be_is_refused(tmp_path, reference, algorithm, key, text):
    with pytest.raises(InputError) as caught:
        with_reference(tmp_path, reference, algorithm)
    assert caught.value.key == key and text in str(caught.value)
