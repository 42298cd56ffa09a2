"""Parameters that vary together: their correlation, and what is refused."""

from typing import Any

import numpy as np
import pytest

from plant.errors import InputError
from plant.model.scenario import PlantScenario, draw_plant_scenarios
from plant.seeds import source_of
from tuner import make_study

TABLES = {
    "title": "A lag",
    "seed": 1,
    "plant": {"transfer_function": {"numerator": [2.0], "denominator": [10.0, 1.0]}, "control_period": 0.5},
    "actuator": [{"name": "u", "low": -5.0, "high": 5.0}],
    "channel": [{"name": "y", "law": "pid", "output": "y", "to": "u", "lost_beyond": 50.0}],
    "gains": {"y.kp": {"low": 0.1, "high": 9.0}, "y.ki": 0.1, "y.kd": 0.0, "y.t_f": 1.0},
    "scenario": [{"name": "step", "duration": 20.0, "reference": {"y": {"kind": "step", "size": 1.0}}}],
    "objective": [{"metric": "iae.y"}],
}


def study(**scenario):
    return make_study({**TABLES, "scenario": [{**TABLES["scenario"][0], **scenario}]})


def test_one_uniform_number_moves_all_parameters_of_a_table():
    made = study(joint_spread=[{"b0": 0.1, "a1": -0.3}])
    system: Any = made.system
    spec = made.scenarios[0].spec
    inputs = draw_plant_scenarios(
        spec, system.loop, system.parameters, system.timing, source_of(1, "search"), range(64)
    )
    rows = np.moveaxis(inputs.dynamics, -1, -2).reshape(-1, inputs.dynamics.shape[-2])[:64]
    columns = [column for column in rows.T if np.ptp(column) > 0.0]
    assert len(columns) == 2
    moved = sorted(np.ptp(column) / abs(column.mean()) for column in columns)
    assert moved[1] / moved[0] == pytest.approx(3.0, rel=0.1)
    assert abs(np.corrcoef(*columns)[0, 1]) == pytest.approx(1.0)


def test_a_study_without_a_joint_spread_has_the_digest_that_it_had():
    assert "joint_spread" not in study().table.scenario[0].model_dump()


@pytest.mark.parametrize(("rows", "message"), [([{"b0": 0.6}, {"b0": -0.6}], "b0 varies by 1.2"), ([{"k": 0.1}], "unknown joint_spread 'k'")])  # fmt: skip
def test_an_impossible_joint_spread_is_refused(rows, message):
    with pytest.raises(InputError, match=message):
        study(joint_spread=rows)


def test_the_sum_of_both_spreads_is_limited():
    with pytest.raises(InputError, match="b0 varies by 1.1"):
        PlantScenario("step", 1.0, spread={"b0": 0.5}, joint_spread=[{"b0": 0.6}])
