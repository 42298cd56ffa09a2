"""Steady flight against an independent solution, and flights that start in it: nothing moves, whatever the law."""

from math import cos, degrees, radians, sin

import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from plant.air.air import COLUMNS, AirSpec, draw_air, steady_wind
from plant.backends import array
from plant.backends.stepping import fly_steps, lane_of
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.rigid_body import Body, dynamics
from plant.quadrotor.scenarios import SEARCH, ScenarioSpec, Spread, sample_scenarios
from plant.quadrotor.sensors import SensorSpec
from plant.quadrotor.trim import steady_flight, trim_of, within_limits
from plant.records import flatten, pack
from plant.seeds import generator
from tests.plant.harness import HUMMINGBIRD, TIMING, VEHICLES, H, default_gains, unmetered
from tests.plant.pilot import Period, Quadrotor

WIND = (6.0, -4.0, 0.5)
SILENT = SensorSpec(position=0.0, velocity=0.0, attitude=0.0, rate=0.0)


def independent(vehicle, wind, yaw=0.0):
    """Thrust direction (3,) and rotor speeds (4,) of steady flight, by MINPACK on the second quadrotor of the tests."""
    twin = Quadrotor(vehicle)
    hover = twin.at_rest()

    def state(unknown):
        turned = Rotation.from_euler("ZYX", [yaw, unknown[1], unknown[0]]).as_matrix()
        return np.concatenate([np.zeros(6), turned.ravel(), np.zeros(3), hover[18:] * unknown[2:]])

    def off(unknown):
        at = state(unknown)
        held = Period(at[18:], np.array(wind), np.zeros(3), np.zeros(3), np.zeros(3))
        change = twin.derivative(at, held)
        return np.concatenate([change[3:6], change[15:18]])

    found = root(off, [0.0, 0.0, 1.0, 1.0, 1.0, 1.0], tol=1e-14)
    assert np.abs(found.fun).max(axis=0) < 1e-10
    return state(found.x)


@pytest.mark.parametrize("name", VEHICLES)
def test_the_trim_agrees_with_an_independent_solution(name):
    vehicle = VEHICLES[name]._replace(rotor_x=VEHICLES[name].rotor_x._replace(r1=VEHICLES[name].rotor_x.r1 * 1.02))
    for yaw in (0.0, 0.8):
        found = trim_of(vehicle, WIND, yaw)
        wanted = independent(vehicle, WIND, yaw)
        w, x, y, z = found.body[0, 6:10]
        matrix = Rotation.from_quat([x, y, z, w]).as_matrix()
        assert found.balanced.all()
        np.testing.assert_allclose(matrix.ravel(), wanted[6:15], rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(found.body[0, 13:], wanted[18:], rtol=1e-9)
        assert cos(found.tilt[0]) == pytest.approx(wanted[14], abs=1e-9)


def test_still_air_leaves_hover_to_the_bit_and_a_gale_has_no_trim_within_limits():
    still = trim_of(HUMMINGBIRD, (0.0, 0.0, 0.0))
    know = nominal(HUMMINGBIRD, ControlOptions(), H)
    speed = np.sqrt(HUMMINGBIRD.mass * HUMMINGBIRD.gravity / 4.0 / HUMMINGBIRD.thrust_coefficient)
    np.testing.assert_allclose(still.body[0], [0.0] * 6 + [1.0] + [0.0] * 6 + [speed] * 4, rtol=4e-16, atol=0.0)
    assert within_limits(still, know).all()
    # The moderate class of MIL-F-8785C at 10 m: 17 m/s, 39 deg, beyond the limit of 30 deg.
    gale = trim_of(HUMMINGBIRD, (AirSpec(intensity="moderate").wind_speed, 0.0, 0.0))
    assert gale.balanced.all() and not within_limits(gale, know).any()
    assert degrees(gale.tilt[0]) == pytest.approx(39.0, abs=1.0)
    # 60 m/s leave no balance at all: the row falls back to level hover, and the other row does not notice.
    rows = np.repeat(
        np.array([flatten(dynamics(HUMMINGBIRD._replace(drag_quadratic=HUMMINGBIRD.drag_quadratic)))]), 2, axis=0
    )
    both = steady_flight(rows, np.array([[0.0, 0.0, 400.0], [5.0, 0.0, 0.0]]))
    assert both.balanced.tolist() == [False, True]
    np.testing.assert_array_equal(both.body[1], trim_of(HUMMINGBIRD, (5.0, 0.0, 0.0)).body[0])


def test_the_mean_wind_of_a_scenario_is_what_its_air_blows():
    air = AirSpec(intensity="light", window=(1.0, 2.0))
    for index in range(5):
        wind = steady_wind(air, generator(3, "a", index))
        drawn = np.empty((10, COLUMNS))
        draw_air(air, H, generator(3, "a", index), drawn)
        np.testing.assert_allclose(drawn[:, :3], np.broadcast_to(wind, (10, 3)), rtol=1e-13)
    assert not steady_wind(AirSpec(intensity="light", mean_wind=False), generator(3, "a", 0)).any()


# One law of a pair closes the position loops, the other those of attitude; laws that keep no promise are left out, for they
# do not come to rest anywhere.
TWISTING = {"supertwisting", "hybrid_true_sta", "hybrid_gsta"}
STEADY = [name for name, law in LAWS.items() if "rejects" in law.promises]


CONTROLLERS = [(True, False, 0.0), (False, True, 2.0)]
PAIRS = list(zip(STEADY, STEADY[1:] + STEADY[:1], strict=True))
# Controllers take turns from pair to pair; each law is in two pairs, and so has both. The others are proofs.
STARTS = [
    pytest.param(*pair, *options, marks=() if (place + turn) % 2 == 0 else pytest.mark.slow)
    for turn, options in enumerate(CONTROLLERS)
    for place, pair in enumerate(PAIRS)
]


@pytest.mark.parametrize(("position", "attitude", "lag_aware", "delay", "cutoff"), STARTS)
def test_a_flight_in_steady_wind_starts_in_its_trim_and_stays_there(position, attitude, lag_aware, delay, cutoff):
    # Seen after 1 s: 1e-13 for laws that are smooth at rest. A sampled super-twisting term has a gain of 2/h there, with which
    # rotor lag makes it tremble (0.4 mm, 0.4 rad/s in yaw); a start in level hover is blown 0.05 m away in the quarter of a second here.
    spec = ScenarioSpec(
        "trim",
        0.25,
        air=AirSpec(intensity=6.0, mean_wind=True, window=(20.0, 21.0)),
        sensors=SILENT,
        spread=Spread(mass=0.15, inertia=0.1, thrust=0.1, lag=0.2, centre=0.05),
    )
    drawn = sample_scenarios(spec, HUMMINGBIRD, TIMING, 5, SEARCH, range(4))
    loop, trembles = unmetered(position, attitude), bool(TWISTING & {position, attitude})
    # A low-pass in front of a term that trembles makes it swing; it is for the others here.
    options = ControlOptions(lag_aware=lag_aware, delay=delay, yaw_torque_cutoff=0.0 if trembles else cutoff)
    limits = Limits(5.0, cos(radians(80.0)))
    with np.errstate(all="ignore"):
        flight = fly_steps(
            loop,
            array.rebinder(),
            default_gains(loop),
            nominal(HUMMINGBIRD, options, H),
            lane_of(drawn, slice(None)),
            drawn.targets,
            limits,
            Timing(H, 0.001),
        )
    begun = drawn.starts[0]
    ended = np.stack([np.broadcast_to(part, begun.shape[1]) for part in flatten(flight.body)])
    tilt = np.arccos(1.0 - 2.0 * (begun[7] ** 2 + begun[8] ** 2))
    assert tilt.min(axis=0) > radians(5.0)  # the wind is felt
    assert np.ptp(begun[13:], axis=1).min(axis=0) > 1.0  # and the vehicles differ
    np.testing.assert_allclose(ended[:3], begun[:3], rtol=0.0, atol=2e-3 if trembles else 1e-10)
    np.testing.assert_allclose(ended[3:13], begun[3:13], rtol=0.0, atol=0.4 if trembles else 1e-10)


def test_a_flight_that_does_not_hold_its_place_starts_level():
    from plant.references.level import Level

    spec = ScenarioSpec("level", 1.0, reference=Level(), air=AirSpec(intensity="light", mean_wind=True))
    body = pack(Body, sample_scenarios(spec, HUMMINGBIRD, TIMING, 5, SEARCH, [0]).starts[0, :, 0].tolist())
    assert (body.attitude.x, body.attitude.y) == (0.0, 0.0)


def test_default_gains_hold_the_light_class_that_the_studies_fly():
    """Trim of every airframe that a study flies with a mean wind stays well inside the usual tilt limit."""
    for name in ("hummingbird", "f450", "iris"):
        vehicle = load(name).vehicle
        speed = AirSpec(intensity="light").wind_speed
        found = trim_of(vehicle, (speed * cos(0.3), speed * sin(0.3), 0.0))
        assert degrees(found.tilt[0]) < 21.0
        assert within_limits(found, nominal(vehicle, ControlOptions(), H)).all()
