"""Sentences from made-up results: nothing is called lower by its value alone, nothing met that was set to be met."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.problem import Objective
from objectives.risk import Risk
from tuner.documents.comparison_document import BoundRow, StepCost
from tuner.documents.parts import SampledValue
from tuner.experiments.compare.statistics import Comparison, Difference
from tuner.experiments.compare.words import (
    bound_words,
    certainty_words,
    cost_words,
    objective_words,
)
from tuner.extensions.contests.judging import claim_basis, judged_claim, published_row, ruling
from tuner.extensions.contests.study import Claim, Published
from tuner.extensions.contests.tuning import compared_at
from tuner.extensions.contests.words import claim_words, published_words
from tuner.study.comparison import Quantity
from tuner.text.sentences import listing

TRAVEL = Objective(parse("travel"), Risk("mean"))


def result(**parts) -> Any:
    contest = SimpleNamespace(quantities=(Quantity(TRAVEL, "objective"),))
    return SimpleNamespace(study=contest, names=["A", "B", "C"], fronts=[], **parts)


def test_the_lowest_is_put_below_only_those_whose_interval_says_so():
    estimates = [[SampledValue(value, value - 0.5, value + 0.5)] for value in (2.0, 1.0, 4.0)]
    differences = [
        Difference(0, 1, 0, SampledValue(-1.0, -2.1, 0.1), 2.0),
        Difference(0, 2, 0, SampledValue(2.0, 1.0, 3.0), 2.0),
        Difference(1, 2, 0, SampledValue(3.0, 2.0, 4.0), 1.0),
    ]
    (text,) = objective_words(result(comparison=Comparison(estimates, differences)))
    assert text == (
        "mean(travel): B has the lowest value, 1.0 1/s [0.5, 1.5]; better than C (75 % less); not distinguishable from A."
    )


def cell(contender, percentile, fitted):
    """Return a printed number of 0 that so many per cent of a contender's flights lie below."""
    printed = Published(("A", "B"), parse("peak.roll"), "gusts", 0.0, "", fitted)
    values = np.where(np.arange(1000) < 10.0 * percentile, -1.0, 1.0)
    row = published_row(printed, contender, SampledValue(0.1, 0.0, 0.2), values)
    assert row.percentile == pytest.approx(percentile)
    return row


def test_numbers_that_the_study_was_set_to_meet_are_counted_apart():
    cells = [
        cell("A", 2.5, False),
        cell("A", 2.4, False),
        cell("B", 97.6, False),
        cell("B", 50.0, True),
        cell("B", 97.5, True),
    ]
    free, fitted = published_words(result(published=cells))
    assert free.startswith("Of 3 comparisons with printed numbers, 1 lie between")
    assert free.endswith("A 1 of 2 and B 0 of 1.")
    assert fitted == "Of 2 more with numbers that the study was set to meet, 2 lie there: B 2 of 2."
    assert list(published_words(result(published=[]))) == []


def test_a_claim_is_told_with_its_counts():
    verdicts = [SampledValue(-1.0, -2.0, -0.5), SampledValue(1.0, 0.5, 2.0), SampledValue(0.0, 0.0, 0.0)]
    claim = Claim("A", ("B",), (TRAVEL,), "A is best")
    judged = judged_claim(
        claim,
        [
            ruling("B", "mean(travel)", entry, word)
            for entry, word in zip(verdicts, ("better", "worse", "no practical difference"), strict=True)
        ],
    )
    (text,) = claim_words(result(claims=[judged]))
    assert text == (
        'The claim "A is best" fails: of 3 paired comparisons 1 for it, 1 against it and 1 without a decision.'
    )


def test_a_claim_names_its_quantity_and_the_objectives_that_are_apart():
    pair = Claim("A", ("B",), (TRAVEL,), "A is best")
    assert claim_basis(pair, {}, is_tuned=False) == "in mean(travel)"
    assert claim_basis(pair, {}, is_tuned=True) == "in mean(travel), at the points compared"
    told = "in mean(travel), at points whose error differs by 52 % and noise differs by 21 %"
    assert claim_basis(pair, {"error": 0.5227, "noise": 0.21}, is_tuned=True) == told
    several = Claim("A", ("B", "C"), (TRAVEL,) * 4, "A is best")
    assert claim_basis(several, {"error": 0.5}, is_tuned=False) == (
        "in 4 quantities, at points whose error differs by up to 50 %"
    )
    judged = judged_claim(
        pair, [ruling("B", "mean(travel)", SampledValue(-1.0, -2.0, -0.5), "better")], "in mean(travel)"
    )
    assert list(claim_words(result(claims=[judged]))) == [
        'The claim "A is best" survives in mean(travel): of 1 paired comparisons 1 for it.'
    ]


def bound(variable, end, at, value, recommended, natural):
    return BoundRow(
        variable=variable, end=end, bound=at, value=value, recommended=recommended, share=0.5, natural=natural
    )


def test_only_gains_of_the_point_compared_are_named_on_their_bound():
    bounds = [
        [bound("tilt.k1", "low", 0.0, 0.0, True, True), bound("tilt.k2", "high", 9.0, 5.0, False, False)],
        [bound("yaw.kp", "high", 400.0, 399.0, True, False)],
        [],
    ]
    first, second = bound_words(result(bounds=bounds))
    assert first == "A: tilt.k1 = 0 stands at the lower end of its range, beyond which it has no meaning."
    assert second == "B: yaw.kp = 399 stands at the upper end of its range, so its range decided it, not the search."


def operations(count):
    return StepCost(operations=count, position=1, attitude=1, meaning="")


def test_equal_costs_are_told_together_and_lost_flights_are_told():
    (text,) = cost_words(result(costs=[operations(90), operations(30), operations(90)]))
    assert text.endswith("counted: 30 with B; 90 with A and C.")
    failed = np.zeros((3, 40), dtype=bool)
    failed[1, :2] = True
    told = list(certainty_words(result(flown=SimpleNamespace(failed=failed), comparison=Comparison([], []))))
    assert told == ["B lost 5.0 % of its flights."]


@pytest.mark.parametrize(("parts", "text"), [("a", "a"), ("ab", "a and b"), ("abc", "a, b and c")])
def test_lists_read_as_english(parts, text):
    assert listing(parts) == text


def outcome(rule, values) -> Any:
    study = SimpleNamespace(pick=rule, objectives=(TRAVEL, Objective(parse("rms.yaw"), Risk("mean"))))
    return SimpleNamespace(
        study=study,
        tuned=2,
        finalists=SimpleNamespace(
            # The default and a finalist that is off the front have the best values.
            non_dominated=np.array([False, *[True] * len(values), False]),
            evaluation=SimpleNamespace(values=np.concatenate([np.zeros((1, 2)), values, np.zeros((1, 2))])),
        ),
        candidates=np.array([7, 8]),
        why="it beats the default",
        gains=lambda row: np.array([float(row)]),
    )


@pytest.mark.parametrize(("rule", "point"), [("min:mean(travel)", "p0"), ("min:mean(rms.yaw)", "p2"), ("knee", "p1")])
def test_a_contender_is_compared_where_the_rule_says_whatever_its_default(rule, point):
    values = np.array([[1.0, 5.0], [1.5, 1.5], [5.0, 1.0]])
    finalist, why = compared_at(outcome(rule, values))
    assert finalist == 1 + int(point[1:])
    assert why.endswith("on its held-out front")


def test_without_a_front_the_recommended_point_is_compared():
    assert compared_at(outcome("knee", np.empty((0, 2)))) == (2, "it beats the default")
