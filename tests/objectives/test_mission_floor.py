"""The mission floor: what each kind of scenario asks at least, by hand, and that a tune which does nothing breaks it."""

import numpy as np
import pytest

from objectives.metrics import parse
from objectives.mission import FOLLOWED, HELD, error_at_start, with_mission_floor
from objectives.problem import Constraint, FlightBatch, Objective, Problem
from objectives.risk import Risk
from plant.loop import Timing
from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.scenarios import SEARCH, ScenarioSpec
from plant.references.figure_eight import FigureEight
from plant.references.hover import Hover
from plant.references.level import Level
from plant.references.steps import Steps
from tests.tuner.conftest import QUICKSTART, SMALL
from tuner.study.build import load_study

EIGHT = FigureEight(size=2.0, period=10.0)
LIMITS, TIMING = Limits(5.0, 0.2), Timing(0.004, 0.001)


def floor(reference, duration=8.0):
    found = with_mission_floor((), [ScenarioSpec("a", duration, reference)], LIMITS, TIMING)
    return {entry.objective.metric.text: entry.most for entry in found}


def test_a_step_asks_for_a_share_of_its_size():
    # From 2 s of 8 s on, 3, 4 and 12 m away: 13 sqrt(6/8).
    asked = floor(Steps(x=3.0, y=-4.0, z=12.0, time=2.0))
    assert asked == {"rms.position": pytest.approx(FOLLOWED * 13.0 * np.sqrt(0.75))}
    assert floor(Steps(yaw_deg=90.0, time=2.0)) == {"rms.yaw": pytest.approx(FOLLOWED * np.pi / 2 * np.sqrt(0.75))}
    both = floor(Steps(roll_deg=10.0, pitch_deg=-10.0, time=4.0))
    assert both == {"rms.tilt": pytest.approx(FOLLOWED * np.radians(10.0))}


def test_a_path_asks_for_a_share_of_its_own_excursion():
    spec = ScenarioSpec("a", 40.0, EIGHT)
    away = spec.track(TIMING).samples[:, :3]
    by_hand = np.sqrt(
        np.mean((away[:, 0] - away[0, 0]) ** 2 + (away[:, 1] - away[0, 1]) ** 2 + (away[:, 2] - away[0, 2]) ** 2)
    )
    assert floor(EIGHT, 40.0)["rms.position"] == pytest.approx(FOLLOWED * by_hand, rel=1e-9)


def test_rest_asks_not_to_drift():
    assert floor(Hover()) == {"rms.position": HELD * 5.0}
    assert floor(Level()) == {"rms.z": HELD * 5.0}


def test_a_turn_beyond_half_a_circle_is_as_far_as_its_angle():
    samples = np.zeros((100, 14))
    samples[50:, 11] = 2.0 * np.pi - 0.5
    assert error_at_start(samples, "rms.yaw") == pytest.approx(0.5 * np.sqrt(0.5))


@pytest.mark.parametrize("slow", [0.3, 1.0, 3.0])
def test_a_first_order_response_is_inside_if_it_makes_some_half_of_the_step(slow):
    # e = exp(-t/tau): mean square tau/(2 W) (1 - exp(-2 W/tau)) of the window W after the step.
    window, tau = 6.0, slow * 6.0
    share = np.sqrt(tau / (2 * window) * (1 - np.exp(-2 * window / tau)))
    assert (share <= FOLLOWED) == (1.0 - np.exp(-window / tau) >= 0.56)


def test_the_studys_own_limit_on_the_same_quantity_stands():
    spec = ScenarioSpec("a", 8.0, Hover())
    own = Constraint(Objective(parse("rms.position"), Risk("quantile", 0.5), "a"), 4.0)
    other = Constraint(Objective(parse("failure"), Risk("mean")), 0.0)
    assert with_mission_floor((own,), [spec], LIMITS, TIMING) == (own,)
    assert with_mission_floor((other,), [spec], LIMITS, TIMING) == (
        other,
        *with_mission_floor((), [spec], LIMITS, TIMING),
    )


@pytest.fixture(scope="module")
def problem():
    study = load_study(QUICKSTART, {**SMALL, "scenario.0.duration": 8.0, "scenario.0.air.intensity": "none"})
    specs = [entry.spec for entry in study.scenarios]
    asked = with_mission_floor((), specs, study.system.limits, study.system.timing)
    return study, Problem(study.system, study.space, study.objectives, asked, study.seed, 2), specs


def test_a_tune_that_does_nothing_breaks_the_floor_and_the_default_keeps_it(problem):
    study, flown, specs = problem
    idle = study.default_row.copy()
    for gain in gain_addresses(study.system.cascade):
        # A position loop 40 times slower than its default of 1.2 rad/s: smooth, and nowhere after 8 s.
        if gain.address in ("x.omega_c", "y.omega_c", "z.omega_c"):
            idle[gain.column] /= 40.0
    found = flown.evaluate_gains(np.stack([study.default_row, idle]), (FlightBatch(specs[0], SEARCH, 4),))
    assert found.failures.tolist() == [0.0, 0.0]
    travel = found.values[:, 1]
    assert travel[1] < travel[0]  # it would win the objective of effort
    assert np.all(found.violations[0] <= 0.0) and found.violations[1, 0] > 0.0
