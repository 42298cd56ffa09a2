"""A reference that jumps to or beyond the error at which a flight is lost is refused; one that moves there smoothly is not."""

import pytest

from plant.errors import InputError
from tuner.study.files import SHIPPED
from tuner.study.kinds import load_any

MOTOR = SHIPPED / "dc_motor.toml"


def study(signal):
    """The shipped motor, which is lost from an error of 10 rad on, with a reference of its angle."""
    return load_any(MOTOR, {"scenario.0.reference.angle": signal, "constraint": []})


@pytest.mark.parametrize(
    "signal",
    [
        {"kind": "step", "size": 9.99},
        {"kind": "step", "size": 20.0, "time": 1.0},
        {"kind": "ramp", "size": 50.0, "time": 0.0, "until": 0.4},
        {"kind": "sine", "size": 20.0, "frequency": 1.0},
    ],
    ids=["below", "after the end", "ramp", "sine"],
)
def test_a_reference_that_some_gains_could_follow_is_taken(signal):
    assert study(signal).kind == "plant"


@pytest.mark.parametrize(
    "signal",
    [
        {"kind": "step", "size": 10.0},
        {"kind": "step", "size": -12.0, "time": 0.1, "until": 0.3},
        {"kind": "constant", "value": 11.0},
        {"kind": "ramp", "size": 50.0, "time": 0.1, "until": 0.1001},
    ],
    ids=["at the limit", "there and back", "from the start", "a ramp within a period"],
)
def test_a_reference_that_loses_every_flight_at_once_is_refused(signal):
    with pytest.raises(InputError, match="every flight would be lost there: raise lost_beyond") as caught:
        study(signal)
    assert caught.value.key == "scenario[0].reference.angle"
