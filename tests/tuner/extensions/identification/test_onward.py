"""Thrust curve and dead time in the airframe file that is written: value and slope at hover, with their uncertainty."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import Actuation, actuation
from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.identification.hover_curve import hover_curve
from tuner.extensions.identification.identify import Identified
from tuner.extensions.identification.onward import THRUSTS, identified_text, identified_values, uncertainty_of
from tuner.extensions.vehicle_fit.parameters import space_of

PRIOR = load("crazyflie-pybullet")
WEIGHT = 0.25 * PRIOR.vehicle.mass * PRIOR.vehicle.gravity


def written(identified: Identified, folder: Path) -> Vehicle:
    (folder / "mine.toml").write_text(identified_text(identified, "A Crazyflie"), encoding="utf-8")
    return load(folder / "mine.toml").vehicle


def thrust_at(rotors: Actuation, u: float) -> float:
    return rotors.thrust_max * (rotors.curve * u * u + (1.0 - rotors.curve) * u)


def test_the_file_has_command_and_slope_of_the_identified_curve_at_hover(crazyflie: Identified, tmp_path: Path) -> None:
    """The parabola's root at the weight of a rotor; without a share that is linear, hover took 0.69 of full command."""
    c0, c1, c2 = crazyflie.space.numbers(crazyflie.fit.estimate).curve.tolist()
    u = max(np.roots([c2, c1, c0 - WEIGHT]))
    rotors = actuation(written(crazyflie, tmp_path))
    assert rotors.hover_command == pytest.approx(u, rel=1e-4)
    assert rotors.hover_slope == pytest.approx(c1 + 2.0 * c2 * u, rel=1e-4)


@pytest.mark.parametrize(
    "thrusts", [(0.03, 0.07, 0.13), (0.012, 0.055, 0.13), (0.02, 0.08, 0.135), (0.036, 0.075, 0.13)]
)
def test_curves_of_any_bend_are_met_at_hover(thrusts: tuple[float, float, float]) -> None:
    """From a line to one that is steeper than the square: value and slope in closed form, gradients by differences."""
    space = space_of(PRIOR.vehicle, [])
    numbers = space.numbers(space.center)._replace(thrust=np.array(thrusts))
    found = hover_curve(numbers, WEIGHT)
    u, a = found.command, found.linear
    full = found.thrust / found.share(a)
    slope = numbers.curve[1] + 2.0 * numbers.curve[2] * u
    assert found.thrust == pytest.approx(WEIGHT, rel=1e-12)
    assert full * (2.0 * (1.0 - a) * u + a) == pytest.approx(slope, rel=1e-12)
    for k in range(3):
        step = np.exp(1e-6 * np.eye(3)[k])
        up, down = (numbers._replace(thrust=numbers.thrust * step**sign) for sign in (1.0, -1.0))
        values = [float(np.polyval(each.curve[::-1], u)) for each in (up, down)]
        slopes = [each.curve[1] + 2.0 * each.curve[2] * u for each in (up, down)]
        shares = [share_of(u, u * s / t) for s, t in zip(slopes, values, strict=True)]
        assert found.by_thrust[k] == pytest.approx(np.log(values[0] / values[1]) / 2e-6, rel=1e-6, abs=1e-8)
        assert found.by_linear[k] == pytest.approx((shares[0] - shares[1]) / 2e-6, rel=1e-5, abs=1e-8)


def test_a_curve_flatter_than_a_line_is_written_as_a_line() -> None:
    space = space_of(PRIOR.vehicle, [])
    numbers = space.numbers(space.center)._replace(thrust=np.array([0.05, 0.08, 0.13]))
    assert hover_curve(numbers, WEIGHT).linear == 1.0


def share_of(u: float, exponent: float) -> float:
    """Share a of a curve with that exponent at a command: (2 (1 - a) u + a)/((1 - a) u + a) = exponent, solved for a."""
    return float(np.linalg.solve([[1.0 - 2.0 * u - exponent * (1.0 - u)]], [u * (exponent - 2.0)])[0])


def test_vehicles_that_are_drawn_have_value_and_slope_of_the_posterior(crazyflie: Identified, tmp_path: Path) -> None:
    """Deviation of the thrust at the hover command and of its slope there, over 4000 draws: 1.1 % standard error."""
    space, fit = crazyflie.space, crazyflie.fit
    vehicle, uncertainty = written(crazyflie, tmp_path), uncertainty_of(crazyflie)
    u, draw = actuation(vehicle).hover_command, np.random.default_rng(5)
    assert {"thrust_linear", "dead_time"} <= set(uncertainty.names)
    drawn = [
        uncertainty.moved(vehicle, uncertainty.axes @ draw.standard_normal(len(uncertainty.names))) for _ in range(4000)
    ]
    ours = np.array([[thrust_at(actuation(v), u), thrust_at(actuation(v), u + 1e-4)] for v in drawn])
    nodes = [space.names.index(name) for name in THRUSTS]
    logs = draw.multivariate_normal(fit.estimate[nodes], fit.covariance[np.ix_(nodes, nodes)], 4000)
    curves = np.linalg.solve(np.vander([0.3, 0.65, 1.0], 3, increasing=True), np.exp(logs).T)
    theirs = np.array([np.vander([u, u + 1e-4], 3, increasing=True) @ curve for curve in curves.T])
    for column in (lambda t: t[:, 0], lambda t: np.diff(t, axis=1)[:, 0]):
        assert np.std(column(ours)) == pytest.approx(np.std(column(theirs)), rel=0.06)
        assert np.mean(column(ours)) == pytest.approx(np.mean(column(theirs)), rel=0.01)
    at = space.names.index("dead_time")
    assert uncertainty.deviations[uncertainty.names.index("dead_time")] == pytest.approx(
        np.sqrt(fit.covariance[at, at]), rel=1e-3
    )


def test_a_slope_that_the_log_does_not_tell_stays_as_before(crazyflie: Identified, tmp_path: Path) -> None:
    """Hover takes the identified command all the same."""
    wide = crazyflie.fit.covariance.copy()
    nodes = [crazyflie.space.names.index(name) for name in THRUSTS]
    wide[nodes, nodes] += 0.2
    untold = replace(crazyflie, fit=replace(crazyflie.fit, covariance=wide))
    rotors = actuation(written(untold, tmp_path))
    assert "thrust_linear" not in identified_values(untold, ()) and "thrust_linear" not in uncertainty_of(untold).names
    assert rotors.curve == 1.0
    assert rotors.hover_command == pytest.approx(actuation(written(crazyflie, tmp_path)).hover_command, rel=1e-4)


def test_a_prior_with_a_curve_begins_at_it() -> None:
    """Thrusts at 30, 65 and 100 % of the airframe's own curve."""
    vehicle = PRIOR.vehicle._replace(thrust_linear=0.4)
    space = space_of(vehicle, [])
    rotors = actuation(vehicle)
    wanted = [thrust_at(rotors, u) for u in (0.3, 0.65, 1.0)]
    assert space.numbers(space.center).thrust == pytest.approx(wanted, rel=1e-12)
