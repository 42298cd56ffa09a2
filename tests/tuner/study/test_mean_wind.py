"""Mean wind in a study: refused where the vehicle cannot hold against it, and most default flights of shipped studies end."""

import numpy as np
import pytest

from objectives.flown_system import FlightBatch
from objectives.problem import Problem
from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.scenarios import CONFIRMATION, Spread
from tests.plant.quadrotor.test_trim import independent
from tests.tuner.conftest import QUICKSTART
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.study.build import load_study
from tuner.study.trim import mean_wind_trim

STUDIES = QUICKSTART.parent


def test_the_trim_of_a_study_is_that_of_an_independent_solution():
    study = load_study(QUICKSTART, {"margin": [], "scenario.0.air.wind_direction_deg": 0.0})
    (entry,) = study.scenarios
    trim = mean_wind_trim(entry.spec, study.system)
    assert trim is not None and trim.held
    state = independent(load("hummingbird").vehicle, (entry.spec.air.wind_speed, 0.0, 0.0))
    assert np.cos(trim.tilt) == pytest.approx(state[14], abs=1e-6)
    vehicle = study.system.vehicle
    lift = vehicle.thrust_coefficient * np.sum(state[18:] ** 2, axis=0)
    assert trim.thrust == pytest.approx(lift / (vehicle.mass * vehicle.gravity), rel=1e-6)


def test_a_wind_that_the_vehicle_cannot_hold_is_refused_with_what_it_can():
    with pytest.raises(InputError) as told:
        load_study(QUICKSTART, {"scenario.0.air.intensity": "moderate"})
    said = str(told.value)
    for part in (
        "quickstart.toml",
        "scenario[0].air.intensity",
        "17.0 m/s",
        "39.2 deg",
        "limit is 30 deg",
        "up to 12.8 m/s",
    ):
        assert part in said
    # What is offered is accepted, a little more is not: the wind at 10 m is 1.101 times that at 20 ft.
    assert load_study(QUICKSTART, {"margin": [], "scenario.0.air.intensity": 12.8 / 1.1013})
    with pytest.raises(InputError):
        load_study(QUICKSTART, {"margin": [], "scenario.0.air.intensity": 13.1 / 1.1013})
    assert load_study(
        QUICKSTART, {"margin": [], "scenario.0.air.intensity": "moderate", "scenario.0.air.mean_wind": False}
    )
    assert load_study(QUICKSTART, {"margin": [], "scenario.0.air.intensity": 14.0, "controller.tilt_limit_deg": 45.0})


def test_no_shipped_study_says_trimmed_where_no_mean_wind_blows():
    for file in sorted(STUDIES.glob("*.toml")):
        for line in file.read_text(encoding="utf-8").splitlines():
            assert not ("mean_wind = false" in line and "trim" in line), file.name


def test_default_flights_in_the_mean_wind_end():
    """At least 99 % of the default's flights of the quickstart are completed; most were lost in the wind that it named before."""
    study = load_study(QUICKSTART, {"margin": []})
    problem = Problem(study.system, study.space, study.objectives, study.constraints, study.seed, 2)
    (entry,) = study.scenarios
    assert entry.spec.air.mean_wind and entry.spec.air.wind_speed > 8.0
    flown = problem.evaluate_gains(study.default_row[None], (FlightBatch(entry.spec, CONFIRMATION, 256),))
    assert flown.failures[0] <= 0.01


def test_rotor_lag_is_spread_unless_a_study_says_otherwise():
    study = load_study(QUICKSTART, {"margin": [], "scenario.0.spread": {"mass": 0.1}})
    assert study.scenarios[0].spec.spread == Spread(mass=0.1, lag=0.2)
    study = load_study(QUICKSTART, {"margin": [], "scenario.0.spread": {"lag": 0.0}})
    assert study.scenarios[0].spec.spread == Spread()


def test_gust_rates_on_a_vehicle_that_they_do_not_touch_are_told():
    (said,) = warnings_before_run(load_study(QUICKSTART, {"margin": [], "scenario.0.air.angular_rates": True}))
    assert "angular_rates = true in steps in gusts changes no number" in said and "rate_damping" in said


def test_a_yaw_loop_that_leads_is_told_with_the_cutoff_that_helps():
    f450 = STUDIES / "f450.toml"
    (said,) = warnings_before_run(load_study(f450, {"margin": [], "controller.yaw_torque_cutoff": 0.0}))
    assert "Yaw of f450 leads from 1.54 rad/s on" in said and "yaw_torque_cutoff = 0.25 (Hz)" in said
    assert warnings_before_run(load_study(f450, {"margin": []})) == []
