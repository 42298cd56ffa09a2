"""Expected widths and numbers of scenarios against closed forms and against simulated comparisons; nothing is flown."""

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.problem import Objective
from objectives.risk import Risk, minimum_samples
from plant.quadrotor.scenarios import ScenarioSpec
from plant.seeds import generator
from tuner.documents.parts import PlantStep
from tuner.experiments.planning.pilot import Pilot, ScenarioPilot, pilot_size
from tuner.experiments.planning.precision import pooled, scenarios_needed, weighed_risk, width

MEAN, CVAR = Risk("mean"), Risk("cvar", 0.8)
TRAVEL, TAIL = (Objective(parse("travel"), risk) for risk in (MEAN, CVAR))
MANY = 4000


def draw(name, index=0):
    return generator(11, f"test/{name}", index)


def even(n):
    return np.full(n, 1.0 / n)


@pytest.mark.parametrize("count", [64, 1024])
def test_the_mean_of_normal_scores_has_its_closed_form(count):
    scores = draw("normal").normal(10.0, 2.0, size=(1, MANY))
    found = width(scores, even(MANY), TRAVEL, count, draw("width"))
    # Ends from 400 replicates: 0.13 standard deviations each, 5 % of the width; three of these.
    assert found == pytest.approx(2.0 * 1.96 * 2.0 / count**0.5, rel=0.15)


def test_the_tail_of_exponential_scores_has_its_closed_form():
    # CVaR's asymptotic variance for Exp(1): (Var[(x - q)+] + ...)/(1-a)^2 = (2 s - s^2) / s^2 with s = 1 - a = 0.2, so 9 / n.
    scores = draw("exponential").exponential(size=(1, MANY))
    assert width(scores, even(MANY), TAIL, 1000, draw("width")) == pytest.approx(2.0 * 1.96 * 3.0 / 1000**0.5, rel=0.2)


def test_more_flights_narrow_the_width_and_the_worst_case_has_none():
    scores = draw("normal").normal(size=(1, 64))
    widths = [width(scores, even(64), TAIL, count, draw("width")) for count in (40, 256, 4096)]
    assert widths[0] is not None and widths[1] is not None and widths[2] is not None
    assert widths[0] > 2.0 * widths[1]
    assert widths[1] == pytest.approx(4.0 * widths[2], rel=0.2)
    # Eight of 40 are in the tail of 20 %; of 39 fewer are.
    assert width(scores, even(64), TAIL, 39, draw("width")) is None
    assert width(scores, even(64), Objective(parse("travel"), Risk("worst")), 64, draw("width")) is None


def test_scenarios_weigh_as_much_as_in_the_run():
    def flown(name, scores):
        lost = np.zeros(scores.shape[::2], dtype=bool)
        return ScenarioPilot(ScenarioSpec(name), scores, lost, 1.0, 1.0, 1.0, 1.0)

    calm, wild = np.zeros((2, 1, 64)), np.ones((2, 1, 64))
    step = PlantStep(step=0.004, steps=1, fixed=False, flights=0)
    pilot = Pilot(np.zeros((2, 1)), (flown("calm", calm), flown("wild", wild)), 1.0, 0.0, 72, 1, step, 1.0)
    scores, weights = pooled(pilot, 0, [30, 10])
    assert scores.shape == (2, 128) and weights.sum(axis=0) == pytest.approx(1.0)
    assert float(np.sum(weights * scores[0], axis=0)) == pytest.approx(0.25)
    assert weighed_risk(scores, weights, MEAN) == pytest.approx([0.25, 0.25])
    # The worst fifth is all wild, the worst half is half wild.
    assert weighed_risk(scores, weights, CVAR) == pytest.approx([1.0, 1.0])
    assert weighed_risk(scores, weights, Risk("cvar", 0.5)) == pytest.approx([0.5, 0.5])
    only, weights = pooled(pilot, 0, [0, 10])
    assert only.shape == (2, 64) and np.all(only == 1.0) and weights == pytest.approx(1.0 / 64)


def test_the_number_needed_is_that_of_the_closed_form_and_has_its_power():
    # Both 10 in the mean; differences have a standard deviation of 1.5.
    base = draw("pairs").normal(10.0, 2.0, size=MANY)
    other = base + draw("differences").normal(0.0, 1.5, size=MANY)
    scores = np.stack([base * 10.0 / base.mean(axis=0), other * 10.0 / other.mean(axis=0)])
    complete = np.array([True, True])
    found = scenarios_needed(scores, complete, even(MANY), MEAN, 0.05, draw("needed"))
    deviation = float(np.std(scores[1] - scores[0], axis=0))
    # The standard deviation of 400 replicates is known to 3.5 %, its square to 7 %.
    assert found == pytest.approx((2.8016 * deviation / 0.5) ** 2, rel=0.2)
    exact = round((2.8016 * deviation / 0.5) ** 2)
    told = 0
    for run in range(400):
        seen = draw("power", run).integers(MANY, size=exact)
        difference = scores[1][seen] + 0.5 - scores[0][seen]
        told += abs(difference.mean(axis=0)) > 1.96 * difference.std(axis=0, ddof=1) / exact**0.5
    # 80 %, binomial with a standard deviation of 2 %.
    assert told / 400 == pytest.approx(0.8, abs=0.06)


def test_a_bad_candidate_counts_as_one_at_the_default_s_value():
    base = draw("pairs").normal(10.0, 2.0, size=200)
    other = base + draw("differences").normal(0.0, 1.5, size=200)
    needed = [
        scenarios_needed(np.stack([base, scale * other]), np.ones(2, dtype=bool), even(200), CVAR, 0.05, draw("needed"))
        for scale in (1.0, 50.0)
    ]
    assert needed[0] is not None and needed[0] == needed[1] and needed[0] > minimum_samples(CVAR)


@pytest.mark.parametrize(
    ("risk", "complete", "level"),
    [
        (Risk("worst"), [True, True], 1.0),
        (MEAN, [False, True], 1.0),
        (MEAN, [True, False], 1.0),
        (MEAN, [True, True], 0.0),
    ],
)
def test_nothing_is_said_where_nothing_can_be(risk, complete, level):
    scores = level * draw("none").uniform(1.0, 2.0, size=(2, 64))
    assert scenarios_needed(scores, np.array(complete), even(64), risk, 0.05, draw("needed")) is None


def test_a_tail_needs_its_flights_even_without_any_spread():
    scores = np.ones((2, 64))
    assert scenarios_needed(scores, np.ones(2, dtype=bool), even(64), CVAR, 0.05, draw("needed")) == minimum_samples(
        CVAR
    )


def test_every_thread_has_as_many_candidates():
    assert [pilot_size(threads) for threads in (1, 2, 3, 8, 16)] == [8, 8, 9, 8, 16]
