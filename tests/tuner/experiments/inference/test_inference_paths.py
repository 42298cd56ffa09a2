"""Dotted paths into a contest's tables."""

import re

import pytest

from plant.errors import InputError
from tuner.study.unknown_paths import place_of, put_at, value_at


def table():
    return {
        "controller": {"attitude": "pid", "control_period": 0.004},
        "gains": {"roll.k1": 1.0, "tilt.lambda": {"low": 1.0}},
        "contender": [
            {"name": "PID", "gains": {"attitude.kp": 2.0}},
            {"name": "PID v1.0", "gains": {"attitude.kp": 3.0}},
            {"name": "bare"},
            {"name": "PID v1", "gains": {"attitude.kp": 4.0}},
        ],
        "scenario": [{"name": "a", "air": {"window": [0.0, 5.0]}}, {"name": "b"}],
    }


@pytest.mark.parametrize(
    ("path", "place", "value"),
    [
        ("controller.control_period", ("controller", "control_period"), 0.004),
        ("gains.roll.k1", ("gains", "roll.k1"), 1.0),
        ("gains.tilt.lambda.low", ("gains", "tilt.lambda", "low"), 1.0),
        ("contender.PID.gains.attitude.kp", ("contender", 0, "gains", "attitude.kp"), 2.0),
        ("contender.PID v1.0.gains.attitude.kp", ("contender", 1, "gains", "attitude.kp"), 3.0),
        ("contender.PID v1.gains.attitude.kp", ("contender", 3, "gains", "attitude.kp"), 4.0),
        ("scenario.0.air.window.1", ("scenario", 0, "air", "window", 1), 5.0),
        ("scenario.1.bands.attitude", ("scenario", 1, "bands", "attitude"), None),
        ("contender.bare.gains.attitude.kp", ("contender", 2, "gains", "attitude.kp"), None),
        ("limits.position", ("limits", "position"), None),
    ],
)
def test_a_path_leads_to_its_value_and_back(path, place, value):
    content = table()
    assert place_of(content, path) == place
    assert value_at(content, place) == value
    assert content == table(), "looking changes nothing"
    put_at(content, place, 9.5)
    assert value_at(content, place) == 9.5
    put_at(content, place, value)
    if value is not None:
        assert content == table()


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("", "'' leads to nothing; a path leads to one number; there is: controller, gains, contender, scenario"),
        ("scenario", "'scenario' leads to a list; a path leads to one number; go on with an entry, 0 to 1"),
        ("contender.PID", "'contender.PID' leads to a table; a path leads to one number; there is: name, gains"),
        ("gains.tilt.lambda", "'gains.tilt.lambda' leads to a table; a path leads to one number; there is: low"),
        ("scenario.2.duration", "'2' is no entry of the list 'scenario'; allowed: 0 to 1"),
        ("scenario.first.duration", "'first' is no entry of the list 'scenario'; allowed: 0 to 1"),
        ("scenario.0.air.window.2", "'2' is no entry of the list 'scenario.0.air.window'; allowed: 0 to 1"),
        (
            "contender.PIDD.gains.attitude.kp",
            "unknown contender 'PIDD'; did you mean 'PID'? valid: PID, PID v1, PID v1.0, bare",
        ),
        (
            "controller.attitude.kp",
            "'controller.attitude.kp' goes on behind 'attitude', which is a value; end the path there",
        ),
    ],
)
def test_a_path_that_leads_nowhere(path, message):
    with pytest.raises(InputError, match=f"^{re.escape(message)}$"):
        place_of(table(), path)


def test_an_empty_list_has_no_entries():
    with pytest.raises(InputError, match="allowed: none, the list is empty"):
        place_of({"scenario": []}, "scenario.0.duration")
