"""Numbers as parameter files need them: the shortest float32, positional, with a dot; and files read with care."""

import re
from math import inf, nan
from pathlib import Path

import numpy as np
import pytest

from plant.errors import InputError
from plant.seeds import generator
from tuner.extensions.autopilots.parameters import (
    MAX_VALUE,
    ParameterInfo,
    enter,
    parameters,
    positional,
    range_violation,
    read_lines,
    read_number,
    single,
)

FILE = Path("vehicle.params")
# mavros reads float(x) if "." in x else int(x): anything else breaks it.
MAVROS = re.compile(r"-?\d+\.\d+")


@pytest.mark.parametrize(
    ("value", "text"),
    [(5e-5, "0.00005"), (1.0, "1.0"), (0.142, "0.142"), (0.0, "0.0"), (-0.0, "0.0"), (1e10, "10000000000.0")],
)
def test_numbers_are_positional(value, text):
    assert positional(value) == text


def test_every_number_reads_back_as_the_same_float32():
    drawn = generator(1, "test/parameter_text", 0)
    values = np.concatenate(
        (10.0 ** drawn.uniform(-30.0, 30.0, 500), -(10.0 ** drawn.uniform(-8.0, 8.0, 500)), [MAX_VALUE])
    )
    for value in values:
        text = positional(float(value))
        assert MAVROS.fullmatch(text), text
        assert np.float32(text) == np.float32(value) and single(float(text)) == single(float(value))


@pytest.mark.parametrize(("text", "value"), [("5e-05", 5e-5), (".5", 0.5), ("-1", -1.0), ("+2.", 2.0), ("1E3", 1000.0)])
def test_numbers_are_read_with_exponents(text, value):
    assert read_number(text, "A", FILE) == value


@pytest.mark.parametrize("text", ["nan", "inf", "-Infinity", "", "1_0", "0x10", "1,5", "1e400", "1e39", "one", "1 2"])
def test_what_is_no_number_is_refused_by_name(text):
    with pytest.raises(InputError, match="vehicle.params: MC_P: given '.*'; this must be a finite number"):
        read_number(text, "MC_P", FILE)


def test_a_parameter_given_twice():
    values = {}
    enter(values, "A", 1.0, FILE)
    enter(values, "A", 1.0, FILE)
    with pytest.raises(InputError, match="A: given twice, as 1 and as 2"):
        enter(values, "A", 2.0, FILE)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="no such file; give a file"):
        read_lines(tmp_path / "none", "a file")
    (tmp_path / "bytes").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="UTF-8"):
        read_lines(tmp_path / "bytes", "a file")
    with pytest.raises(InputError, match="cannot be read"):
        read_lines(tmp_path, "a file")


TABLE = {
    "MC_P": ParameterInfo("MC_P", "1/s", 0.1, 0.6, 0.3, "roll.kd"),
    "MC_N": ParameterInfo("MC_N", "1", 0.0, MAX_VALUE, 1.0, "roll.ki"),
}


@pytest.mark.parametrize(
    ("value", "words"), [(0.61, "0.1 to 0.6 1/s: change roll.kd"), (nan, "works out at nan"), (inf, "at inf")]
)
def test_values_out_of_range_are_refused(value, words):
    with pytest.raises(InputError, match=f"MC_P: .*{words}"):
        parameters(TABLE, {"MC_P": value}, single, "PX4 1.16")


def test_values_without_upper_limit_and_at_the_limit():
    with pytest.raises(InputError, match="MC_N: works out at -1, allowed at least 0: change"):
        parameters(TABLE, {"MC_N": -1.0}, single, "PX4 1.16")
    (at_limit,) = parameters(TABLE, {"MC_P": 0.6}, single, "PX4 1.16")
    assert at_limit.low <= at_limit.held <= at_limit.high and at_limit.unrounded == 0.6 and at_limit.usual == 0.3
    assert range_violation(TABLE, {"MC_P": 0.6, "MC_N": 5.0}) == 0.0
    assert range_violation(TABLE, {"MC_P": 0.85}) == pytest.approx(0.5, rel=1e-6)
    assert range_violation(TABLE, {"MC_P": 0.05}) == pytest.approx(0.1, rel=1e-6)
