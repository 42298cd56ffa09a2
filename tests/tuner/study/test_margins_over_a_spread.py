"""Margins of a plant over the spread of its parameters: the worst of loops built one by one."""

from dataclasses import replace

import numpy as np
import pytest

from objectives.margins.plant_margins import PlantMargins
from plant.errors import InputError
from plant.model.scenario import PlantScenario
from tests.tuner.conftest import QUICKSTART
from tuner.api.studies import load_study
from tuner.study.plant_margins import MAX_CORNERS, spread_corners
from tuner.study.plant_study import PlantStudy

HEATER = QUICKSTART.with_name("heater.toml")
LIMIT = [{"quantity": "ms", "max": 2.0, "spread": True}, {"quantity": "ms", "max": 2.0}]


def heater(**changes):
    return load_study(HEATER, {"margin": LIMIT, **changes}, kind=PlantStudy)


def test_the_worst_is_that_of_loops_built_one_by_one():
    study = heater(**{"scenario.0.spread": {"b0": 0.3}, "scenario.0.joint_spread": [{"a1": 0.2, "a2": -0.1}]})
    system, row = study.system, np.array(study.default_row)
    nominal = system.parameters
    found = study.screens[0].analyse(row[None])[0]
    peaks = []
    for gain in (0.7, 1.0, 1.3):
        for way in (-1.0, 0.0, 1.0):
            varied = nominal._replace(
                b0=gain * nominal.b0, a1=(1.0 + 0.2 * way) * nominal.a1, a2=(1.0 - 0.1 * way) * nominal.a2
            )
            loop = PlantMargins(replace(system, parameters=varied), 0.99 * row, 1.01 * row)
            peaks.append(loop.evaluate(row[None]).sensitivity.value[0, 0])
    assert found[0] == pytest.approx(max(peaks), rel=1e-9) and max(peaks) > 1.02 * peaks[4]
    assert found[1] == pytest.approx(peaks[4], rel=1e-9)


def test_corners_are_ends_of_each_spread_and_of_each_joint_spread():
    parameters = heater().system.parameters
    spec = PlantScenario("x", 1.0, spread={"b0": 0.5}, joint_spread=[{"a1": 0.2, "a2": -0.1}])
    corners = {tuple(np.round(np.array(each) / np.array(parameters), 9)) for each in spread_corners(parameters, [spec])}
    places = [parameters._fields.index(name) for name in ("b0", "a1", "a2")]
    ends = {tuple(corner[i] for i in places) for corner in corners}
    assert ends == {(0.5, 1.2, 0.9), (0.5, 0.8, 1.1), (1.5, 1.2, 0.9), (1.5, 0.8, 1.1)}
    assert spread_corners(parameters, [PlantScenario("x", 1.0)]) == []


def test_many_spreads_are_judged_in_drawn_corners():
    parameters = heater().system.parameters
    spec = PlantScenario("x", 1.0, joint_spread=[{"b0": 0.02 * k} for k in range(1, 9)])
    corners = spread_corners(parameters, [spec])
    assert 1 < len(corners) <= MAX_CORNERS and corners == spread_corners(parameters, [spec])


def test_a_spread_of_nothing_is_refused():
    with pytest.raises(InputError, match=r"margin\[0\].spread: no scenario spreads a parameter; write spread.NAME"):
        heater(**{"scenario.0.spread": {}, "scenario.1.spread": {}})
