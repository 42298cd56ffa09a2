"""Verdicts one by one: intervals against SciPy's, limits met, crossed and broken, and what has to agree."""

import json
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.problem import Constraint, Evaluation, Objective
from objectives.requirements import Requirement
from objectives.risk import Risk
from plant.errors import InputError
from plant.seeds import generator
from tests.tuner.conftest import QUICKSTART, SMALL
from tuner.analysis.judged_rows import flown_row, interval, known_row, overall, verdict
from tuner.api.gains import default_gains
from tuner.gains import to_document
from tuner.study.build import load_study
from tuner.study.study import differences


@pytest.fixture(scope="module")
def study():
    return load_study(QUICKSTART, SMALL)


def draw():
    return generator(5, "test/judging", 0)


def test_no_lost_flight_in_a_thousand_is_no_proof_of_none():
    failure = Objective(parse("failure"), Risk("mean"))
    low, high = interval(failure, np.zeros(1000), draw())
    # 1 - 0.025^(1/1000): the rule of 3.7.
    assert low == 0.0 and high == pytest.approx(3.69e-3, rel=1e-2)
    assert verdict(0.003, 0.0, high) == "not certain" and verdict(0.01, 0.0, high) == "pass"


def test_a_limit_of_no_loss_is_one_on_the_flights_made_and_its_bound_is_told():
    entry = Constraint(Objective(parse("failure"), Risk("mean")), 0.0)
    for lost, said, words in ((0, "pass", "0 of 256: at most 1.4 %"), (1, "fail", "1 of 256")):
        scores = np.zeros((1, 1, 256))
        scores[0, 0, :lost] = 1.0
        none: Any = None
        evaluation = Evaluation(none, none, none, scores, np.repeat("gusts", 256), none, none)
        row = flown_row(entry.objective, entry.most, evaluation, 0, 1)
        assert row.verdict == said and row.count is not None and row.count.words == words


def test_a_mean_has_the_bootstrap_s_interval_and_a_worst_case_none():
    scores = draw().normal(3.0, 1.0, size=400)
    low, high = interval(Objective(parse("travel"), Risk("mean")), scores, draw())
    assert (low, high) == pytest.approx((scores.mean(axis=0) - 0.098, scores.mean(axis=0) + 0.098), abs=0.015)
    assert interval(Objective(parse("travel"), Risk("worst")), scores, draw()) == (None, None)


@pytest.mark.parametrize(
    ("most", "value", "high", "said"),
    [
        (None, 5.0, 6.0, "reported"),
        (2.0, 1.0, 1.5, "pass"),
        (2.0, 1.0, 2.0, "pass"),
        (2.0, 2.0, 2.1, "not certain"),
        (2.0, 2.1, 2.2, "fail"),
        (2.0, 1.0, None, "not certain"),
        (2.0, 2.1, None, "fail"),
    ],
)
def test_verdicts_on_flights(most, value, high, said):
    assert verdict(most, value, high) == said


@pytest.mark.parametrize(
    ("sense", "hard", "value", "said"),
    [
        ("min", True, 35.0, "pass"),
        ("min", True, 34.9, "fail"),
        ("min", False, 34.9, "target missed"),
        ("min", False, inf, "target kept"),
        ("max", True, inf, "fail"),
    ],
)
def test_verdicts_without_flights(sense, hard, value, said):
    row = known_row(Requirement("margin", "what it is", "deg", 35.0, sense, hard), value)
    assert (row.verdict, row.low, row.high, row.flights, row.sense) == (said, None, None, 0, sense)


def test_the_worst_row_decides_and_a_target_does_not():
    def rows(*said):
        one = known_row(Requirement("margin", "what", "1", 1.0, "min"), 2.0)
        return [one.model_copy(update={"verdict": entry}) for entry in said]

    assert overall(rows("pass", "reported", "target missed")) == "pass"
    assert overall(rows("pass", "not certain")) == "not certain"
    assert overall(rows("not certain", "fail", "pass")) == "fail"


def test_everything_that_differs_is_named(study, tmp_path):
    mine = study.controller(study.default_row)
    assert differences(mine, study) == []
    pid = default_gains("pid", mine.cascade.position.name, airframe="iris").controller
    other = replace(pid, control_period=0.002, options=replace(mine.options, delay=False))
    (tmp_path / "other.json").write_text(json.dumps(to_document(other, {})), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        study.read_row(tmp_path / "other.json")
    said = str(caught.value)
    for words in (
        "airframe 'iris' instead of 'hummingbird'",
        "attitude law 'pid' instead of 'hybrid'",
        "control_period [s] 0.002 instead of 0.004",
        "delay False instead of True",
    ):
        assert words in said
    assert "position law" not in said and "lag_aware" not in said and said.startswith(f"{QUICKSTART}: airframe: ")


def test_an_angle_is_told_in_the_unit_of_its_key(study):
    mine = study.controller(study.default_row)
    other = replace(mine, options=replace(mine.options, tilt_limit=np.pi / 4))
    assert differences(other, study) == ["tilt_limit_deg 45 instead of 30"]


def test_an_airframe_of_the_same_name_with_other_numbers_is_another(study):
    mine = study.controller(study.default_row)
    heavier = mine.airframe.vehicle._replace(mass=2.0)
    assert "has other numbers" in differences(replace(mine, airframe=replace(mine.airframe, vehicle=heavier)), study)[0]
