"""What goes to the card: scenarios as the last axis, and model functions with every number in one precision."""

import warnings
from pathlib import Path
from types import FunctionType

import numpy as np
import pytest

from objectives import memory, meters
from objectives.memory import flight_code
from plant.backends.flyer import to_lanes
from plant.backends.lane_layout import LANES
from plant.primitives import __all__ as primitives
from plant.quadrotor.closed_loop import LARGEST_STATE
from plant.records import flatten
from tests.plant.backends.test_primitives import PAIRS as NUMBERS
from tests.plant.backends.test_primitives import WANTED, every
from tests.plant.loops import loop
from tests.tuner.extensions.cuda.flights import PAIRS
from tuner.extensions.cuda import kernel
from tuner.extensions.cuda.flights import by_scenario, launcher
from tuner.extensions.cuda.kernel import CudaRebinder


@pytest.mark.parametrize("rows", [3, 0])
@pytest.mark.parametrize("count", [1, LANES, LANES + 3])
def test_blocks_of_lanes_become_scenarios_without_the_padding(count, rows):
    drawn = np.random.default_rng(1).standard_normal((count, 5, rows))
    assert np.array_equal(by_scenario(to_lanes(drawn), count), np.moveaxis(drawn, 0, -1))


def numbers(function, found, seen):
    """Collect the numbers that a function and all that it calls are written with."""
    if id(function) in seen:
        return
    seen.add(id(function))
    held = [*function.__code__.co_consts, *[cell.cell_contents for cell in function.__closure__ or ()]]
    for value in [*held, *function.__globals__.values()]:
        if isinstance(value, FunctionType):
            numbers(value, found, seen)
        elif isinstance(value, float | np.floating):
            found.append(value)


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_single_precision_leaves_no_number_double(pair):
    names = dict.fromkeys(primitives, 0)
    bind = CudaRebinder(names, lambda function: function, np.float32)
    found, closed = [], loop(*pair)
    for function in (closed.start, closed.decide, closed.advance):
        numbers(bind(function), found, set())
    assert len(found) > 50
    assert {type(value) for value in found} == {np.float32}
    assert np.float32(LARGEST_STATE) in found
    # Nothing that a law divides by or compares with vanishes in single precision.
    tiny = np.finfo(np.float32).tiny
    assert all(value == 0.0 or abs(value) > tiny for value in found) and np.isfinite(found).all()


def test_double_precision_takes_functions_as_they_are():
    bind = CudaRebinder(dict.fromkeys(primitives, 0), lambda function: function, np.float64)
    assert bind(loop().advance).__code__ == loop().advance.__code__


@pytest.mark.parametrize("colour", ["", "\x1b[1m"])
def test_a_launch_that_does_not_fill_the_card_warns_nobody(colour):
    class Kernel:
        def __getitem__(self, shape):
            warnings.warn(f"{colour}Grid size {shape[0]} will likely result in GPU under-utilization", stacklevel=2)
            return shape

    assert launcher(Kernel(), 130) == (2, 128)


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_a_card_has_a_name_for_each(real, monkeypatch):
    monkeypatch.setattr(kernel, "_inline", lambda function: function)
    names = kernel._names(real)
    assert set(names) == set(primitives)
    for (a, b), wanted in zip(NUMBERS[:20], WANTED, strict=False):
        given = flatten(CudaRebinder(names, lambda function: function, real)(every)(real(a), real(b)))
        np.testing.assert_allclose(given, wanted, rtol=1e-5, atol=1e-6)


def test_keys_of_flights_hold_the_files_of_a_kernel():
    _, sources = kernel.kernel_names(loop(), "float64")
    plant = Path(next(iter(memory.plant.__path__)))
    outside = {file for file in sources if file.is_file() and not file.is_relative_to(plant)}
    assert outside - {Path(str(meters.__file__))} == {Path(str(kernel.__file__))} <= set(flight_code().values())
