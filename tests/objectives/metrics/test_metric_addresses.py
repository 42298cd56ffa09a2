"""Addresses, columns, and what is refused before a study flies."""

import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest

from objectives.meters import AxisMeter, Meters
from objectives.metrics import COLUMNS, METRICS, all_addresses, check, parse, unpack
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.sample import Targets
from tests.objectives.flying import AXES, flat, target, targets


def test_every_address_parses_to_itself() -> None:
    for text in all_addresses():
        address = parse(text)
        assert str(address) == text
        assert address.metric is METRICS[text.split(".")[0]]
        assert bool(address.axes) == ("." in text)
    assert len(set(all_addresses())) == len(all_addresses())


def test_groups_hold_axes_of_one_unit() -> None:
    assert parse("itae.position").axes == ("x", "y", "z")
    assert parse("itae.horizontal").axes == ("x", "y")
    assert parse("itae.attitude").axes == ("roll", "pitch", "yaw")
    assert parse("itae.tilt").axes == ("roll", "pitch")


@pytest.mark.parametrize(
    ("address", "unit"),
    [
        ("itae.roll", "rad"),
        ("ise.x", "m^2 s"),
        ("iae.attitude", "rad s"),
        ("overshoot.z", "%"),
        ("rise.yaw", "s"),
        ("travel", "1/s"),
        ("failure", "1"),
    ],
)
def test_units(address: str, unit: str) -> None:
    assert parse(address).unit == unit


@pytest.mark.parametrize(
    ("wrong", "nearest"),
    [
        ("itea.roll", "itae"),
        ("itae.rol", "itae.roll"),
        ("itae", "itae.z"),
        ("travel.x", "travel"),
        ("fail", "failure"),
        ("peak.atitude", "peak.attitude"),
        ("itae.x.x", "itae.x"),
    ],
)
def test_unknown_address_names_the_nearest(wrong: str, nearest: str) -> None:
    with pytest.raises(UnknownNameError, match=f"did you mean '{nearest}'"):
        parse(wrong)


@pytest.mark.parametrize("wrong", ["", ".", ".roll", "itae.", "travel."])
def test_incomplete_address_is_refused(wrong: str) -> None:
    with pytest.raises(UnknownNameError):
        parse(wrong)


def test_columns_are_depth_first() -> None:
    # Every scalar says where it stands, by name; flattening must meet them in the order of the columns.
    axes = (AxisMeter(*(f"{axis}.{field}" for field in AxisMeter._fields)) for axis in AXES)  # pyright: ignore
    meters = Meters(*axes, "travel", "effort", "saturated", "command_peak")  # pyright: ignore
    assert flat(meters) == list(COLUMNS)
    assert list(COLUMNS.values()) == list(range(len(AXES) * len(AxisMeter._fields) + 4))


def test_unpack_gives_views_by_name() -> None:
    array = np.arange(2.0 * len(COLUMNS)).reshape(2, -1)
    meters = unpack(Meters, array)
    np.testing.assert_array_equal(meters.yaw.steady_sum, array[:, COLUMNS["yaw.steady_sum"]])
    np.testing.assert_array_equal(meters.effort, array[:, COLUMNS["effort"]])
    assert np.shares_memory(np.asarray(meters.x.itae), array)


def test_unpack_refuses_rows_of_another_width() -> None:
    class Pair(NamedTuple):
        a: float
        b: float

    with pytest.raises(AssertionError):
        unpack(Pair, np.zeros((4, 3)))


STEPPING = targets(roll=target(0.0, 0.2, 1.0))


@pytest.mark.parametrize("address", ["overshoot.roll", "rise.attitude", "settling.x", "itae.position", "travel"])
def test_metrics_with_a_meaning_pass(address: str) -> None:
    check(parse(address), STEPPING, 10.0)


@pytest.mark.parametrize("address", ["overshoot.pitch", "rise.position", "overshoot.z"])
def test_step_metrics_need_a_step(address: str) -> None:
    with pytest.raises(InputError, match="needs a step"):
        check(parse(address), STEPPING, 10.0)


@pytest.mark.parametrize(
    ("address", "aims"),
    [
        ("overshoot.roll", STEPPING),
        ("settling.tilt", STEPPING),
        ("recovery.z", targets(z=target(recovery_from=1.0))),
        ("steady_error.position", targets(y=target(steady_from=2.0))),
    ],
)
def test_a_window_after_the_end_of_the_flight_is_refused(address: str, aims: Targets) -> None:
    check(parse(address), aims, 2.5)
    with pytest.raises(InputError, match="flight ends at 1.0 s"):
        check(parse(address), aims, 1.0)


def test_importing_metrics_and_risk_loads_nothing_heavy() -> None:
    code = "import sys, objectives.metrics, objectives.risk; print({'scipy', 'pandas', 'numba'} & set(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert loaded.stdout.strip() == "set()"
