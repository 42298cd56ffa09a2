"""Limits of the recommended point: all its flights together decide, not the confirmation flights alone."""

from objectives.evaluator import Constraint
from objectives.metrics import parse
from objectives.problem import Objective
from objectives.risk import Risk
from tuner.analysis.held_out import compared_row
from tuner.documents.parts import Estimate, SampledValue
from tuner.documents.verdicts import BROKEN, NOT_CERTAIN, SATISFIED
from tuner.experiments.tuning.conclusion import uncertain_limits, with_limits_by_all_flights

OVERSHOOT = Objective(parse("overshoot.x"), Risk("mean"))


def row_of(value, limit=5.0, floor=""):
    """Row of a constraint whose value is measured on confirmation flights."""
    constraint = Constraint(OVERSHOOT, limit, floor=floor)
    estimate = Estimate(value, value - 0.5, value + 0.5)
    difference = SampledValue(value, value - 0.5, value + 0.5)
    return constraint, compared_row(OVERSHOOT, Estimate(0.0, 0.0, 0.0), estimate, difference, constraint)


def test_a_value_beyond_a_limit_that_all_flights_keep_is_not_certain():
    constraint, row = row_of(5.01)
    assert row.verdict == BROKEN
    (decided,) = with_limits_by_all_flights([row], [constraint])
    assert decided.verdict == NOT_CERTAIN
    (text,) = uncertain_limits([decided])
    assert "its value exceeds at most 5 %, and all flights of the point together keep it" in text


def test_other_rows_stay():
    constraint, row = row_of(4.0)
    assert with_limits_by_all_flights([row], [constraint])[0].verdict == SATISFIED
    # An automatic limit compares with the default: no flights decide it.
    automatic, beyond = row_of(6.0, floor="mission.followed")
    assert with_limits_by_all_flights([beyond], [automatic])[0].verdict == BROKEN
