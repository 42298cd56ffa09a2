"""The [uncertainty] of an airframe file: draws have the covariance that is written, and what no vehicle can have is refused."""

import numpy as np
import pytest

from plant.errors import InputError
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.uncertainty import NAMES, Uncertainty, can_exist
from plant.quadrotor.nominal import mixer_matrix
from plant.quadrotor.rigid_body import Dynamics
from plant.quadrotor.scenarios import HELD_OUT, SEARCH, ScenarioSpec, Spread, sample_scenarios
from plant.records import flatten, paths
from plant.seeds import generator
from plant.vectors import Vec3

VEHICLE = load("hummingbird").vehicle
TWO = Uncertainty(("mass", "lag_up"), (0.05, 0.2), ((1.0, -0.6), (-0.6, 1.0)))
TEXT = """
[uncertainty]
source = "identified from a log"
names = ["mass", "centre.x"]
deviations = [0.02, 0.001]
correlation = [[1.0, 0.5], [0.5, 1.0]]
"""


def drawn(uncertainty, count=4000):
    return [uncertainty.draw(VEHICLE, generator(3, "vehicles", i)) for i in range(count)]


def test_draws_have_the_covariance_that_is_written():
    rows = np.log([[v.mass / VEHICLE.mass, v.lag_up / VEHICLE.lag_up] for v in drawn(TWO)])
    # Standard errors at 4000 draws: 1.1 % of a deviation, 0.010 of this correlation.
    assert rows.std(axis=0) == pytest.approx([0.05, 0.2], rel=0.04)
    assert np.corrcoef(rows.T)[0, 1] == pytest.approx(-0.6, abs=0.04)
    assert {(v.lag_down, v.inertia) for v in drawn(TWO, 50)} == {(VEHICLE.lag_down, VEHICLE.inertia)}


def test_numbers_that_are_known_together_stay_together():
    names = ("inertia.x", "inertia.y")
    found = drawn(Uncertainty(names, (0.1, 0.1), ((1.0, 1.0), (1.0, 1.0))), 200)
    ratios = np.array([v.inertia.x / v.inertia.y for v in found])
    assert ratios == pytest.approx(VEHICLE.inertia.x / VEHICLE.inertia.y)


def test_a_centre_of_mass_off_the_middle_makes_thrust_turn_the_body():
    found = Uncertainty(("centre.x",), (0.01,), ((1.0,),)).moved(VEHICLE, np.array([0.01]))
    # Unit thrusts of all rotors, 1 cm behind the centre of mass on average, pitch the nose down about +y: -(-0.01) * 4.
    assert mixer_matrix(found)[2] @ np.ones(4) == pytest.approx(0.04)


def test_curve_and_dead_time_are_moved_by_their_deviations():
    """A dead time cannot be below zero, and no curve that falls is drawn."""
    both = Uncertainty(("thrust_linear", "dead_time"), (0.2, 0.004), ((1.0, -0.5), (-0.5, 1.0)))
    vehicle = VEHICLE._replace(thrust_linear=0.7, dead_time=0.02)
    found = [both.draw(vehicle, generator(3, "vehicles", i)) for i in range(2000)]
    rows = np.array([[v.thrust_linear, v.dead_time] for v in found])
    assert rows[:, 0].max() <= 1.0 and rows[:, 0].max() > 0.98
    assert np.median(rows, axis=0) == pytest.approx([0.7, 0.02], rel=0.05)
    assert rows[:, 1].std() == pytest.approx(0.004, rel=0.06)
    assert np.corrcoef(rows.T)[0, 1] == pytest.approx(-0.5, abs=0.06)
    assert both.moved(vehicle, np.array([0.0, -0.03])).dead_time == 0.0


def test_no_vehicle_is_drawn_that_cannot_exist():
    wide = Uncertainty(("inertia.z", "torque_ratio"), (0.4, 0.8), ((1.0, 0.0), (0.0, 1.0)))
    found = drawn(wide, 300)
    assert all(can_exist(vehicle) for vehicle in found)
    assert max(v.inertia.z for v in found) <= VEHICLE.inertia.x + VEHICLE.inertia.y


def test_an_uncertainty_about_a_vehicle_that_cannot_exist_is_refused():
    with pytest.raises(InputError, match="uncertainty: none of 1000 vehicles"):
        Uncertainty(("mass",), (0.1,), ((1.0,),)).draw(VEHICLE._replace(torque_ratio=1.0), generator(1, "vehicles", 0))


def test_extremes_are_two_deviations_out_along_the_principal_axes():
    ends = TWO.extremes(VEHICLE)
    rows = np.log([[v.mass / VEHICLE.mass, v.lag_up / VEHICLE.lag_up] for v in ends])
    inverse = np.linalg.inv([[0.05**2, -0.6 * 0.01], [-0.6 * 0.01, 0.2**2]])
    assert np.einsum("ij,jk,ik->i", rows, inverse, rows) == pytest.approx(np.full(4, 4.0))


def test_scenarios_draw_their_vehicles_from_it_each_a_function_of_its_number():
    spec = ScenarioSpec("test", 0.1, spread=Spread(), uncertainty=TWO)
    rows = [
        sample_scenarios(spec, VEHICLE, Timing(0.004, 0.001), 5, SEARCH, index).dynamics for index in (range(6), [4])
    ]
    mass = paths(Dynamics).index("inverse_mass")
    assert rows[0][0, mass, 4] == rows[1][0, mass, 0]
    assert len(set(rows[0][0, mass, :6].tolist())) == 6
    other = sample_scenarios(spec, VEHICLE, Timing(0.004, 0.001), 5, HELD_OUT, range(6)).dynamics
    assert not set(other[0, mass, :6].tolist()) & set(rows[0][0, mass, :6].tolist())


@pytest.fixture
def file(tmp_path):
    def write(text):
        path = tmp_path / "mine.toml"
        path.write_text(load("hummingbird").path.read_text() + text)
        return path

    return write


def test_a_curve_that_is_drawn_stands_in_the_file(file):
    """The loop of a vehicle without one has none; the deviation of the dead time is the vehicle's."""
    with pytest.raises(InputError, match="uncertainty.names: names thrust_linear, which is missing or 0"):
        load(file(TEXT.replace('"centre.x"', '"thrust_linear"')))
    assert load(file(TEXT.replace('"centre.x"', '"dead_time"'))).vehicle.dead_time_deviation == 0.001
    with pytest.raises(InputError, match="given 0.2 for dead_time; allowed: above 0, up to 0.1"):
        load(file(TEXT.replace('"centre.x"', '"dead_time"').replace("0.001", "0.2")))


def test_it_is_read_with_the_airframe(file):
    found = load(file(TEXT))
    assert found.uncertainty == Uncertainty(("mass", "centre.x"), (0.02, 0.001), ((1.0, 0.5), (0.5, 1.0)))
    assert flatten(found.vehicle) == flatten(VEHICLE)
    assert load("hummingbird").uncertainty is None


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"mass"', '"weight"', "uncertainty.names: unknown name 'weight'"),
        ('"mass"', '"centre.x"', "uncertainty.names: has a name twice"),
        ("0.02", "-0.02", "uncertainty.deviations: given -0.02 for mass"),
        ("[0.02, 0.001]", "[0.02]", "uncertainty.deviations: must be 2 finite numbers"),
        ("0.001", "nan", "uncertainty.deviations: must be 2 finite numbers"),
        ("[0.5, 1.0]", "[0.4, 1.0]", "uncertainty.correlation: is not symmetric"),
        ("0.5", "1.5", "numbers from -1 to 1"),
        ("[[1.0, 0.5], [0.5, 1.0]]", "[[1.0, 0.5]]", "a row for each of the 2 names"),
        ("correlation", "correlations", "unknown key 'correlations'"),
    ],
)
def test_what_is_wrong_is_told_with_its_key(old, new, message, file):
    with pytest.raises(InputError, match=message):
        load(file(TEXT.replace(old, new)))


def test_numbers_that_no_three_can_share_are_refused(file):
    text = TEXT.replace('"mass"', '"mass", "lag_up"').replace("[0.02,", "[0.02, 0.1,")
    rows = "[[1.0, 0.9, 0.9], [0.9, 1.0, -0.9], [0.9, -0.9, 1.0]]"
    with pytest.raises(InputError, match="has an eigenvalue of -0.8"):
        load(file(text.replace("[[1.0, 0.5], [0.5, 1.0]]", rows)))


def test_every_name_moves_the_vehicle():
    vehicle = VEHICLE._replace(rate_damping=Vec3(1e-3, 1e-3, 0.0))
    for name in NAMES:
        assert Uncertainty((name,), (0.1,), ((1.0,),)).moved(vehicle, np.array([0.1])) != vehicle
