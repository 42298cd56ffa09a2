"""The contract of all certificates, over every law and axis; and how an axis is taken from a cascade."""

import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from objectives.linear_axis.axis_of_cascade import axis_loop
from objectives.linear_axis.channel_model import MODELLED, AxisLoop, RotorLag, TiltLoop, closed_loop
from objectives.lmi import MARGIN, coordinates, is_negative, is_positive
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.cascade import AXES, close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions, Nominal, nominal
from tests.plant.harness import VEHICLES
from tuner.extensions.certificates.registry import CERTIFICATES

TIMING = Timing(0.004, 0.001)
HUMMINGBIRD = VEHICLES["hummingbird"]
CASCADES = {name: close_cascade(law, law) for name, law in LAWS.items()}


def known(**options: Any) -> Nominal:
    return nominal(HUMMINGBIRD, ControlOptions(**options), TIMING.control_period)


def axis_of(law: str, axis: str, **options: Any) -> AxisLoop:
    cascade = CASCADES[law]
    return axis_loop(cascade, default_row(cascade), known(**options), TIMING, axis)


@pytest.mark.parametrize("name", CERTIFICATES)
def test_entries(name: str) -> None:
    info = CERTIFICATES[name]
    assert info.name == name
    assert info.laws and info.laws <= set(LAWS)
    assert info.title and info.source


# Matrices of x, which tilts, are the largest.
CASES = ("roll", "z", pytest.param("x", marks=pytest.mark.slow))


@pytest.mark.parametrize("axis", CASES)
@pytest.mark.parametrize("name", CERTIFICATES)
def test_every_law_gets_an_answer(name: str, axis: str) -> None:
    """A number with proof and reason, or none with a reason; never an exception, never not a number."""
    info = CERTIFICATES[name]
    # All laws on one axis; on the others two, as the matrices are larger there.
    laws = sorted(info.laws) if axis == "roll" else sorted(info.laws)[-2:]
    for law in laws:
        case = axis_of(law, axis, delay=True)
        if not info.applies_to(case):
            continue
        found = info.run(case)
        assert found.verified is (found.value is not None)
        assert found.value is None or np.isfinite(found.value)
        assert found.unit and found.why


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-8, -1e-6])
def test_nothing_is_raised_at_the_edge_of_stability(distance: float) -> None:
    """A loop as close to the edge as bisection gets it: an answer or none, the same way."""
    axis = axis_of("hybrid", "roll", delay=True)

    def slowest(k2: float) -> float:
        return float(np.linalg.eigvals(closed_loop(replace(axis, gains=axis.gains._replace(k2=k2))).a).real.max(axis=0))

    edge: Any = brentq(slowest, 50.0, 500.0)
    case = replace(axis, gains=axis.gains._replace(k2=(1.0 - distance) * edge))
    for name in ("peak_gain", "circle_criterion", "common_lyapunov"):
        found = CERTIFICATES[name].run(case)
        assert found.verified is (found.value is not None)
        assert distance > 0.0 or found.value is None


def test_what_they_apply_to() -> None:
    circle, spread = CERTIFICATES["circle_criterion"], CERTIFICATES["common_lyapunov"]
    assert circle.applies_to(axis_of("hybrid", "roll"))
    assert not circle.applies_to(axis_of("ladrc", "roll"))
    assert spread.applies_to(axis_of("ladrc", "x"))
    mixed = close_cascade(LAWS["ladrc"], LAWS["adrc"])
    horizontal = axis_loop(mixed, default_row(mixed), known(), TIMING, "x")
    vertical = axis_loop(mixed, default_row(mixed), known(), TIMING, "z")
    assert "adrc" not in MODELLED
    assert not spread.applies_to(horizontal)
    assert spread.applies_to(vertical)


@pytest.mark.parametrize("axis", AXES)
def test_an_axis_has_the_gains_of_its_addresses(axis: str) -> None:
    cascade = CASCADES["ladrc"]
    row = np.arange(1.0, 1.0 + len(default_row(cascade)))
    expected = {g.info.name: row[g.column] for g in gain_addresses(cascade) if g.axis == axis}
    case = axis_loop(cascade, row.tolist(), known(), TIMING, axis)
    assert case.gains._asdict() == expected
    assert case.loop == ("attitude" if axis in ("roll", "pitch", "yaw") else "position")


def test_horizontal_axes_act_through_the_attitude_that_tilts_them() -> None:
    cascade = CASCADES["ladrc"]
    row = np.arange(1.0, 1.0 + len(default_row(cascade))).tolist()
    for axis, tilted in (("x", "pitch"), ("y", "roll")):
        actuator = axis_loop(cascade, row, known(), TIMING, axis).actuator
        assert isinstance(actuator, TiltLoop)
        assert actuator.attitude == axis_loop(cascade, row, known(), TIMING, tilted)
    assert isinstance(axis_loop(cascade, row, known(), TIMING, "z").actuator, RotorLag)


@pytest.mark.parametrize(("delay", "expected"), [(False, 0.002), (True, 0.006)])
def test_rotors_and_options(delay: bool, expected: float) -> None:
    """Half a period of hold, one of computing; the mean of the two lags; knowledge and rates as the options say."""
    case = axis_of("ladrc", "roll", delay=delay, lag_aware=False, attitude_rate="observer")
    mean = 0.5 * (HUMMINGBIRD.lag_up + HUMMINGBIRD.lag_down)
    assert isinstance(case.actuator, RotorLag)
    assert (case.actuator.lag, case.actuator.delay) == pytest.approx((mean, expected))
    assert not case.actuator.lag_aware
    assert case.from_observer
    assert not axis_of("ladrc", "z", attitude_rate="observer").from_observer
    assert axis_of("ladrc", "z", position_rate="observer").from_observer
    assert axis_of("ladrc", "z").actuator.lag_aware


@pytest.mark.parametrize("law", ["pid", "ladrc", "hybrid"])
def test_coordinates_contract(law: str) -> None:
    """In them |z| falls at every state, and going back and forth changes nothing."""
    a = closed_loop(axis_of(law, "x")).a
    z = coordinates(a)
    scaled = z.dynamics(a)
    assert is_negative(scaled + scaled.T)
    np.testing.assert_allclose(z.transform @ z.inverse, np.eye(len(a)), atol=1e-9)
    np.testing.assert_allclose(
        np.sort(np.linalg.eigvals(scaled).real) * z.rate, np.sort(np.linalg.eigvals(a).real), rtol=1e-4
    )
    assert is_negative(a.T @ z.original(np.eye(len(a))) + z.original(np.eye(len(a))) @ a, margin=0.0)


def test_eigenvalues_decide_with_room() -> None:
    assert is_negative(np.diag([-1.0, -2.0]))
    assert not is_negative(np.diag([0.0, -2.0]))
    assert not is_negative(np.diag([-0.5 * MARGIN, -1.0]))
    assert is_positive(np.diag([1.0, 2.0]))
    assert not is_positive(np.diag([-1.0, 2.0]))
    assert not is_positive(np.array([[1.0, 2.0], [2.0, 1.0]]))


def test_the_registry_stays_out_of_the_way() -> None:
    """The command line must not pay for cvxpy unless it certifies something."""
    import subprocess

    code = "import objectives.problem, tuner.cli.main, sys; print('cvxpy' in sys.modules or 'casadi' in sys.modules)"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "False"
