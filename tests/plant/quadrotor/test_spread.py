"""How far the vehicles that fly are from the nominal one: unshifted draws keep their bits, shifts and centres do what they say."""

from math import sqrt

import numpy as np
import pytest
from scipy.stats import kstest

from objectives.margins.margins import spread_corners
from plant.errors import InputError
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.closed_loop import hover_body
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.nominal import ControlOptions, arm_of, nominal, shift_center_of_mass, vary
from plant.quadrotor.rigid_body import Dynamics, body_rate, dynamics
from plant.quadrotor.scenarios import SEARCH, ScenarioSpec, Spread, draw_vehicle, sample_scenarios
from plant.records import pack, paths, size
from plant.seeds import generator

HUMMINGBIRD = load("hummingbird").vehicle
TIMING = Timing(0.004, 0.001)
# Bits of two vehicles of Spread(mass=0.1, inertia=0.2, thrust=0.05, lag=0.3), root 7, before there were shifts.
RECORDED = {
    0: ("0x1.741e625c20682p+0", "0x1.43b3712230346p+8", "0x1.d8c9e46bc04eap-18", "0x1.7af80baeff84ap+5"),
    17: ("0x1.81b0e6e0aa00ep+0", "0x1.4d63451593c1dp+8", "0x1.bb473ebf2bf97p-18", "0x1.342b97e48b61fp+5"),
}
COLUMNS = [paths(Dynamics).index(key) for key in ("inverse_mass", "inverse_inertia.x", "thrust_coefficient", "rise")]


def drawn(spread, count):
    return [draw_vehicle(spread, HUMMINGBIRD, generator(7, "vehicles", i)) for i in range(count)]


@pytest.mark.parametrize("spread", [Spread(0.1, 0.2, 0.05, 0.3), Spread(0.1, 0.2, 0.05, 0.3, centre=0.1)])
def test_what_was_drawn_before_is_drawn_again_to_the_bit(spread):
    spec = ScenarioSpec("test", 0.1, spread=spread)
    for index, bits in RECORDED.items():
        rows = sample_scenarios(spec, HUMMINGBIRD, TIMING, 7, SEARCH, [index]).dynamics[0, :, 0]
        assert tuple(float(rows[column]).hex() for column in COLUMNS) == bits
        placed = rows[[paths(Dynamics).index(f"rotor_x.r{i}") for i in (1, 2, 3, 4)]]
        assert np.array_equal(placed, HUMMINGBIRD.rotor_x) == (spread.centre == 0.0)


def test_no_spread_is_the_nominal_vehicle_to_the_bit():
    assert drawn(Spread(), 3) == [HUMMINGBIRD] * 3


def test_a_payload_is_uniform_between_nothing_and_all_of_it():
    """Against the uniform distribution by the Kolmogorov-Smirnov test; 1e-3: a right sampler fails once in a thousand seeds."""
    vehicles = drawn(Spread(mass=0.15, mass_shift=0.15, thrust=0.15, thrust_shift=-0.15), 2000)
    payload = np.array([vehicle.mass for vehicle in vehicles]) / HUMMINGBIRD.mass - 1.0
    sag = 1.0 - np.array([vehicle.thrust_coefficient for vehicle in vehicles]) / HUMMINGBIRD.thrust_coefficient
    for share in (payload, sag):
        assert kstest(share / 0.3, "uniform").pvalue > 1e-3
    # Of 2000 independent pairs the correlation has a standard deviation of 1/sqrt(2000).
    assert abs(np.corrcoef(payload, sag)[0, 1]) < 4.0 / sqrt(2000)
    assert {vehicle.inertia for vehicle in vehicles} == {HUMMINGBIRD.inertia}


def test_a_shift_alone_is_the_same_for_every_flight():
    (vehicle,) = set(drawn(Spread(lag_shift=2.0, inertia_shift=0.5), 5))
    assert vehicle.lag_up == pytest.approx(3.0 * HUMMINGBIRD.lag_up, rel=1e-15)
    assert vehicle.lag_down == pytest.approx(3.0 * HUMMINGBIRD.lag_down, rel=1e-15)
    assert vehicle.inertia.z == pytest.approx(1.5 * HUMMINGBIRD.inertia.z, rel=1e-15)
    assert vehicle.mass == HUMMINGBIRD.mass


@pytest.mark.parametrize("name", ["hummingbird", "paper-corrected", "iris"])
def test_the_arm_is_the_distance_of_a_rotor_from_the_middle(name):
    vehicle = load(name).vehicle
    lengths = {key: number.value for key, number in load(name).sources.items()}
    expected = lengths.get("arm") or np.hypot(lengths["lever_fore_aft"], lengths["lever_side"])
    assert arm_of(vehicle) == pytest.approx(expected, rel=1e-12)
    assert arm_of(shift_center_of_mass(vehicle, 0.01, -0.02)) == pytest.approx(expected, rel=1e-12)


def test_centres_fill_a_square_of_the_asked_share_of_the_arm():
    vehicles = drawn(Spread(centre=0.05), 2000)
    for rotors in ("rotor_x", "rotor_y"):
        # The rotors' middle seen from the centre of mass is where the centre of mass is not.
        places = -np.array([np.mean(getattr(vehicle, rotors)) for vehicle in vehicles]) / (0.05 * 0.171)
        assert kstest(0.5 * (places + 1.0), "uniform").pvalue > 1e-3


def test_at_hover_the_rotors_turn_an_unbalanced_vehicle_towards_its_centre_of_mass():
    """Hover thrust is the weight m g through the rotors' middle: about a centre of mass at (x, y) its torque is m g (-y, x, 0)."""
    x, y = 0.004, -0.007
    vehicle = shift_center_of_mass(HUMMINGBIRD, x, y)
    body = hover_body(nominal(HUMMINGBIRD, ControlOptions(), TIMING.control_period))
    rate = body_rate(body, body.rotor_speed, pack(Disturbance, [0.0] * size(Disturbance)), dynamics(vehicle))
    weight, inertia = HUMMINGBIRD.mass * HUMMINGBIRD.gravity, HUMMINGBIRD.inertia
    found = (rate.rate.x * inertia.x, rate.rate.y * inertia.y, rate.rate.z * inertia.z)
    np.testing.assert_allclose(found, (-y * weight, x * weight, 0.0), rtol=1e-9, atol=1e-12)
    # Nothing else moves: it neither falls nor drifts.
    np.testing.assert_allclose(rate.velocity, 0.0, atol=1e-9)


def test_corners_are_the_ends_of_the_shifted_spread():
    corners = spread_corners(
        HUMMINGBIRD, Spread(mass=0.15, mass_shift=0.15, thrust_shift=-0.3, lag_shift=2.0, centre=0.1)
    )
    ends = [vary(HUMMINGBIRD, mass, 1.0, 0.7, 3.0) for mass in (1.0, 1.3)]
    assert len(corners) == 2
    for corner, end in zip(corners, ends, strict=True):
        np.testing.assert_allclose(
            [corner.mass, corner.thrust_coefficient, corner.lag_up],
            [end.mass, end.thrust_coefficient, end.lag_up],
            rtol=1e-12,
        )
        assert corner.rotor_x == HUMMINGBIRD.rotor_x


@pytest.mark.parametrize(
    ("given", "key", "allowed"),
    [
        ({"mass": 0.6}, "mass", "0 to 0.5"),
        ({"centre": -0.1}, "centre", "0 to 0.5"),
        ({"centre": float("nan")}, "centre", "0 to 0.5"),
        ({"thrust": 0.15, "thrust_shift": -0.7}, "thrust_shift", "with thrust = 0.15 allowed: -0.6 to 3"),
        ({"lag_shift": 3.5}, "lag_shift", "allowed: -0.75 to 3"),
        ({"inertia_shift": float("inf")}, "inertia_shift", "-0.75 to 3"),
    ],
)
def test_what_no_vehicle_has_is_refused(given, key, allowed):
    with pytest.raises(InputError, match=allowed) as caught:
        Spread(**given)
    assert caught.value.key == key
