"""The weight over the mean command as a datum, flights too short to validate, and motor commands that a logger held."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from tests.tuner.extensions.identification.conftest import identify_roughly
from tests.tuner.extensions.identification.known_flights import AIRFRAME, KnownFlight, known_flights, misses
from tuner.extensions.identification.api import check_logs, identify
from tuner.extensions.identification.identify import resample_segments
from tuner.extensions.identification.onward import identified_text
from tuner.extensions.logs.reading import read_log
from tuner.extensions.vehicle_fit import fit
from tuner.extensions.vehicle_fit.parameters import THRUSTS, space_of
from tuner.extensions.vehicle_fit.weight import condition_on_weight, weigh

CRAZYFLIE = Path(__file__).parents[1] / "logs" / "crazyflie" / "log15_70_to_85"


@pytest.fixture(scope="module")
def level() -> KnownFlight:
    """A flight whose lift is not shaken, of a vehicle that hovers at 8 % less command than the prior."""
    return known_flights(1, duration=9.0, seed=2, excited=("roll", "pitch", "yaw"))[0]


def hover_of(vehicle):
    """Command at which four rotors of T = c w^2, w = u w_max, with the curve (1 - a) u^2 + a u, carry a vehicle: by bisection."""
    low, high, u, a = 0.0, 1.0, 0.5, vehicle.thrust_linear
    full = 4.0 * vehicle.thrust_coefficient * vehicle.speed_max**2
    for _ in range(60):
        u = 0.5 * (low + high)
        low, high = (low, u) if full * ((1.0 - a) * u * u + a * u) > vehicle.mass * vehicle.gravity else (u, high)
    return u


def problem_of(log):
    samples = resample_segments([log])
    masks = tuple(np.ones(len(part.time)) for part in samples)
    return fit.Problem(space_of(AIRFRAME.vehicle, ["1"]), AIRFRAME.vehicle, samples, masks)


def test_mean_and_change_of_lift_are_those_of_a_straight_line(level):
    """Of lift that falls from 10 to 9 m/s2 in all; a part of it has the mean of its own ages."""
    problem = problem_of(level.log.between(0.0, 3.0))
    (age,) = [part.output_age for part in problem.samples]
    mean, change = weigh(problem, [np.stack([0.0 * age] * 3 + [10.0 - age], axis=1)])
    assert mean * 0.02 * AIRFRAME.vehicle.gravity == pytest.approx(9.5, rel=1e-3)
    assert change * 0.03 * AIRFRAME.vehicle.gravity == pytest.approx(-1.0, rel=1e-9)


def test_the_weight_leaves_what_no_mean_lift_depends_on(level):
    """Thrusts become as certain as the mean lift, 2 %, the mass, 2 %, the bias, 1.5 %, and the battery allow; inertias stay."""
    problem = problem_of(level.log)
    space = condition_on_weight(problem, problem.space.center)
    ratio = dict(zip(space.names, space.prior_std / problem.space.prior_std, strict=True))
    assert ratio["inertia.x"] == ratio["lag_up"] == 1.0
    # Hover is at 0.62 of full command, next to the second node.
    assert 0.02 < 0.5 * ratio["thrust.65"] < 0.08
    assert np.linalg.eigvalsh(space.covariance)[0] > 0.0
    assert space.unweighed is problem.space and np.array_equal(space.initial_std, problem.space.prior_std)


def test_a_flight_at_constant_height_finds_the_hover_command(level, tmp_path):
    found = identify_roughly([level.log], noise_fits=1)
    assert not found.problem.outputs[3]
    file = tmp_path / "found.toml"
    file.write_text(identified_text(found, "found"))
    true, prior = hover_of(level.vehicle), hover_of(AIRFRAME.vehicle)
    assert abs(prior / true - 1.0) > 0.05
    assert abs(hover_of(load(file).vehicle) / true - 1.0) < 0.03
    apart = misses(found, level)
    assert max(abs(apart[name]) for name in THRUSTS) < 2.5
    # A thrust counts as identified where its interval is half of the prior's.
    ratio = dict(zip(found.space.names, np.sqrt(np.diag(found.fit.covariance)) / found.space.initial_std, strict=True))
    assert (
        [name for name in THRUSTS if ratio[name] > 0.5]
        == [name for name in THRUSTS if name in found.wider]
        == ["thrust.30", "thrust.100"]
    )


def test_a_flight_too_short_for_held_out_windows_says_so(tmp_path, monkeypatch):
    """Its windows gave NaN, which the document refused with a traceback."""
    monkeypatch.setattr(fit, "MAX_NOISE_FITS", 1)
    page = tmp_path / "page.html"
    found = identify(f"{CRAZYFLIE}@71:76", airframe="crazyflie-pybullet", report=page)
    assert found.document.prediction == []
    assert "no flight without a pause lasts 5.5 s" in found.document.verdict
    assert "nothing predicted" in page.read_text()
    with pytest.raises(InputError, match="nothing for the figure"):
        found.figure()


@pytest.mark.parametrize(("rate", "is_usable"), [(10.0, False), (60.0, True)])
def test_commands_that_a_logger_held_are_named(rate, is_usable):
    log = read_log(CRAZYFLIE)
    held = np.searchsorted(log.time, np.floor(log.time * rate) / rate)
    checked = check_logs(replace(log, command=log.command[held]), airframe="crazyflie-pybullet")
    assert checked.usable is is_usable
    assert any(f"motor commands change {rate:.0f} times a second" in row.text for row in checked.document.findings)
    assert not any(
        "motor commands change" in row.text for row in check_logs(log, airframe="crazyflie-pybullet").document.findings
    )
