"""One Lyapunov function for a box of vehicles, against eigenvalues inside the box and a textbook limit."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from scipy.linalg import expm

from objectives.linear_axis.channel_model import AxisLoop, Factors, TiltLoop, closed_loop
from plant.laws import ladrc, pid
from plant.seeds import generator
from tests.objectives.linear_axis.cases import HYBRID, LADRC, PID, ROTORS, is_negative
from tuner.extensions.certificates.common_lyapunov import common_matrix, corners, run

OUTER = AxisLoop("ladrc", ladrc.Gains(1.2, 1.0, 4.0), TiltLoop(LADRC), "position")
AXES = {"ladrc": LADRC, "pid": PID, "hybrid": HYBRID, "horizontal": OUTER}


def inside(axis: AxisLoop, spread: float, count: int = 200) -> list[np.ndarray]:
    """A of vehicles drawn inside the box."""
    draw = generator(5, "tests/box", 0).uniform(-spread, spread, (count, 2))
    return [closed_loop(axis, Factors(mass=1.0 + m, inertia=1.0 + i)).a for m, i in draw.tolist()]


@pytest.mark.parametrize("name", AXES)
def test_every_vehicle_inside_the_box_is_covered(name: str) -> None:
    """Its eigenvalues, and the same P: A'P + PA < 0 at points that no inequality was written for."""
    found = run(AXES[name])
    assert found.verified and found.value is not None
    p, factor = found.data["P"], np.sqrt(np.outer(np.diag(found.data["P"]), np.diag(found.data["P"])))
    assert is_negative(-p / factor)
    for a in inside(AXES[name], found.value):
        assert np.linalg.eigvals(a).real.max(axis=0) < 0.0
        assert is_negative((a.T @ p + p @ a) / factor)


def test_the_bound_holds_while_the_vehicle_changes() -> None:
    """Inertia jumping at random within the box: x'Px falls, the point of a common function."""
    p, h = common_matrix(corners(LADRC, 0.2)), 0.01
    assert p is not None
    draw = generator(6, "tests/jumps", 0)
    x = draw.standard_normal(len(p)) / np.sqrt(np.diag(p))
    size = float(x @ p @ x)
    for inertia in draw.uniform(0.8, 1.2, 100).tolist():
        x = expm(h * closed_loop(LADRC, Factors(inertia=inertia)).a) @ x
        after = float(x @ p @ x)
        assert after <= size * (1.0 + 1e-9)
        size = after


def test_more_is_asked_less_is_certified() -> None:
    plain, rotors_too = run(LADRC).value, run(LADRC, varied=("inertia", "lag")).value
    assert plain is not None and rotors_too is not None and rotors_too < plain


def test_corners_of_a_box() -> None:
    """An attitude axis does not feel the mass; a horizontal one feels mass and inertia."""
    assert len(corners(LADRC, 0.3)) == 2
    assert len(corners(replace(LADRC, loop="position"), 0.3)) == 2
    assert len(corners(OUTER, 0.3)) == 4
    assert len(corners(LADRC, 0.3, ("inertia", "lag"))) == 4
    light = closed_loop(LADRC, Factors(inertia=0.7)).a
    assert any(np.array_equal(light, a) for a in corners(LADRC, 0.3))


@pytest.mark.parametrize(("a", "feasible"), [(5.8, True), (5.85, False)])
def test_the_textbook_limit(a: float, feasible: bool) -> None:
    """R. Shorten, K. Narendra: [[-1, -1], [1, -1]] and [[-1, -a], [1/a, -1]], both stable, share one up to a = 3 + sqrt(8)."""
    pair = [np.array([[-1.0, -1.0], [1.0, -1.0]]), np.array([[-1.0, -a], [1.0 / a, -1.0]])]
    assert a < 3.0 + sqrt(8.0) or not feasible
    assert (common_matrix(pair) is not None) is feasible


def test_an_unstable_vehicle_in_the_box_is_never_certified() -> None:
    """A fast PD law through a slow actuator: its gain margin is the most that any certificate may give."""
    quick = replace(PID, gains=pid.Gains(400.0, 400.0, 30.0, 0.005))
    spreads = np.linspace(0.0, 0.9, 901)
    light = [np.linalg.eigvals(closed_loop(quick, Factors(inertia=1.0 - x)).a).real.max(axis=0) < 0.0 for x in spreads]
    margin = float(spreads[np.argmin(light)])
    assert 0.1 < margin < 0.8
    certified = run(quick).value
    assert certified is not None and certified < margin
    assert common_matrix(corners(quick, margin + 0.01)) is None


def test_what_cannot_be_certified() -> None:
    unstable = replace(LADRC, gains=ladrc.Gains(60.0, 1.0, 75.0))
    none = run(unstable)
    assert none.value is None and not none.verified
    assert ROTORS.lag_aware
