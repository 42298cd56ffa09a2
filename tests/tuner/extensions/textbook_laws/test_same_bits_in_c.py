"""C of the laws of textbooks: the bits of Python's flights with noise, limits and delays, compiled with warnings as errors."""

import ctypes

import pytest

from plant.law_registry import LAWS
from tests.tuner.exchange.c99 import test_plant_c99 as drive
from tests.tuner.exchange.c99.test_plant_c99 import (
    STRICT,
    Actuator,
    Channel,
    assert_same_bits,
    compiled,
    plant_files,
    plant_system,
    usual_gains,
    written,
)

NAMES = ("pid_parallel", "pid_ideal", "pid_series", "pid_incremental", "adrc1", "model_following", "smith", "lead_lag")
CHANGED = {
    "pid_parallel": {"b": 0.4, "c": 1.0, "clamping": 1.0},
    "pid_ideal": {"b": 0.4, "c": 0.5},
    "smith": {"l_m": 0.037},
    "lead_lag": {"notch": 30.0, "notch_width": 6.0},
}


def case(name):
    """A drive under a law, limited and late, with gains at which the limits hold at times."""
    channel = Channel("position", LAWS[name], "angle", "voltage", b0=50.0, limit=10.0)
    system = plant_system(
        vars(drive), "drive", [channel], [Actuator("voltage", -6.0, 6.0, delay=0.004)], control_period=0.002
    )
    values = dict(zip((gain.info.name for gain in system.gains), usual_gains(system), strict=True))
    return system, [*(values | CHANGED.get(name, {})).values()]


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The controllers of all laws, compiled in one call."""
    folder = tmp_path_factory.mktemp("laws")
    for name in NAMES:
        system, gains = case(name)
        written(folder, plant_files(system, gains, real="double", name=name))
    sources = [f"{name}_controller.c" for name in NAMES]
    compiled(folder, "gcc", STRICT, "-shared", "-fPIC", *sources, "-o", "all.so")
    return ctypes.CDLL(str(folder / "all.so"))


@pytest.mark.parametrize("name", NAMES)
def test_c_gives_the_bits_of_python(library, name):
    assert_same_bits(library, name, *case(name))
