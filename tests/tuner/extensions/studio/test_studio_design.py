"""Speed and robustness: the rule of `tuner design` at its own robustness, slower integral action above it."""

import pytest

import tuner
from plant.errors import InputError
from tests.tuner.extensions.studio.conftest import STUDIES
from tuner.extensions.studio.design import Rules
from tuner.extensions.studio.session import open_session


@pytest.fixture(scope="module")
def rules():
    return Rules(open_session(STUDIES / "heater.toml"))


def moved(rules, time, robustness):
    """Values of the rule, and its notes."""
    answer = rules.designed(None, {"at": {"time": time, "robustness": robustness}})
    return answer["values"], answer["text"]


def test_the_rules_own_robustness_gives_the_rules_gains(rules):
    values, notes = moved(rules, 2.125, 1.0)
    # `tuner design heater --method simc` printed 3.00654, 0.130719 and 15.6863.
    assert values == pytest.approx(
        {"temperature.kp": 3.00654, "temperature.ki": 0.130719, "temperature.kd": 15.6863}, rel=1e-3
    )
    designed = tuner.design(STUDIES / "heater.toml", method="simc", time=2.125).gains
    assert values == pytest.approx({name: designed[name] for name in values}, rel=1e-12) and notes == ""


def test_robustness_slows_the_integral_action_alone(rules):
    one, two = (moved(rules, 4.0, robustness)[0] for robustness in (1.0, 2.0))
    assert two["temperature.ki"] == pytest.approx(0.5 * one["temperature.ki"])
    assert two["temperature.kp"] == one["temperature.kp"]


def test_values_beyond_a_range_end_there_with_a_note():
    values, notes = moved(Rules(open_session(STUDIES / "dc_motor.toml")), 0.02, 1.0)
    # SIMC has no derivative for an integrator, and the study's range of kd begins at 0.01.
    assert values["angle.kd"] == 0.01 and "angle.kd: the rule gives 0, the range ends at 0.01." in notes


@pytest.mark.parametrize(("time", "robustness"), [(0.0, 1.0), (1e9, 1.0), (2.0, 0.1), (2.0, 9.0)])
def test_numbers_outside_the_sliders_are_refused(rules, time, robustness):
    with pytest.raises(InputError, match="allowed: "):
        moved(rules, time, robustness)
