"""A quarter car is judged by its passenger, its tyre and its stroke, none of which a loop controls."""

from pathlib import Path

import numpy as np
import pytest

import tuner
from tuner.api.gains import gains_of_plant
from tuner.study.plant_study import PlantStudy

STUDY = Path(__file__).parent / "quarter_car.toml"


@pytest.mark.slow
def test_its_study_has_40_lines_and_judges_what_no_loop_controls():
    study = tuner.load_study(STUDY, kind=PlantStudy)
    assert len([line for line in STUDY.read_text().splitlines() if line]) <= 40
    assert [each.metric.unit for each in study.objectives] == ["m/s^2", "N"]
    assert study.system.watched == ("acceleration", "tyre_load", "stroke")


@pytest.mark.slow
def test_a_damper_to_the_sky_makes_the_ride_softer():
    """D. Karnopp, M. J. Crosby, R. A. Harwood, "Vibration control using semi-active force generators", 1974."""
    study = tuner.load_study(STUDY, kind=PlantStudy)
    rides = []
    for gain in (20.0, 500.0, 2000.0):
        row = np.array(study.default_row)
        row[0] = gain
        rides.append(tuner.fly(gains_of_plant(study, row), flights=16).table.loc["rms.acceleration", "mean"])
    assert rides == sorted(rides, reverse=True)
