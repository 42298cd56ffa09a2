"""What an AirSpec refuses, and that it says which key, what is allowed and what to do."""

from json import loads

import numpy as np
import pytest

from plant.air.air import AirSpec
from plant.air.gust import Gust
from plant.air.injection import Injection
from plant.errors import InputError, UnknownNameError

BAD = [
    ("spec", "8785D", "8785C"),
    ("intensity", "lihgt", "did you mean 'light'"),
    ("intensity", -1.0, "at least 0"),
    ("intensity", float("nan"), "finite"),
    ("intensity", True, "finite number"),
    ("altitude", 0.0, "greater than 0"),
    ("altitude", 30000.0, "at most 24384"),
    ("altitude", "10", "finite number"),
    ("vehicle_speed", float("inf"), "finite"),
    ("minimum_airspeed", 0.0, "greater than 0"),
    ("wind_direction_deg", "north", "finite number"),
    ("mean_wind", 1, "true or false"),
    ("angular_rates", "yes", "true or false"),
    ("span", -0.3, "greater than 0"),
    ("roughness", "D", "A, B, C"),
    ("window", (1.0,), "2 numbers"),
    ("window", 5.0, "2 numbers"),
    ("window", (-1.0, 5.0), "at least 0"),
    ("window", (3.0, 3.4), "at least 0.5 s after"),
    ("window", (5.0, 1.0), "at least 0.5 s after"),
]


@pytest.mark.parametrize(("key", "value", "message"), BAD, ids=lambda x: str(x))
def test_unusable_values(key, value, message):
    with pytest.raises(InputError, match=message) as caught:
        AirSpec(**{key: value})
    assert caught.value.key == key


def test_a_numeric_intensity_needs_low_altitude():
    with pytest.raises(InputError, match="give one of: none, light, moderate, severe") as caught:
        AirSpec(intensity=5.0, altitude=400.0)
    assert caught.value.key == "intensity"
    assert AirSpec(intensity="light", altitude=400.0).field.sigma[0] > 0.0


GOOD_GUST = {"amplitude": 1.0, "start": 0.0, "length": 1.0}


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("amplitude", None),
        ("start", -1.0),
        ("length", 0.0),
        ("direction", "x"),
        ("direction", (0, 0, 0)),
        ("direction", (1, 0)),
    ],
)
def test_unusable_gusts(key, value):
    with pytest.raises(InputError) as caught:
        Gust(**{**GOOD_GUST, key: value})
    assert caught.value.key == f"gust.{key}"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("acceleration_sigma", (1.0, -1.0, 0.0)),
        ("angular_time", (1.0, 0.0, 1.0)),
        ("angular_bias", (0.0, 0.0)),
        ("acceleration_bias", 1.0),
        ("acceleration_time", "abc"),
    ],
)
def test_unusable_injections(key, value):
    with pytest.raises(InputError) as caught:
        Injection(**{key: value})
    assert caught.value.key == f"injection.{key}"


def test_unknown_names_are_their_own_kind_of_error():
    with pytest.raises(UnknownNameError):
        AirSpec(intensity="windy")


def test_lists_become_tuples_so_that_a_spec_can_be_a_key():
    read = loads('{"window": [0, 5], "direction": [0, 0, 2], "bias": [0, 1, 0]}')
    injection = Injection(angular_bias=read["bias"])
    listed = AirSpec(window=read["window"], gust=Gust(1.0, 0.0, 1.0, read["direction"]), injection=injection)
    same = AirSpec(
        window=(0.0, 5.0), gust=Gust(1.0, 0.0, 1.0, (0.0, 0.0, 2.0)), injection=Injection(angular_bias=(0.0, 1.0, 0.0))
    )
    assert listed == same
    assert hash(listed) == hash(same)


@pytest.mark.parametrize("value", [np.float64(3.0), 3, 3.0])
def test_any_plain_number_will_do(value):
    assert AirSpec(intensity=value, altitude=value + 7).field.sigma[2] == pytest.approx(0.3)
